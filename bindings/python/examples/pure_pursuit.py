#!/usr/bin/env python3
"""A nominal controller for the unicycle: pure pursuit of the goal. It is blind to obstacles; the filter is not.

    cncbf run --controller external &
    python pure_pursuit.py

Started beside another nominal controller, it waits and takes over once that one has gone. It answers robot states as they come,
20 times a second at most.
"""

from __future__ import annotations

import argparse
import logging
import math

import cncbf

#: Who this is, in recordings: external controllers choose a number from 1000 on.
CONTROLLER = 1000
#: A robot state older than this is not answered, ns. The filter brakes on silence.
MAX_STATE_AGE_NS = 100_000_000
#: What the next robot state may be early by, ns.
EARLY_NS = 1_000_000
#: Who has reached the goal drives on only when this many tolerances away.
RELEASE_TOLERANCES = 2.0


def pursue(state: cncbf.RobotState, goal: cncbf.Goal, args: argparse.Namespace) -> tuple[float, float]:
    """Speed, m/s, and yaw rate, rad/s, along the circle through a point ahead on the way to the goal."""
    dx = goal.position_in_odom_m[0] - state.position_in_odom_m[0]
    dy = goal.position_in_odom_m[1] - state.position_in_odom_m[1]
    bearing = math.remainder(math.atan2(dy, dx) - state.heading_rad, math.tau)
    ahead = max(min(math.hypot(dx, dy), args.lookahead), 1e-3)
    # Behind the robot the circle would become a straight line again: turn as for a point at its side.
    side = math.sin(bearing) if abs(bearing) < math.pi / 2 else math.copysign(1.0, bearing)
    curvature = 2.0 * side / ahead
    speed = min(args.speed, args.max_yaw_rate / abs(curvature)) if curvature else args.speed
    speed = max(speed, args.min_speed)
    return speed, max(-args.max_yaw_rate, min(args.max_yaw_rate, speed * curvature))


def distance(state: cncbf.RobotState, goal: cncbf.Goal) -> float:
    """From the robot to its goal, m."""
    return math.dist(state.position_in_odom_m, goal.position_in_odom_m)


def is_fresh(state: cncbf.RobotState, now_ns: int) -> bool:
    """Whether a state may be answered."""
    return abs(now_ns - state.stamp.valid_at_ns) <= MAX_STATE_AGE_NS


def main() -> int:
    """Drives until told to stop."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--instance", default="cncbf", help="name of the stack")
    parser.add_argument("--speed", type=float, default=1.0, help="cruising speed, m/s")
    parser.add_argument("--min-speed", type=float, default=0.25, help="speed of the tightest turn, m/s")
    parser.add_argument("--max-yaw-rate", type=float, default=0.8, help="rad/s")
    parser.add_argument("--lookahead", type=float, default=1.5, help="distance of the point ahead, m")
    parser.add_argument("--tolerance", type=float, default=0.3, help="closer than this the goal is reached, m")
    parser.add_argument("--period", type=float, default=0.05, help="s")
    args = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="pure_pursuit: %(message)s")
    stop = cncbf.Stop()
    with cncbf.Node("nominal_python", args.instance) as node:
        try:
            states = node.subscriber(cncbf.RobotState, stop=stop)
            goals = node.subscriber(cncbf.Goal, stop=stop)
            commands = node.publisher(cncbf.NominalCommand, stop=stop)
            wake_up = node.wake_up(stop=stop)
        except cncbf.PortUnavailable as unavailable:
            logging.info("%s", unavailable)
            return 0 if stop.requested else 1
        logging.info("commands")
        drive(args, stop, wake_up, states, goals, commands)
    return 0


def drive(
    args: argparse.Namespace,
    stop: cncbf.Stop,
    wake_up: cncbf.WakeUp,
    states: cncbf.Subscriber[cncbf.RobotState],
    goals: cncbf.Subscriber[cncbf.Goal],
    commands: cncbf.Publisher[cncbf.NominalCommand],
) -> None:
    """The control loop."""
    state = goal = None
    received_ns = sequence = due_ns = 0
    tolerance = args.tolerance
    period_ns = round(args.period * 1e9)
    while not stop.requested:
        newer = states.newest()
        goal = goals.newest() or goal
        # Only now: a state that came after the clock was read would be from the future.
        now_ns = cncbf.now_ns()
        if newer is not None:
            state, received_ns = newer, now_ns
        if state is None or goal is None or now_ns < due_ns or not is_fresh(state, now_ns):
            wake_up.wait(now_ns + period_ns)
            continue
        # A little less than a period, for the next state may come a little early.
        due_ns = now_ns + period_ns - EARLY_NS
        arrived = distance(state, goal) <= tolerance
        tolerance = RELEASE_TOLERANCES * args.tolerance if arrived else args.tolerance
        control = (0.0, 0.0) if arrived else pursue(state, goal, args)
        sequence += 1
        command = cncbf.NominalCommand(
            stamp=state.stamp,
            bridge_published_ns=state.stamp.published_ns,
            received_ns=received_ns,
            control=control,
            control_kind=cncbf.ControlKind.UNICYCLE,
            intent=cncbf.Intent.STOP if arrived else cncbf.Intent.DRIVE,
            controller=CONTROLLER,
        )
        command.stamp.sequence = sequence
        command.stamp.published_ns = cncbf.now_ns()
        commands.send(command)


if __name__ == "__main__":
    raise SystemExit(main())
