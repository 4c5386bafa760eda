"""ROS 2 message types as CycloneDDS' Python package declares them, for peers that share no line with the stack.

A topic /odom is the DDS topic rt/odom; a type nav_msgs/Odometry is nav_msgs::msg::dds_::Odometry_. Everything is written as XCDR1,
as every ROS 2 middleware does.
"""

from dataclasses import dataclass, field

from cyclonedds.core import Policy
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import array, byte, float32, float64, int8, int32, sequence, uint8, uint32
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
class Duration(IdlStruct, typename=dds_name("builtin_interfaces", "Duration")):
    sec: int32 = 0
    nanosec: uint32 = 0


@dataclass
@final
class Clock(IdlStruct, typename=dds_name("rosgraph_msgs", "Clock")):
    clock: Time = new(Time)


@dataclass
@final
class Path(IdlStruct, typename=dds_name("nav_msgs", "Path")):
    header: Header = new(Header)
    poses: sequence[PoseStamped] = new(list)


@dataclass
@final
class Person(IdlStruct, typename=dds_name("people_msgs", "Person")):
    name: str = ""
    position: Point = new(Point)
    velocity: Point = new(Point)
    reliability: float64 = 0.0
    tagnames: sequence[str] = new(list)
    tags: sequence[str] = new(list)


@dataclass
@final
class People(IdlStruct, typename=dds_name("people_msgs", "People")):
    header: Header = new(Header)
    people: sequence[Person] = new(list)


@dataclass
@final
class SolidPrimitive(IdlStruct, typename=dds_name("shape_msgs", "SolidPrimitive")):
    type: uint8 = 0
    dimensions: sequence[float64, 3] = new(list)
    polygon: Polygon = new(Polygon)


@dataclass
@final
class Object(IdlStruct, typename=dds_name("derived_object_msgs", "Object")):
    header: Header = new(Header)
    id: uint32 = 0
    detection_level: uint8 = 0
    object_classified: bool = False
    pose: Pose = new(Pose)
    twist: Twist = new(Twist)
    accel: Accel = new(Accel)
    polygon: Polygon = new(Polygon)
    shape: SolidPrimitive = new(SolidPrimitive)
    classification: uint8 = 0
    classification_certainty: uint8 = 0
    classification_age: uint32 = 0


@dataclass
@final
class ObjectArray(IdlStruct, typename=dds_name("derived_object_msgs", "ObjectArray")):
    header: Header = new(Header)
    objects: sequence[Object] = new(list)


@dataclass
@final
class AgentBehavior(IdlStruct, typename=dds_name("hunav_msgs", "AgentBehavior")):
    type: uint8 = 0
    state: uint8 = 0
    configuration: uint8 = 0
    duration: float32 = 0.0
    once: bool = False
    vel: float32 = 0.0
    dist: float32 = 0.0
    goal_force_factor: float32 = 0.0
    obstacle_force_factor: float32 = 0.0
    social_force_factor: float32 = 0.0
    other_force_factor: float32 = 0.0


@dataclass
@final
class Agent(IdlStruct, typename=dds_name("hunav_msgs", "Agent")):
    id: int32 = 0
    type: uint8 = 0
    skin: uint8 = 0
    name: str = ""
    group_id: int8 = 0
    position: Pose = new(Pose)
    yaw: float32 = 0.0
    velocity: Twist = new(Twist)
    desired_velocity: float32 = 0.0
    radius: float32 = 0.0
    linear_vel: float32 = 0.0
    angular_vel: float32 = 0.0
    behavior: AgentBehavior = new(AgentBehavior)
    behavior_tree: str = ""
    goals: sequence[Pose] = new(list)
    cyclic_goals: bool = False
    goal_radius: float32 = 0.0
    closest_obs: sequence[Point] = new(list)


@dataclass
@final
class Agents(IdlStruct, typename=dds_name("hunav_msgs", "Agents")):
    header: Header = new(Header)
    agents: sequence[Agent] = new(list)


