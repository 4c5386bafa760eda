"""ROS 2 message types as CycloneDDS' Python package declares them, for peers that share no line with the stack.

A topic /odom is the DDS topic rt/odom; a type nav_msgs/Odometry is nav_msgs::msg::dds_::Odometry_. Everything is written as XCDR1,
as every ROS 2 middleware does.
"""

from dataclasses import dataclass, field

from cyclonedds.core import Policy
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import array, float32, float64, int32, sequence, uint8, uint32
from cyclonedds.qos import Qos
from cyclonedds.util import duration


def dds_name(package, name):
    return f"{package}::msg::dds_::{name}_"


def new(kind):
    return field(default_factory=kind)


def zeros():
    return field(default_factory=lambda: [0.0] * 36)


@dataclass
@final
class Time(IdlStruct, typename=dds_name("builtin_interfaces", "Time")):
    sec: int32 = 0
    nanosec: uint32 = 0


@dataclass
@final
class Header(IdlStruct, typename=dds_name("std_msgs", "Header")):
    stamp: Time = new(Time)
    frame_id: str = ""


@dataclass
@final
class Point(IdlStruct, typename=dds_name("geometry_msgs", "Point")):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0


@dataclass
@final
class Point32(IdlStruct, typename=dds_name("geometry_msgs", "Point32")):
    x: float32 = 0.0
    y: float32 = 0.0
    z: float32 = 0.0


@dataclass
@final
class Vector3(IdlStruct, typename=dds_name("geometry_msgs", "Vector3")):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0


@dataclass
@final
class Quaternion(IdlStruct, typename=dds_name("geometry_msgs", "Quaternion")):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0
    w: float64 = 1.0


@dataclass
@final
class Pose(IdlStruct, typename=dds_name("geometry_msgs", "Pose")):
    position: Point = new(Point)
    orientation: Quaternion = new(Quaternion)


@dataclass
@final
class PoseStamped(IdlStruct, typename=dds_name("geometry_msgs", "PoseStamped")):
    header: Header = new(Header)
    pose: Pose = new(Pose)


@dataclass
@final
class PoseArray(IdlStruct, typename=dds_name("geometry_msgs", "PoseArray")):
    header: Header = new(Header)
    poses: sequence[Pose] = new(list)


@dataclass
@final
class PoseWithCovariance(IdlStruct, typename=dds_name("geometry_msgs", "PoseWithCovariance")):
    pose: Pose = new(Pose)
    covariance: array[float64, 36] = zeros()


@dataclass
@final
class Twist(IdlStruct, typename=dds_name("geometry_msgs", "Twist")):
    linear: Vector3 = new(Vector3)
    angular: Vector3 = new(Vector3)


@dataclass
@final
class TwistStamped(IdlStruct, typename=dds_name("geometry_msgs", "TwistStamped")):
    header: Header = new(Header)
    twist: Twist = new(Twist)


@dataclass
@final
class TwistWithCovariance(IdlStruct, typename=dds_name("geometry_msgs", "TwistWithCovariance")):
    twist: Twist = new(Twist)
    covariance: array[float64, 36] = zeros()


@dataclass
@final
class Accel(IdlStruct, typename=dds_name("geometry_msgs", "Accel")):
    linear: Vector3 = new(Vector3)
    angular: Vector3 = new(Vector3)


@dataclass
@final
class AccelWithCovariance(IdlStruct, typename=dds_name("geometry_msgs", "AccelWithCovariance")):
    accel: Accel = new(Accel)
    covariance: array[float64, 36] = zeros()


@dataclass
@final
class Polygon(IdlStruct, typename=dds_name("geometry_msgs", "Polygon")):
    points: sequence[Point32] = new(list)


@dataclass
@final
class Transform(IdlStruct, typename=dds_name("geometry_msgs", "Transform")):
    translation: Vector3 = new(Vector3)
    rotation: Quaternion = new(Quaternion)


@dataclass
@final
class TransformStamped(IdlStruct, typename=dds_name("geometry_msgs", "TransformStamped")):
    header: Header = new(Header)
    child_frame_id: str = ""
    transform: Transform = new(Transform)


@dataclass
@final
class TFMessage(IdlStruct, typename=dds_name("tf2_msgs", "TFMessage")):
    transforms: sequence[TransformStamped] = new(list)


