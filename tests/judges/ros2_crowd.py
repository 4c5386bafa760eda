"""A crowd of 400 in one message, and garbage among good messages: the peer of a test in tests/ros2_inputs.rs.

It says once where its camera is, latched, prints `begun`, and then publishes /odom at 50 Hz and /detections at 10 Hz in the camera's
frame. Now and then both topics carry what another definition of their type would: too short, or with a length that is not there.

    python ros2_crowd.py --domain 42 --seconds 30
"""

import argparse
import math
import os
import time
from dataclasses import dataclass

os.environ["CYCLONEDDS_URI"] = """<CycloneDDS><Domain id="any">
 <General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces><AllowMulticast>false</AllowMulticast></General>
 <Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>11</MaxAutoParticipantIndex>
  <Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>"""

from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import uint32
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic

import ros2_types as ros

CROWD = 400
GAP_M = 0.05


def short(package, name):
    """The type of that name with one number in it."""

    @dataclass
    @final
    class Short(IdlStruct, typename=ros.dds_name(package, name)):
        value: uint32 = 7

    return Short


def endless(package, name):
    """The type of that name whose text, or list, has four thousand million parts."""

    @dataclass
    @final
    class Endless(IdlStruct, typename=ros.dds_name(package, name)):
        stamp: ros.Time = ros.new(ros.Time)
        length: uint32 = 2**32 - 1
        rest: uint32 = 0

    return Endless


def stamp():
    now_ns = time.time_ns()
    return ros.Time(now_ns // 10**9, now_ns % 10**9)


def heading(angle):
    return ros.Quaternion(0.0, 0.0, math.sin(angle / 2), math.cos(angle / 2))


def crowd():
    header, size = ros.Header(stamp(), "camera"), ros.Vector3(0.6, 0.6, 1.8)
    # The farthest first.
    places = [ros.Pose(ros.Point(3.0 + GAP_M * i, 0.0, 0.0), heading(0.0)) for i in reversed(range(CROWD))]
    person = [ros.ObjectHypothesisWithPose(ros.ObjectHypothesis("person", 0.9))]
    boxes = [ros.Detection3D(header, person, ros.BoundingBox3D(pose, size), f"p{i}") for i, pose in enumerate(places)]
    return ros.Detection3DArray(header, boxes)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--domain", type=int, required=True)
    parser.add_argument("--seconds", type=float, default=30.0)
    asked = parser.parse_args()
    reliable = ros.profile()

    def writer(participant, name, kind, profile=reliable):
        return DataWriter(participant, Topic(participant, f"rt/{name}", kind, qos=profile), qos=profile)

    good = DomainParticipant(asked.domain)
    latched = ros.profile(latched=True, depth=1)
    frames = writer(good, "tf_static", ros.TFMessage, latched)
    odometry, seen = writer(good, "odom", ros.Odometry), writer(good, "detections", ros.Detection3DArray)
    bad = []
    for name, package, kind in [("odom", "nav_msgs", "Odometry"), ("detections", "vision_msgs", "Detection3DArray")]:
        for broken in (short, endless):
            garbage = broken(package, kind)
            bad.append((writer(DomainParticipant(asked.domain), name, garbage), garbage()))
    place = ros.Transform(ros.Vector3(1.0, 0.0, 0.0), heading(math.pi / 2))
    frames.write(ros.TFMessage([ros.TransformStamped(ros.Header(stamp(), "odom"), "camera", place)]))
    print("begun", flush=True)
    begin, steps = time.monotonic(), 0
    while time.monotonic() < begin + asked.seconds:
        message = ros.Odometry(ros.Header(stamp(), "odom"), "base_link")
        message.pose.pose.orientation = heading(0.0)
        odometry.write(message)
        if steps % 5 == 0:
            seen.write(crowd())
            for port, garbage in bad:
                port.write(garbage)
        steps += 1
        time.sleep(max(0.0, begin + 0.02 * steps - time.monotonic()))


if __name__ == "__main__":
    main()