@dataclass
@final
class Agent1(IdlStruct, typename=dds_name("hunav_msgs", "Agent")):
    """As HuNavSim 1 published it, under the same name."""

    id: int32 = 0
    type: uint8 = 0
    skin: uint8 = 0
    behavior: uint8 = 0
    name: str = ""
    behavior_state: uint8 = 0
    group_id: int8 = 0
    position: Pose = new(Pose)
    yaw: float32 = 0.0
    velocity: Twist = new(Twist)
    desired_velocity: float32 = 0.0
    radius: float32 = 0.0
    linear_vel: float32 = 0.0
    angular_vel: float32 = 0.0
    goals: sequence[Pose] = new(list)
    cyclic_goals: bool = False
    goal_radius: float32 = 0.0
    closest_obs: sequence[Point] = new(list)


@dataclass
@final
class Agents1(IdlStruct, typename=dds_name("hunav_msgs", "Agents")):
    header: Header = new(Header)
    agents: sequence[Agent1] = new(list)


@dataclass
@final
class Obstacle(IdlStruct, typename=dds_name("nav2_dynamic_msgs", "Obstacle")):
    uuid: UUID = new(UUID)
    score: float32 = 0.0
    position: Point = new(Point)
    velocity: Vector3 = new(Vector3)
    size: Vector3 = new(Vector3)


@dataclass
@final
class ObstacleArray(IdlStruct, typename=dds_name("nav2_dynamic_msgs", "ObstacleArray")):
    header: Header = new(Header)
    obstacles: sequence[Obstacle] = new(list)


@dataclass
@final
class ColorRGBA(IdlStruct, typename=dds_name("std_msgs", "ColorRGBA")):
    r: float32 = 0.0
    g: float32 = 0.0
    b: float32 = 0.0
    a: float32 = 0.0


@dataclass
@final
class CompressedImage(IdlStruct, typename=dds_name("sensor_msgs", "CompressedImage")):
    header: Header = new(Header)
    format: str = ""
    data: sequence[uint8] = new(list)


@dataclass
@final
class UVCoordinate(IdlStruct, typename=dds_name("visualization_msgs", "UVCoordinate")):
    u: float32 = 0.0
    v: float32 = 0.0


@dataclass
@final
class MeshFile(IdlStruct, typename=dds_name("visualization_msgs", "MeshFile")):
    filename: str = ""
    data: sequence[uint8] = new(list)


@dataclass
@final
class Marker(IdlStruct, typename=dds_name("visualization_msgs", "Marker")):
    header: Header = new(Header)
    ns: str = ""
    id: int32 = 0
    type: int32 = 0
    action: int32 = 0
    pose: Pose = new(Pose)
    scale: Vector3 = new(Vector3)
    color: ColorRGBA = new(ColorRGBA)
    lifetime: Duration = new(Duration)
    frame_locked: bool = False
    points: sequence[Point] = new(list)
    colors: sequence[ColorRGBA] = new(list)
    texture_resource: str = ""
    texture: CompressedImage = new(CompressedImage)
    uv_coordinates: sequence[UVCoordinate] = new(list)
    text: str = ""
    mesh_resource: str = ""
    mesh_file: MeshFile = new(MeshFile)
    mesh_use_embedded_materials: bool = False


@dataclass
@final
class MarkerArray(IdlStruct, typename=dds_name("visualization_msgs", "MarkerArray")):
    markers: sequence[Marker] = new(list)


@dataclass
@final
class KeyValue(IdlStruct, typename=dds_name("diagnostic_msgs", "KeyValue")):
    key: str = ""
    value: str = ""


@dataclass
@final
class DiagnosticStatus(IdlStruct, typename=dds_name("diagnostic_msgs", "DiagnosticStatus")):
    level: byte = 0
    name: str = ""
    message: str = ""
    hardware_id: str = ""
    values: sequence[KeyValue] = new(list)


@dataclass
@final
class DiagnosticArray(IdlStruct, typename=dds_name("diagnostic_msgs", "DiagnosticArray")):
    header: Header = new(Header)
    status: sequence[DiagnosticStatus] = new(list)


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
