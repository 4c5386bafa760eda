"""What a ROS 2 graph hears of the stack, by CycloneDDS alone: the peer of tests/ros2_graph.rs.

A robot among two people, as in ros2_robot.py, which listens to everything the stack says about itself and, if asked to, breaks one
thing after the other: a second publisher of /odom with another type, a second publisher of /detections whose quality of service
does not fit, no detections at all. It prints one line of JSON: how long each took until /diagnostics named it, when each began
(date, s), and what else was heard.

    python ros2_graph.py --domain 42 --node /cncbf --faults --seconds 40
"""

import argparse
import json
import math
import time
from dataclasses import dataclass

import ros2_robot as world
import ros2_types as ros
from cyclonedds.builtin import (
    BuiltinDataReader,
    BuiltinTopicDcpsPublication,
    BuiltinTopicDcpsSubscription,
)
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import array, float64, sequence, uint32, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic


@dataclass
@final
class Float64(IdlStruct, typename=ros.dds_name("std_msgs", "Float64")):
    data: float64 = 0.0


@dataclass
@final
class FilterState(IdlStruct, typename=ros.dds_name("cncbf_msgs", "FilterState")):
    header: ros.Header
    sequence: uint64
    status: str
    reason: str
    h: float64
    sdf: float64
    intervention: float64
    slack: float64
    hard_margin: float64
    control: array[float64, 2]
    nominal: array[float64, 2]
    obstacle_count: uint32
    critical_track_id: uint64
    critical_h: float64
    x: float64
    y: float64
    heading: float64


# A fault is awaited this long, s, and begins this long after the one before has been told to be over.
PATIENCE_S = 10.0
PAUSE_S = 1.0


def arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("--domain", type=int, required=True)
    parser.add_argument("--node", default="/cncbf")
    parser.add_argument("--seconds", type=float, default=40.0)
    parser.add_argument("--faults", action="store_true")
    parser.add_argument("--until", choices=["time", "silence", "standstill"], default="time", help="of the commands, once the robot has driven")
    parser.add_argument("--markers", action="store_true", help="listen to shapes, and keep the last ones")
    parser.add_argument("--far-goal", action="store_true", help="a goal that is not reached meanwhile")
    return parser.parse_args()


class Fault:
    """One thing that is broken for a while: how to break it, how to mend it, who has to name it with which words."""

    def __init__(self, name, part, words, begin, end):
        self.name, self.part, self.words, self.begin, self.end = name, part, words, begin, end
        self.began = self.date = self.after_s = self.level = self.message = None


class Faults:
    """Breaks one after the other."""

    def __init__(self, faults):
        self.waiting, self.over, self.now, self.free_at = list(faults), [], None, 0.0

    def step(self, now, statuses):
        if self.now is not None:
            status = statuses.get(self.now.part)
            named = status is not None and self.now.words in status.message
            if named or now - self.now.began > PATIENCE_S:
                if named:
                    self.now.after_s, self.now.level, self.now.message = now - self.now.began, status.level, status.message
                self.now.end()
                self.over.append(self.now)
                self.now, self.free_at = None, now + PAUSE_S
        elif self.waiting and now >= self.free_at and all(status.level == 0 for status in statuses.values() if "input" in status.name):
            self.now = self.waiting.pop(0)
            self.now.began, self.now.date = now, time.time()
            self.now.begin()

    def done(self):
        return not self.waiting and self.now is None

    def seen(self):
        return {
            fault.name: {"after_s": fault.after_s, "date_s": fault.date, "level": fault.level, "message": fault.message}
            for fault in self.over
        }