@dataclass
@final
class Odometry(IdlStruct, typename=dds_name("nav_msgs", "Odometry")):
    header: Header = new(Header)
    child_frame_id: str = ""
    pose: PoseWithCovariance = new(PoseWithCovariance)
    twist: TwistWithCovariance = new(TwistWithCovariance)


@dataclass
@final
class ObjectHypothesis(IdlStruct, typename=dds_name("vision_msgs", "ObjectHypothesis")):
    class_id: str = ""
    score: float64 = 0.0


@dataclass
@final
class ObjectHypothesisWithPose(IdlStruct, typename=dds_name("vision_msgs", "ObjectHypothesisWithPose")):
    hypothesis: ObjectHypothesis = new(ObjectHypothesis)
    pose: PoseWithCovariance = new(PoseWithCovariance)


@dataclass
@final
class BoundingBox3D(IdlStruct, typename=dds_name("vision_msgs", "BoundingBox3D")):
    center: Pose = new(Pose)
    size: Vector3 = new(Vector3)


@dataclass
@final
class Detection3D(IdlStruct, typename=dds_name("vision_msgs", "Detection3D")):
    header: Header = new(Header)
    results: sequence[ObjectHypothesisWithPose] = new(list)
    bbox: BoundingBox3D = new(BoundingBox3D)
    id: str = ""


@dataclass
@final
class Detection3DArray(IdlStruct, typename=dds_name("vision_msgs", "Detection3DArray")):
    header: Header = new(Header)
    detections: sequence[Detection3D] = new(list)


@dataclass
@final
class UUID(IdlStruct, typename=dds_name("unique_identifier_msgs", "UUID")):
    uuid: array[uint8, 16] = field(default_factory=lambda: [0] * 16)


@dataclass
@final
class ObjectClassification(IdlStruct, typename=dds_name("autoware_perception_msgs", "ObjectClassification")):
    label: uint8 = 0
    probability: float32 = 0.0


@dataclass
@final
class Shape(IdlStruct, typename=dds_name("autoware_perception_msgs", "Shape")):
    type: uint8 = 0
    footprint: Polygon = new(Polygon)
    dimensions: Vector3 = new(Vector3)


@dataclass
@final
class TrackedObjectKinematics(IdlStruct, typename=dds_name("autoware_perception_msgs", "TrackedObjectKinematics")):
    pose_with_covariance: PoseWithCovariance = new(PoseWithCovariance)
    twist_with_covariance: TwistWithCovariance = new(TwistWithCovariance)
    acceleration_with_covariance: AccelWithCovariance = new(AccelWithCovariance)
    orientation_availability: uint8 = 0
    is_stationary: bool = False


@dataclass
@final
class TrackedObject(IdlStruct, typename=dds_name("autoware_perception_msgs", "TrackedObject")):
    object_id: UUID = new(UUID)
    existence_probability: float32 = 0.0
    classification: sequence[ObjectClassification] = new(list)
    kinematics: TrackedObjectKinematics = new(TrackedObjectKinematics)
    shape: Shape = new(Shape)


@dataclass
@final
class TrackedObjects(IdlStruct, typename=dds_name("autoware_perception_msgs", "TrackedObjects")):
    header: Header = new(Header)
    objects: sequence[TrackedObject] = new(list)


@dataclass
@final
class Gid(IdlStruct, typename=dds_name("rmw_dds_common", "Gid")):
    data: array[uint8, 16] = field(default_factory=lambda: [0] * 16)


@dataclass
@final
class NodeEntitiesInfo(IdlStruct, typename=dds_name("rmw_dds_common", "NodeEntitiesInfo")):
    node_namespace: str = ""
    node_name: str = ""
    reader_gid_seq: sequence[Gid] = new(list)
    writer_gid_seq: sequence[Gid] = new(list)


@dataclass
@final
class ParticipantEntitiesInfo(IdlStruct, typename=dds_name("rmw_dds_common", "ParticipantEntitiesInfo")):
    gid: Gid = new(Gid)
    node_entities_info_seq: sequence[NodeEntitiesInfo] = new(list)


def profile(reliable=True, latched=False, depth=10):
    """A ROS 2 profile: the default one, the sensors' one, or the one of /tf_static."""
    return Qos(
        Policy.Reliability.Reliable(duration(milliseconds=100)) if reliable else Policy.Reliability.BestEffort,
        Policy.Durability.TransientLocal if latched else Policy.Durability.Volatile,
        Policy.History.KeepLast(depth),
        Policy.DataRepresentation(use_cdrv0_representation=True, use_xcdrv2_representation=False),
    )
