#!/usr/bin/env python3
"""Judge of crates/recording: rosbags and mcap-ros2-support, which share no code with it.

    python3 -m venv VENV && VENV/bin/pip install rosbags==0.11.9 mcap mcap-ros2-support
    VENV/bin/python tests/judges/mcap_ros2_reference.py write tests/data
    cargo test -p recording --test reference     # leaves recorder_sample.mcap in target/tmp
    VENV/bin/python tests/judges/mcap_ros2_reference.py read target/tmp/recorder_sample.mcap tests/data

`write` makes mcap_rosbags_reference.mcap with rosbags, and mcap_rosbags_reference.json with the numbers that went in.
`read` decodes a file of our recorder twice, by rosbags and by mcap-ros2-support from the schemas in the file, insists that
both say the same, and stores for every ROS message the checksum of its bytes and the numbers found in them in
mcap_recorder_as_read.json. The Rust test then holds its own bytes and numbers against these.
"""

import json
import sys
import zlib
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

VISION = {
    "vision_msgs/msg/ObjectHypothesis": "string class_id\nfloat64 score",
    "vision_msgs/msg/ObjectHypothesisWithPose":
        "vision_msgs/ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose",
    "vision_msgs/msg/BoundingBox3D": "geometry_msgs/Pose center\ngeometry_msgs/Vector3 size",
    "vision_msgs/msg/Detection3D":
        "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\n"
        "vision_msgs/BoundingBox3D bbox\nstring id",
    "vision_msgs/msg/Detection3DArray": "std_msgs/Header header\nvision_msgs/Detection3D[] detections",
}


def typestore():
    store = get_typestore(Stores.ROS2_JAZZY)
    types = {}
    for name, text in VISION.items():
        types.update(get_types_from_msg(text, name))
    store.register(types)
    return store


