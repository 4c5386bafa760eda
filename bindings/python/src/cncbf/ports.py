"""Ports on the services of a running stack, over PyPI's `iceoryx2`.

Services are opened, never created: the stack's own processes create them with the limits they need, and a port waits until
they have.
"""

from __future__ import annotations

import ctypes
import logging
import os
import time
from collections.abc import Iterator
from typing import Any, Callable, Generic, Optional, TypeVar

import iceoryx2 as iox2

from .loop import Stop, now_ns

_LOG = logging.getLogger("cncbf")
#: Queue of a subscriber, messages: for who wants the newest few.
_QUEUE = 8
#: Pause between two tries to get a place, s. A swap of controllers takes no longer than this and the other's farewell.
_RETRY_S = 0.002
#: Pause between two looks for places of the dead, s.
_SWEEP_S = 0.04
#: Environment variable that names the group of stacks, as for the processes.
_PREFIX_VARIABLE = "CNCBF_IPC_PREFIX"

Message = TypeVar("Message", bound=ctypes.Structure)


#: The event by which the bridge wakes the nominal controller.
_WAKE_UP = "wake/nominal"
#: What another try may cure.
_REFUSALS = (
    iox2.PublishSubscribeOpenError,
    iox2.PublisherCreateError,
    iox2.SubscriberCreateError,
    iox2.EventOpenError,
    iox2.ListenerCreateError,
)


class PortUnavailable(Exception):
    """A port could not be had; the text says why and what to do."""


class _OtherType(Exception):
    """The service carries another type."""


