#!/usr/bin/env python3
"""Prints what the filter of a running stack does, five times a second: barrier value, correction, rung and reason."""

from __future__ import annotations

import argparse
import math

import cncbf


def main() -> int:
    """Watches until told to stop."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--instance", default="cncbf", help="name of the stack")
    parser.add_argument("--seconds", type=float, default=math.inf, help="how long [default: until Ctrl-C]")
    args = parser.parse_args()
    stop = cncbf.Stop()
    with cncbf.Node("watch_python", args.instance) as node:
        try:
            commands = node.subscriber(cncbf.SafeCommand, stop=stop)
        except cncbf.PortUnavailable as unavailable:
            print(unavailable)
            return 0 if stop.requested else 1
        began_ns = cncbf.now_ns()
        for now_ns in cncbf.ticks(0.2, stop):
            if now_ns - began_ns > args.seconds * 1e9:
                break
            command = commands.newest()
            if command is None:
                print("no command", flush=True)
                continue
            correction = math.dist(command.control, command.nominal)
            status = cncbf.label_of(cncbf.SafetyStatus, command.status)
            reason = cncbf.label_of(cncbf.Reason, command.reason)
            print(
                f"{command.sequence:7d}  h {command.h_m:6.2f} m  clearance {command.sdf_m:6.2f} m  "
                f"u [{command.control[0]:+.2f}, {command.control[1]:+.2f}]  corrected by {correction:.2f}  "
                f"{status} ({reason})",
                flush=True,
            )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
