"""An hour's worth of ROS 2 messages at ten times the usual rates, and what the stack's memory does meanwhile.

CycloneDDS publishes /odom at 500 Hz, /detections at 200 Hz, /tf at 500 Hz and /goal_pose at 20 Hz for six minutes: as many messages
as a robot says in an hour. The robot does what /cmd_vel says and is sent to and fro between people who walk in circles. Resident
memory of every process of the stack is read once a second; what it was after a quarter of the time is compared with the end.

    python -m venv v && v/bin/pip install cyclonedds==11.0.1
    v/bin/python tests/judges/ros2_hour.py target/release/cncbf OUT_FOLDER            six minutes
    v/bin/python tests/judges/ros2_hour.py target/release/cncbf OUT_FOLDER --seconds 40

Prints one line of JSON; exit code 1 if any process grew by more than --most-mb.
"""

import argparse
import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

os.environ["CYCLONEDDS_URI"] = """<CycloneDDS><Domain id="any">
 <General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces><AllowMulticast>false</AllowMulticast></General>
 <Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>11</MaxAutoParticipantIndex>
  <Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>"""

from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

import ros2_types as ros
from ros2_robot import Robot, heading, stamp

PERIOD_S = 0.002
# A robot's second at the usual rates takes a tenth of one here.
SPEED_UP = 10
PEOPLE = 5
GOALS = [(6.0, 0.0), (0.0, 0.0)]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cncbf", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--seconds", type=float, default=3600 / SPEED_UP)
    parser.add_argument("--domain", type=int, default=87)
    parser.add_argument("--most-mb", type=float, default=2.0)
    parser.add_argument("--settled", type=float, default=0.25, help="share of the time after which nothing may grow any more")
    return parser.parse_args()


def resident_mb(pid):
    """Private resident memory: what a leak would grow, without shared pages that are merely touched for the first time."""
    try:
        fields = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return None
    sizes = [line.split()[1] for line in fields.splitlines() if line.startswith("RssAnon")]
    return int(sizes[0]) / 1024 if sizes else None


def processes(launcher):
    """Name and number of every process of the stack."""
    children = Path(f"/proc/{launcher}/task/{launcher}/children").read_text().split()
    named = {"launcher": launcher}
    for pid in children:
        words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
        named[words[1].decode()] = int(pid)
    return named


def main():
    asked = arguments()
    asked.out.mkdir(parents=True, exist_ok=True)
    environment = dict(os.environ, ROS_DOMAIN_ID=str(asked.domain), ROS_LOCALHOST_ONLY="1", CNCBF_IPC_PREFIX=f"hour_{os.getpid()}_",
                       RUST_LOG="warn,rustdds=off,ros2_client=off")
    stack = subprocess.Popen(
        [asked.cncbf, "run", "--source", "ros2", "--report", asked.out / "report", "--json"],
        env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    participant = DomainParticipant(asked.domain)
    streams = ros.profile()

    def writer(name, kind):
        return DataWriter(participant, Topic(participant, f"rt/{name}", kind, qos=streams), qos=streams)

    odometry, seen, frames = writer("odom", ros.Odometry), writer("detections", ros.Detection3DArray), writer("tf", ros.TFMessage)
    goals = writer("goal_pose", ros.PoseStamped)
    commands = DataReader(participant, Topic(participant, "rt/cmd_vel", ros.Twist, qos=streams), qos=streams)
    robot, aim, sent, heard, steps = Robot(), 0, 0, 0, 0
    memory, told_s, begin = {}, 0.0, time.monotonic()
    while (elapsed := time.monotonic() - begin) < asked.seconds and stack.poll() is None:
        for message in commands.take(N=100):
            if isinstance(message, ros.Twist):
                robot.speed, robot.rate, heard = message.linear.x, message.angular.z, heard + 1
        robot.x += robot.speed * math.cos(robot.angle) * PERIOD_S
        robot.y += robot.speed * math.sin(robot.angle) * PERIOD_S
        robot.angle += robot.rate * PERIOD_S
        odometry.write(robot.odometry())
        place = ros.Transform(ros.Vector3(1.0, 0.0, 0.0), heading(0.0))
        frames.write(ros.TFMessage([ros.TransformStamped(ros.Header(stamp(), "odom"), "camera", place)]))
        sent += 2
        if steps % 5 == 0:
            header, person = ros.Header(stamp(), "camera"), [ros.ObjectHypothesisWithPose(ros.ObjectHypothesis("person", 0.9))]
            found = []
            for i in range(PEOPLE):
                angle = 0.3 * elapsed + 2 * math.pi * i / PEOPLE
                place = ros.Pose(ros.Point(2.0 + 2.5 * math.cos(angle), 4.0 + 2.5 * math.sin(angle), 0.9), heading(angle))
                found.append(ros.Detection3D(header, person, ros.BoundingBox3D(place, ros.Vector3(0.7, 0.7, 1.8)), f"p{i}"))
            seen.write(ros.Detection3DArray(header, found))
            sent += 1
        if steps % 50 == 0:
            x, y = GOALS[aim]
            if math.hypot(x - robot.x, y - robot.y) < 0.4:
                aim = 1 - aim
            goals.write(ros.PoseStamped(ros.Header(stamp(), "odom"), ros.Pose(ros.Point(*GOALS[aim], 0.0))))
            sent += 1
        if elapsed >= told_s + 1.0:
            told_s = elapsed
            for name, pid in processes(stack.pid).items():
                memory.setdefault(name, []).append(resident_mb(pid))
            print(f"\r{elapsed:.0f} of {asked.seconds:.0f} s", end="", file=sys.stderr, flush=True)
        steps += 1
        time.sleep(max(0.0, begin + steps * PERIOD_S - time.monotonic()))
    print(file=sys.stderr)
    rate = steps / (time.monotonic() - begin)
    ended = stack.poll()
    if ended is None:
        stack.send_signal(signal.SIGINT)
    verdict = json.loads(stack.communicate()[0] or "{}")
    growth = {}
    for name, values in memory.items():
        values = [value for value in values if value is not None]
        settled = values[int(asked.settled * (len(values) - 1))]
        growth[name] = {"settled_mb": round(settled, 2), "end_mb": round(values[-1], 2),
                        "most_mb": round(max(values), 2), "grown_mb": round(values[-1] - settled, 2),
                        "every_tenth_mb": [round(value, 1) for value in values[:: max(1, len(values) // 10)]]}
    flat = ended is None and bool(growth) and all(one["grown_mb"] <= asked.most_mb for one in growth.values())
    print(json.dumps({
        "seconds": asked.seconds, "messages_sent": sent, "odometry_hz": round(rate, 1), "commands_heard": heard, "memory": growth,
        "flat": flat, "ended_early": ended, "refused_inputs": verdict.get("refused_inputs"),
    }))
    sys.exit(0 if flat else 1)


if __name__ == "__main__":
    main()