class Node:
    """This program's membership in the stack `instance`. Ports live as long as it does; use it with `with`."""

    def __init__(self, name: str, instance: str = "cncbf") -> None:
        iox2.set_log_level_from_env_or(iox2.LogLevel.Error)
        config = iox2.config.default()
        prefix = os.environ.get(_PREFIX_VARIABLE)
        if prefix:
            config.global_cfg.prefix = iox2.FileName.new(prefix if prefix.endswith("_") else prefix + "_")
        self._instance = instance
        self._ports: list[Any] = []
        self._node = (
            iox2.NodeBuilder.new()
            .name(iox2.NodeName.new(f"{instance}/{name}"))
            .config(config)
            .signal_handling_mode(iox2.SignalHandlingMode.Disabled)
            .create(iox2.ServiceType.Ipc)
        )

    def __enter__(self) -> Node:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Gives every port back, the last one first, and the membership."""
        while self._ports:
            self._ports.pop().delete()
        self._node = None

    def subscriber(
        self, message: type[Message], patience_s: Optional[float] = None, stop: Optional[Stop] = None
    ) -> Subscriber[Message]:
        """Reads the service of `message`.

        Waits until the service exists, `patience_s` seconds or without end, or until `stop`.

        Raises `PortUnavailable`: the service has another type, or time is up.
        """

        def attempt() -> Any:
            return self._service(message).subscriber_builder().buffer_size(_QUEUE).create()

        return Subscriber(message, self._patiently(message, attempt, patience_s, stop))

    def publisher(
        self, message: type[Message], patience_s: Optional[float] = None, stop: Optional[Stop] = None
    ) -> Publisher[Message]:
        """Becomes the writer of the service of `message`. A service has one writer.

        Waits until the service exists and its place is free, `patience_s` seconds or without end, or until `stop`: who
        starts beside the controller it shall follow takes over once that one has gone.

        Raises `PortUnavailable`: the service has another type, or time is up.
        """

        def attempt() -> Any:
            return self._service(message).publisher_builder().create()

        return Publisher(self._patiently(message, attempt, patience_s, stop))

    def wake_up(self, patience_s: Optional[float] = None, stop: Optional[Stop] = None) -> WakeUp:
        """Becomes the one whom the bridge wakes with each robot state: for who has the nominal controller's place, of which there
        is one as well. Open it after the publisher, so that who follows finds it free.

        Waits and raises as `publisher` does.
        """
        name = f"{self._instance}/{_WAKE_UP}"

        def attempt() -> Any:
            service = self._node.service_builder(iox2.ServiceName.new(name)).event().open()
            return service.listener_builder().create()

        return WakeUp(self._kept(name, attempt, patience_s, stop))

    def _service(self, message: type[Message]) -> Any:
        name = iox2.ServiceName.new(f"{self._instance}/{message.SERVICE}")
        return self._node.service_builder(name).publish_subscribe(message).open()

    def _patiently(
        self,
        message: type[Message],
        attempt: Callable[[], Any],
        patience_s: Optional[float],
        stop: Optional[Stop],
    ) -> Any:
        try:
            return self._kept(f"{self._instance}/{message.SERVICE}", attempt, patience_s, stop)
        except _OtherType as other:
            raise PortUnavailable(
                f"{other} carries another type than {message.TYPE_NAME}: the stack is of another version; "
                "install the bindings that belong to it"
            ) from None

    def _kept(
        self, name: str, attempt: Callable[[], Any], patience_s: Optional[float], stop: Optional[Stop]
    ) -> Any:
        """Tries until there is a port, which is deleted when this node is closed."""
        began = swept = time.monotonic()
        said = None
        while True:
            try:
                port = attempt()
            except _REFUSALS as error:
                cause = str(error)
            else:
                self._ports.append(port)
                return port
            if "IncompatibleTypes" in cause:
                raise _OtherType(name)
            now = time.monotonic()
            if stop is not None and stop.requested:
                raise PortUnavailable(f"no place on {name} until the wish to stop ({cause})")
            if patience_s is not None and now - began >= patience_s:
                raise PortUnavailable(f"{_reason(name, cause)}; waited {patience_s} s ({cause})")
            if said != cause:
                said = cause
                _LOG.warning("%s; waiting (%s)", _reason(name, cause), cause)
            if now - swept >= _SWEEP_S:
                swept = now
                self._node.try_cleanup_dead_nodes()
            time.sleep(_RETRY_S)


def _reason(name: str, cause: str) -> str:
    """Why there is no place on the service `name`, in words: nobody has made it yet, or another program has the place."""
    if "DoesNotExist" in cause:
        return f"no stack offers {name} yet (is one running, under this name and {_PREFIX_VARIABLE}?)"
    if "ExceedsMax" in cause:
        return f"another program has the place on {name}, which is free when that one ends"
    return f"no place on {name}"


class Subscriber(Generic[Message]):
    """Reads one service. What it returns are copies, to be kept as long as wished."""

    def __init__(self, message: type[Message], port: Any) -> None:
        self._message = message
        self._port = port

    def drain(self) -> Iterator[Message]:
        """Everything that has arrived, oldest first; of more than eight the newest eight."""
        while (sample := self._port.receive()) is not None:
            copy = self._message()
            ctypes.pointer(copy)[0] = sample.payload().contents
            sample.delete()
            yield copy

    def newest(self) -> Optional[Message]:
        """The newest message that has arrived since the last call; `None` if there is none."""
        newest = None
        for message in self.drain():
            newest = message
        return newest


class Publisher(Generic[Message]):
    """Writes one service."""

    def __init__(self, port: Any) -> None:
        self._port = port

    def send(self, message: Message) -> None:
        """Hands a copy of the message over."""
        self._port.loan_uninit().write_payload(message).send()


class WakeUp:
    """Sleeps until the bridge has sent a robot state."""

    def __init__(self, port: Any) -> None:
        self._port = port

    def wait(self, until_ns: int) -> bool:
        """Sleeps until a robot state has come, until the stack clock shows `until_ns`, or until a signal. Whether one has come;
        several since the last call count as one.
        """
        remaining_ns = until_ns - now_ns()
        try:
            if remaining_ns <= 0:
                return bool(self._port.try_wait())
            return bool(self._port.timed_wait(iox2.Duration.from_nanos(remaining_ns)))
        except iox2.ListenerWaitError:
            # A signal; the caller looks at its `Stop`.
            return False
