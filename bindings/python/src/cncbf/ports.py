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
from typing import Callable, Generic, Optional, TypeVar

import iceoryx2 as iox2

from .loop import Stop

_LOG = logging.getLogger("cncbf")
#: Queue of a subscriber, messages: for who wants the newest few.
_QUEUE = 8
#: Pause between two tries to get a place, s. A swap of controllers takes no longer than this and the other's farewell.
_RETRY_S = 0.005
#: Pause between two looks for places of the dead, s.
_SWEEP_S = 0.1
#: Environment variable that names the group of stacks, as for the processes.
_PREFIX_VARIABLE = "CNCBF_IPC_PREFIX"

Message = TypeVar("Message", bound=ctypes.Structure)
Port = TypeVar("Port")


class PortUnavailable(Exception):
    """A port could not be had; the text says why and what to do."""


class Node:
    """This program's membership in the stack `instance`. Ports live as long as it does; use it with `with`."""

    def __init__(self, name: str, instance: str = "cncbf") -> None:
        iox2.set_log_level_from_env_or(iox2.LogLevel.Error)
        config = iox2.config.default()
        prefix = os.environ.get(_PREFIX_VARIABLE)
        if prefix:
            config.global_cfg.prefix = iox2.FileName.new(prefix if prefix.endswith("_") else prefix + "_")
        self._instance = instance
        self._ports: list = []
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
        """Gives every port back, and the membership."""
        for port in self._ports:
            port.delete()
        self._ports.clear()
        self._node = None

    def subscriber(
        self, message: type[Message], patience_s: Optional[float] = None, stop: Optional[Stop] = None
    ) -> Subscriber[Message]:
        """Reads the service of `message`.

        Waits until the service exists, `patience_s` seconds or without end, or until `stop`.

        Raises `PortUnavailable`: the service has another type, or time is up.
        """

        def attempt() -> object:
            return self._service(message).subscriber_builder().buffer_size(_QUEUE).create()

        port = self._patiently(message, attempt, patience_s, stop)
        self._ports.append(port)
        return Subscriber(message, port)

    def publisher(
        self, message: type[Message], patience_s: Optional[float] = None, stop: Optional[Stop] = None
    ) -> Publisher[Message]:
        """Becomes the writer of the service of `message`. A service has one writer.

        Waits until the service exists and its place is free, `patience_s` seconds or without end, or until `stop`: who
        starts beside the controller it shall follow takes over once that one has gone.

        Raises `PortUnavailable`: the service has another type, or time is up.
        """

        def attempt() -> object:
            return self._service(message).publisher_builder().create()

        port = self._patiently(message, attempt, patience_s, stop)
        self._ports.append(port)
        return Publisher(port)

    def _service(self, message: type[Message]) -> object:
        name = iox2.ServiceName.new(f"{self._instance}/{message.SERVICE}")
        return self._node.service_builder(name).publish_subscribe(message).open()

    def _patiently(
        self,
        message: type[Message],
        attempt: Callable[[], Port],
        patience_s: Optional[float],
        stop: Optional[Stop],
    ) -> Port:
        name = f"{self._instance}/{message.SERVICE}"
        began = swept = time.monotonic()
        said = None
        while True:
            try:
                return attempt()
            except (
                iox2.PublishSubscribeOpenError,
                iox2.PublisherCreateError,
                iox2.SubscriberCreateError,
            ) as error:
                cause = str(error)
            if "IncompatibleTypes" in cause:
                raise PortUnavailable(
                    f"{name} carries another type than {message.TYPE_NAME}: the stack is of another version; "
                    "install the bindings that belong to it"
                )
            now = time.monotonic()
            if stop is not None and stop.requested:
                raise PortUnavailable(f"no place on {name} until the wish to stop ({cause})")
            if patience_s is not None and now - began >= patience_s:
                raise PortUnavailable(
                    f"no place on {name} ({cause}); does the stack run, and has the other writer gone?"
                )
            if said != cause:
                said = cause
                _LOG.info("waiting for a place on %s: %s", name, cause)
            if now - swept >= _SWEEP_S:
                swept = now
                self._node.try_cleanup_dead_nodes()
            time.sleep(_RETRY_S)


class Subscriber(Generic[Message]):
    """Reads one service. What it returns are copies, to be kept as long as wished."""

    def __init__(self, message: type[Message], port: object) -> None:
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

    def __init__(self, port: object) -> None:
        self._port = port

    def send(self, message: Message) -> None:
        """Hands a copy of the message over."""
        self._port.loan_uninit().write_payload(message).send()
