"""Messages and ports of cncbf: for nominal controllers in Python, and for programs that watch the filter.

    import cncbf

    stop = cncbf.Stop()
    with cncbf.Node("my_controller") as node:
        states = node.subscriber(cncbf.RobotState)
        commands = node.publisher(cncbf.NominalCommand, stop=stop)
        for _ in cncbf.ticks(0.05, stop):
            state = states.newest()
            ...
            commands.send(command)
"""

from . import messages
from .loop import Stop, now_ns, ticks
from .messages import *  # noqa: F403
from .ports import Node, PortUnavailable, Publisher, Subscriber

__all__ = [*messages.__all__, "Node", "PortUnavailable", "Publisher", "Stop", "Subscriber", "now_ns", "ticks"]
