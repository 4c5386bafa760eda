"""A ROS 2 robot that drives itself, made of CycloneDDS alone: the peer of a stack in shadow mode in tests/shadow.rs.

It commands /cmd_vel straight to its goal, obeys itself, and meets a person on the way whom it does not see. It sets out once
somebody listens to /cmd_vel besides itself. At the end it prints one line of JSON: what a judge outside the stack saw, above all
who else could write /cmd_vel.

    python ros2_shadow.py --domain 42 --seconds 60
"""

import argparse
import json
import math
import time

import ros2_robot as peer  # sets the environment of CycloneDDS before that is imported
import ros2_types as ros
from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

SPEED_MPS = 1.0
COMMAND_STEPS = 5
AFTERMATH_S = 0.5


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--domain", type=int, required=True)
    parser.add_argument("--seconds", type=float, default=60.0)
    asked = parser.parse_args()
    participant = DomainParticipant(asked.domain)
    reliable = ros.profile()

    def writer(name, kind):
        return DataWriter(participant, Topic(participant, f"rt/{name}", kind, qos=reliable), qos=reliable)

    odometry, seen = writer("odom", ros.Odometry), writer("detections", ros.Detection3DArray)
    goals, commands = writer("goal_pose", ros.PoseStamped), writer("cmd_vel", ros.Twist)
    heard = DataReader(participant, Topic(participant, "rt/cmd_vel", ros.Twist, qos=reliable), qos=reliable)
    publications = BuiltinDataReader(participant, BuiltinTopicDcpsPublication)

    robot, people = peer.Robot(), [list(start) for start, _ in peer.PEOPLE]
    writers, sent, received, clearance = set(), 0, 0, math.inf
    set_out_s = reached_s = None
    begin, steps = time.monotonic(), 0
    while True:
        elapsed = time.monotonic() - begin
        for publication in publications.take(N=100):
            if getattr(publication, "topic_name", "") == "rt/cmd_vel" and publication.participant_key != participant.guid:
                writers.add(str(publication.participant_key))
        received += sum(isinstance(message, ros.Twist) for message in heard.take(N=100))
        # Its own reader is one of them.
        if set_out_s is None and len(commands.get_matched_subscriptions()) > 1:
            set_out_s = elapsed + 1.5
        driving = set_out_s is not None and elapsed > set_out_s
        if math.hypot(peer.GOAL[0] - robot.x, peer.GOAL[1] - robot.y) <= peer.GOAL_TOLERANCE_M and reached_s is None:
            reached_s = elapsed
        if steps % COMMAND_STEPS == 0:
            robot.speed = SPEED_MPS if driving and reached_s is None else 0.0
            commands.write(ros.Twist(ros.Vector3(robot.speed, 0.0, 0.0), ros.Vector3()))
            sent += 1
        robot.step()
        for person, (_, velocity) in zip(people, peer.PEOPLE):
            if driving:
                person[0] += velocity[0] * peer.STEP_S
                person[1] += velocity[1] * peer.STEP_S
            clearance = min(clearance, math.hypot(person[0] - robot.x, person[1] - robot.y) - 2 * peer.RADIUS_M)
        if steps % peer.ODOMETRY_STEPS == 0:
            odometry.write(robot.odometry())
        if steps % peer.OBSTACLE_STEPS == 0:
            places = [(person, velocity if driving else (0.0, 0.0)) for person, (_, velocity) in zip(people, peer.PEOPLE)]
            seen.write(peer.obstacles("boxes", places, "odom"))
        if steps % peer.GOAL_STEPS == 0:
            goals.write(ros.PoseStamped(ros.Header(peer.stamp(), "odom"), ros.Pose(ros.Point(*peer.GOAL, 0.0))))
        if elapsed > asked.seconds or (reached_s is not None and elapsed > reached_s + AFTERMATH_S):
            break
        steps += 1
        time.sleep(max(0.0, begin + steps * peer.STEP_S - time.monotonic()))
    print(json.dumps({
        "reached_s": reached_s,
        "was_heard": set_out_s is not None,
        "min_clearance_m": clearance,
        "sent": sent,
        "received": received,
        "foreign_writers": len(writers),
    }))


if __name__ == "__main__":
    main()
