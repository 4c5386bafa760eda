"""Judge of every ROS 2 message of the stack, made of CycloneDDS alone: the peer in perception_bridge/tests/ros2_messages.rs.

For every type it publishes one message in which no two fields are alike on rt/judge/TYPE, until the stack has sent it back on
rt/stack/TYPE, and compares what came back with what it sent. It prints one line of JSON: what it sent, field by field, and the
types that did not come back or came back changed. One message holds 400 detections, more than a datagram takes.

    python ros2_echo.py --domain 42 --seconds 60 [--best-effort]
"""

import argparse
import dataclasses
import json
import os
import time
import typing

os.environ["CYCLONEDDS_URI"] = """<CycloneDDS><Domain id="any">
 <General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces><AllowMulticast>false</AllowMulticast></General>
 <Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>11</MaxAutoParticipantIndex>
  <Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>"""

from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

import ros2_types as ros

TYPES = [
    ros.Odometry, ros.PoseStamped, ros.PoseArray, ros.TFMessage, ros.Detection3DArray, ros.TrackedObjects, ros.People,
    ros.ObjectArray, ros.Agents, ros.Agents1, ros.ObstacleArray, ros.MarkerArray, ros.Path, ros.Clock, ros.Twist, ros.TwistStamped,
    ros.DiagnosticArray,
]
CROWD = 400
PERIOD_S = 0.3


class Filler:
    """Values that do not repeat, all exact in the precision of their field."""

    def __init__(self, length=2):
        self.count, self.length = 0, length

    def of(self, kind, length=None):
        self.count += 1
        if dataclasses.is_dataclass(kind):
            hints = typing.get_type_hints(kind, include_extras=True)
            return kind(**{field.name: self.of(hints[field.name]) for field in dataclasses.fields(kind)})
        if kind is bool:
            return self.count % 2 == 0
        if kind is str:
            # Of every length modulo 8, so that what follows is padded in every way; one is empty.
            return ("x" * (self.count % 9) + str(self.count))[: None if self.count % 11 else 0]
        name = kind.__metadata__[0]
        if isinstance(name, str):
            if name.startswith("float"):
                return self.count / 8 - 3.0
            return self.count % 100 - (50 if name.startswith("int") else 0)
        fixed = getattr(name, "length", None)
        return [self.of(name.subtype) for _ in range(fixed or self.length)]


def crowd():
    """400 boxes, each with a name of its own."""
    filler = Filler(1)
    boxes = [filler.of(ros.Detection3D) for _ in range(CROWD)]
    return ros.Detection3DArray(ros.Header(ros.Time(7, 8), "crowd"), boxes)


def plain(value):
    """As JSON has it."""
    if dataclasses.is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, (list, tuple, bytes, bytearray)):
        return [plain(item) for item in value]
    return value


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--domain", type=int, required=True)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--best-effort", action="store_true")
    asked = parser.parse_args()
    participant = DomainParticipant(asked.domain)
    profile = ros.profile(reliable=not asked.best_effort, depth=1)
    sent = {kind.__name__: Filler().of(kind) for kind in TYPES} | {"Crowd": crowd()}
    ports = {}
    for name, message in sent.items():
        topics = [Topic(participant, f"rt/{end}/{name}", type(message), qos=profile) for end in ("judge", "stack")]
        ports[name] = DataWriter(participant, topics[0], qos=profile), DataReader(participant, topics[1], qos=profile)
    awaited, changed = set(ports), {}
    end = time.monotonic() + asked.seconds
    while awaited and time.monotonic() < end:
        for name in sorted(awaited):
            writer, reader = ports[name]
            for message in reader.take(N=10):
                if isinstance(message, IdlStruct):
                    awaited.discard(name)
                    if plain(message) != plain(sent[name]):
                        changed[name] = plain(message)
            if name in awaited:
                writer.write(sent[name])
        time.sleep(PERIOD_S)
    print(json.dumps({
        "sent": {name: plain(message) for name, message in sent.items()},
        "missing": sorted(awaited),
        "changed": changed,
    }))


if __name__ == "__main__":
    main()
