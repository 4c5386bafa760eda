"""Messages and ports of cncbf: for nominal controllers in Python, and for programs that watch the filter.

    import cncbf

    stop = cncbf.Stop()
    with cncbf.Node("my_controller") as node:
        states = node.subscriber(cncbf.RobotState, stop=stop)
        commands = node.publisher(cncbf.NominalCommand, stop=stop)
        wake_up = node.wake_up(stop=stop)
        while not stop.requested:
            wake_up.wait(cncbf.now_ns() + 50_000_000)
            state = states.newest()
            ...
            commands.send(command)
"""

from . import messages
from .loop import Stop, now_ns, ticks
from .messages import *  # noqa: F403
from .ports import Node, PortUnavailable, Publisher, Subscriber, WakeUp

__all__ = [
    *messages.__all__,
    "Node",
    "PortUnavailable",
    "Publisher",
    "Stop",
    "Subscriber",
    "WakeUp",
    "now_ns",
    "ticks",
]