def make(store):
    """Messages with numbers that exercise alignment: (topic, type, log time, message, what went in)."""
    t = store.types
    rng = np.random.default_rng(11)
    num = lambda: float(rng.normal())

    def header(ns, frame):
        return t["std_msgs/msg/Header"](
            stamp=t["builtin_interfaces/msg/Time"](sec=ns // 10**9, nanosec=ns % 10**9), frame_id=frame)

    def pose():
        p = [num(), num(), num()]
        q = rng.normal(size=4)
        q /= np.linalg.norm(q)
        return t["geometry_msgs/msg/Pose"](
            position=t["geometry_msgs/msg/Point"](*p), orientation=t["geometry_msgs/msg/Quaternion"](*map(float, q)))

    flat = lambda p: [p.position.x, p.position.y, p.position.z,
                      p.orientation.x, p.orientation.y, p.orientation.z, p.orientation.w]
    out = []
    for i in range(12):
        ns = 1_700_000_000_000_000_000 + i * 20_000_000
        # Frame names of every length modulo 8 move the doubles behind them through every padding.
        frame = "odom" + "m" * i
        p, cov = pose(), rng.normal(size=36)
        v = t["geometry_msgs/msg/Vector3"]
        lin, ang, cov2 = [num(), num(), num()], [num(), num(), num()], rng.normal(size=36)
        odom = t["nav_msgs/msg/Odometry"](
            header=header(ns, frame), child_frame_id="base" + "_" * (i % 5),
            pose=t["geometry_msgs/msg/PoseWithCovariance"](pose=p, covariance=cov),
            twist=t["geometry_msgs/msg/TwistWithCovariance"](
                twist=t["geometry_msgs/msg/Twist"](linear=v(*lin), angular=v(*ang)), covariance=cov2))
        out.append(("/odom", "nav_msgs/msg/Odometry", ns + 1_000, odom,
                    {"stamp_ns": ns, "frame": frame, "child": odom.child_frame_id,
                     "numbers": flat(p) + cov.tolist() + lin + ang + cov2.tolist()}))
        people, put = [], []
        for k in range(i % 4):
            hp, bp, size, score = pose(), pose(), [abs(num()), abs(num()), abs(num())], num()
            pcov = rng.normal(size=36)
            name, ident = "person" * (k + 1), str(100 + k) if k < 2 else "track-é-%d" % k
            people.append(t["vision_msgs/msg/Detection3D"](
                header=header(ns, frame),
                results=[t["vision_msgs/msg/ObjectHypothesisWithPose"](
                    hypothesis=t["vision_msgs/msg/ObjectHypothesis"](class_id=name, score=score),
                    pose=t["geometry_msgs/msg/PoseWithCovariance"](pose=hp, covariance=pcov))],
                bbox=t["vision_msgs/msg/BoundingBox3D"](center=bp, size=v(*size)), id=ident))
            put.append({"class": name, "id": ident,
                        "numbers": [score] + flat(hp) + pcov.tolist() + flat(bp) + size})
        out.append(("/detections", "vision_msgs/msg/Detection3DArray", ns + 2_000,
                    t["vision_msgs/msg/Detection3DArray"](header=header(ns, frame), detections=people),
                    {"stamp_ns": ns, "frame": frame, "detections": put}))
        poses = [pose() for _ in range((i * 2) % 5)]
        out.append(("/people", "geometry_msgs/msg/PoseArray", ns + 3_000,
                    t["geometry_msgs/msg/PoseArray"](header=header(ns, frame), poses=poses),
                    {"stamp_ns": ns, "frame": frame, "numbers": [x for q in poses for x in flat(q)]}))
        q = pose()
        out.append(("/tf", "tf2_msgs/msg/TFMessage", ns + 4_000,
                    t["tf2_msgs/msg/TFMessage"](transforms=[t["geometry_msgs/msg/TransformStamped"](
                        header=header(ns, "map"), child_frame_id=frame,
                        transform=t["geometry_msgs/msg/Transform"](
                            translation=v(q.position.x, q.position.y, q.position.z), rotation=q.orientation))]),
                    {"stamp_ns": ns, "frame": "map", "child": frame, "numbers": flat(q)}))
    g = pose()
    out.append(("/goal_pose", "geometry_msgs/msg/PoseStamped", 1_700_000_000_000_000_500,
                t["geometry_msgs/msg/PoseStamped"](header=header(0, "odom"), pose=g),
                {"stamp_ns": 0, "frame": "odom", "numbers": flat(g)}))
    return out


def write(folder):
    store = typestore()
    bag = folder / "mcap_rosbags_reference"
    writer = Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP)
    messages = make(store)
    with writer:
        channels = {}
        for topic, kind, log, message, _ in messages:
            if topic not in channels:
                channels[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(channels[topic], log, store.serialize_cdr(message, kind))
    next(bag.glob("*.mcap")).rename(folder / "mcap_rosbags_reference.mcap")
    (bag / "metadata.yaml").unlink()
    bag.rmdir()
    # The goal is logged between the first two messages although it was written last.
    rows = sorted(({"topic": topic, "log_time_ns": log} | said for topic, _, log, _, said in messages),
                  key=lambda row: row["log_time_ns"])
    (folder / "mcap_rosbags_reference.json").write_text(
        "[\n" + ",\n".join(json.dumps(for_json(row)) for row in rows) + "\n]\n")


def plain(value):
    """Any message as nested lists in field order, so that two decoders can be compared."""
    if hasattr(value, "__slots__") and not isinstance(value, (str, bytes)):
        return [plain(getattr(value, name)) for name in value.__slots__]
    if hasattr(value, "__dataclass_fields__"):
        return [plain(getattr(value, name)) for name in value.__dataclass_fields__
                if name != "__msgtype__" and not name.isupper()]  # upper case: constants
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, (bytes, bytearray)):
        return list(value)
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return value


def for_json(value):
    """Floats as text: it names them exactly, and JSON has no infinity."""
    if isinstance(value, list):
        return [for_json(item) for item in value]
    if isinstance(value, dict):
        return {key: for_json(item) for key, item in value.items()}
    return repr(value) if isinstance(value, float) else value


def read(path, folder):
    store = typestore()
    rows = []
    with open(path, "rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        for schema, channel, message in reader.iter_messages():
            if channel.message_encoding != "cdr":
                continue
            decoder = DecoderFactory().decoder_for(channel.message_encoding, schema)
            by_schema = plain(decoder(message.data))
            by_rosbags = plain(store.deserialize_cdr(message.data, schema.name))
            assert by_schema == by_rosbags, (channel.topic, by_schema, by_rosbags)
            rows.append({"topic": channel.topic, "log_time_ns": message.log_time, "type": schema.name,
                         "crc32": zlib.crc32(message.data), "content": for_json(by_rosbags)})
    with AnyReader([Path(path)]) as bag:
        assert any(connection.topic == "/odom" for connection in bag.connections)
    print(f"{len(rows)} messages, both decoders agree")
    kept = [row for row in rows if row["log_time_ns"] < 5_500_000_000]
    (folder / "mcap_recorder_as_read.json").write_text(
        "[\n" + ",\n".join(json.dumps(row) for row in kept) + "\n]\n")


if __name__ == "__main__":
    if sys.argv[1] == "write":
        write(Path(sys.argv[2]))
    elif sys.argv[1] == "read":
        read(Path(sys.argv[2]), Path(sys.argv[3]))
    else:
        sys.exit(__doc__)