def main():
    asked = arguments()
    participant = DomainParticipant(asked.domain)
    reliable, latched = ros.profile(), ros.profile(latched=True, depth=1)
    deep = ros.profile(depth=100)

    def writer(name, kind, profile=reliable):
        return DataWriter(participant, Topic(participant, f"rt/{name}", kind, qos=profile), qos=profile)

    def reader(name, kind, profile=deep):
        return DataReader(participant, Topic(participant, name, kind, qos=profile), qos=profile)

    odometry, goals = writer("odom", ros.Odometry), writer("goal_pose", ros.PoseStamped)
    people = writer("detections", ros.Detection3DArray)
    commands = reader("rt/cmd_vel", ros.Twist)
    diagnostics = reader("rt/diagnostics", ros.DiagnosticArray)
    states = reader(f"rt{asked.node}/filter_state", FilterState)
    numbers = {name: reader(f"rt{asked.node}/{name}", Float64) for name in ["h", "sdf"]}
    shapes = reader(f"rt{asked.node}/markers", ros.MarkerArray) if asked.markers else None
    graph = reader("ros_discovery_info", ros.ParticipantEntitiesInfo, latched)
    ends = {
        "publishers": BuiltinDataReader(participant, BuiltinTopicDcpsPublication),
        "subscriptions": BuiltinDataReader(participant, BuiltinTopicDcpsSubscription),
    }

    # Writers of faults, kept where they live. A silenced stream is one that is not written.
    bad, silent = {}, set()

    def odd_topic(name, kind, profile=reliable):
        # One participant cannot have two types, or two qualities of service, under one name.
        other = DomainParticipant(asked.domain)
        bad[f"{name} participant"] = other
        return Topic(other, f"rt/{name}", kind, qos=profile)

    def begin_other_type():
        topic = odd_topic("odom", ros.PoseStamped)
        bad["odom"] = DataWriter(bad["odom participant"], topic, qos=reliable)

    def begin_best_effort():
        profile = ros.profile(reliable=False)
        topic = odd_topic("detections", ros.Detection3DArray, profile)
        bad["detections"] = DataWriter(bad["detections participant"], topic, qos=profile)

    def begin_rival():
        bad["cmd_vel participant"] = DomainParticipant(asked.domain)
        topic = Topic(bad["cmd_vel participant"], "rt/cmd_vel", ros.Twist, qos=reliable)
        bad["cmd_vel"] = DataWriter(bad["cmd_vel participant"], topic, qos=reliable)

    faults = Faults([
        Fault("wrong_type", "input /odom", "speaks geometry_msgs/PoseStamped, not nav_msgs/Odometry", begin_other_type, bad.clear),
        Fault("wrong_qos", "input /detections", "reliability best_effort offered, reliable asked for", begin_best_effort, bad.clear),
        Fault("rival", "output /cmd_vel", "somebody else commands the robot, too", begin_rival, bad.clear),
        Fault("silent", "input /detections", "silent", lambda: silent.add("people"), silent.clear),
    ] if asked.faults else [])

    robot, begin, steps = world.Robot(), time.monotonic(), 0
    statuses, history, arrays, first_state, last_state, last_shapes = {}, {}, 0, None, None, None
    counts = {"states": 0, "h": 0, "sdf": 0, "markers": 0}
    driven, nodes, announced = [], {}, {"publishers": {}, "subscriptions": {}}
    hardware, stamps, heard = set(), [], None
    last = {}
    goal = (60.0, 0.0) if asked.far_goal else world.GOAL
    while True:
        now = time.monotonic()
        elapsed = now - begin
        for message in commands.take(N=100):
            if isinstance(message, ros.Twist):
                robot.speed, robot.rate, heard = message.linear.x, message.angular.z, now
                driven.append((time.time(), message.linear.x, message.angular.z))
        if heard is None or now - heard > world.SILENCE_S:
            robot.speed = robot.rate = 0.0
        robot.step()
        for message in diagnostics.take(N=100):
            if isinstance(message, ros.DiagnosticArray):
                arrays += 1
                stamps.append(abs(time.time() - message.header.stamp.sec - 1e-9 * message.header.stamp.nanosec))
                for status in message.status:
                    part = status.name.split(": ", 1)[1]
                    statuses[part] = status
                    hardware.add(status.hardware_id)
                    said = history.setdefault(part, [])
                    if not said or said[-1][1] != status.message:
                        said.append((status.level, status.message))
        for message in states.take(N=100):
            if isinstance(message, FilterState):
                counts["states"] += 1
                first_state, last_state = first_state or now, message
                last["state_at"] = now
        for name, port in numbers.items():
            for message in port.take(N=100):
                if isinstance(message, Float64):
                    counts[name] += 1
                    last[name] = message.data
        for message in shapes.take(N=10) if shapes else []:
            if isinstance(message, ros.MarkerArray):
                counts["markers"] += 1
                last_shapes = message
        for message in graph.take(N=100):
            if isinstance(message, ros.ParticipantEntitiesInfo):
                for node in message.node_entities_info_seq:
                    nodes[f"{node.node_namespace.rstrip('/')}/{node.node_name}"] = node
        for kind, port in ends.items():
            for end in port.take(N=200):
                if getattr(end, "topic_name", None):
                    announced[kind][end.key.bytes] = (end.topic_name, end.type_name)
        faults.step(now, statuses)
        if steps % world.ODOMETRY_STEPS == 0:
            odometry.write(robot.odometry())
        if steps % world.OBSTACLE_STEPS == 0 and "people" not in silent:
            places = [((3.0, 2.5), (0.0, 0.0)), ((5.0, -2.5), (0.0, 0.0))]
            people.write(world.obstacles("boxes", places, "odom"))
        if steps % world.GOAL_STEPS == 0:
            goals.write(ros.PoseStamped(ros.Header(world.stamp(), "odom"), ros.Pose(ros.Point(*goal, 0.0))))
        drove = any(speed > 0.5 for _, speed, _ in driven)
        over = {
            "time": False,
            "silence": heard is not None and now - heard > 1.0,
            "standstill": len(driven) > 50 and all(speed == 0.0 for _, speed, _ in driven[-50:]),
        }[asked.until]
        if elapsed > asked.seconds or (drove and over) or (asked.faults and faults.done() and elapsed > 8.0):
            break
        steps += 1
        time.sleep(max(0.0, begin + steps * world.STEP_S - time.monotonic()))

    node = nodes.get(asked.node)

    def topics_of(kind, gids):
        return sorted({
            "{} {}".format(*announced[kind][bytes(gid.data[:16])]) for gid in gids if bytes(gid.data[:16]) in announced[kind]
        })

    def named(value):
        return None if value is None or not math.isfinite(value) else value

    span_s = (last["state_at"] - first_state) if first_state else None
    print(json.dumps({
        "faults": faults.seen(),
        "statuses": {
            part: {"level": status.level, "message": status.message, "values": {value.key: value.value for value in status.values}}
            for part, status in statuses.items()
        },
        "history": history,
        "arrays": arrays,
        "elapsed_s": elapsed,
        "diagnostics_age_max_s": max(stamps, default=None),
        "hardware": sorted(hardware),
        "counts": counts,
        "state_hz": counts["states"] / span_s if span_s else None,
        "h": named(last.get("h")),
        "state": last_state and {
            "frame": last_state.header.frame_id,
            "age_s": time.time() - last_state.header.stamp.sec - 1e-9 * last_state.header.stamp.nanosec,
            "status": last_state.status,
            "reason": last_state.reason,
            "h": named(last_state.h),
            "sdf": named(last_state.sdf),
            "intervention": last_state.intervention,
            "control": list(last_state.control),
            "nominal": list(last_state.nominal),
            "obstacle_count": last_state.obstacle_count,
            "critical_track_id": last_state.critical_track_id,
            "x": last_state.x,
            "y": last_state.y,
        },
        "robot": [robot.x, robot.y],
        "markers": last_shapes and [
            {
                "frame": shape.header.frame_id,
                "ns": shape.ns,
                "type": shape.type,
                "action": shape.action,
                "at": [shape.pose.position.x, shape.pose.position.y],
                "size": [shape.scale.x, shape.scale.y],
                "points": [[point.x, point.y] for point in shape.points],
            }
            for shape in last_shapes.markers
        ],
        "publishers": node and topics_of("publishers", node.writer_gid_seq),
        "subscriptions": node and topics_of("subscriptions", node.reader_gid_seq),
        "commands": driven[-600:],
    }))


if __name__ == "__main__":
    main()
