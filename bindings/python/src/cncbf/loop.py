"""Time and the end of time: the stack clock, a periodic loop, a wish to stop."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import time
from collections.abc import Iterator
from types import FrameType
from typing import Optional


def now_ns() -> int:
    """The stack clock (`CLOCK_MONOTONIC`), ns: what stamps are made of."""
    return time.monotonic_ns()


class Stop:
    """Whether somebody wants this program to end: Ctrl-C, SIGTERM, or a call of `request`.

    Make it before a `Node`, in the main thread. A program that ends by itself gives its place on a service back at once; one
    that is killed leaves the place taken until somebody cleans up.
    """

    def __init__(self) -> None:
        #: Whether the wish has been heard.
        self.requested = False
        self._told, self._tell = os.pipe()
        os.set_blocking(self._tell, False)
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self.request)

    def request(self, _number: Optional[int] = None, _frame: Optional[FrameType] = None) -> None:
        """Asks the program to end."""
        self.requested = True
        # A full pipe has told already.
        with contextlib.suppress(BlockingIOError):
            os.write(self._tell, b".")

    def sleep(self, duration_s: float) -> None:
        """Sleeps, but no longer than until the wish to stop."""
        select.select([self._told], [], [], max(duration_s, 0.0))


def ticks(period_s: float, stop: Optional[Stop] = None) -> Iterator[int]:
    """Yields the stack clock at once and then every `period_s`, until `stop` is requested.

    Due times lie on a fixed grid; those that passed while the loop was busy are left out, never caught up with.
    """
    period_ns = round(period_s * 1e9)
    due_ns = now_ns()
    while stop is None or not stop.requested:
        now = now_ns()
        if now >= due_ns:
            due_ns += period_ns * (1 + (now - due_ns) // period_ns)
            yield now
        else:
            sleep = time.sleep if stop is None else stop.sleep
            sleep((due_ns - now) * 1e-9)
