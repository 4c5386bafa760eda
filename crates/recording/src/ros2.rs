//! The ROS 2 messages the stack reads and writes, each with its definition for recordings.
//!
//! Lives here: how a Rust struct becomes a `ros2msg` definition, and the comparison of definitions. The structs are in
//! the submodules, one per ROS package. Field names are those of ROS, hence without units: SI throughout (REP-103).

#[macro_use]
mod definition;
mod autoware_perception_msgs;
mod builtin_interfaces;
mod cncbf_msgs;
mod derived_object_msgs;
mod diagnostic_msgs;
mod geometry_msgs;
mod hunav_msgs;
mod nav2_dynamic_msgs;
mod nav_msgs;
mod people_msgs;
mod rosgraph_msgs;
mod sensor_msgs;
mod shape_msgs;
mod signature;
mod std_msgs;
mod tf2_msgs;
mod unique_identifier_msgs;
mod vision_msgs;
mod visualization_msgs;

pub use autoware_perception_msgs::{
    ObjectClassification, Shape, TrackedObject, TrackedObjectKinematics, TrackedObjects,
};
pub use builtin_interfaces::{Duration, Time};
pub use cncbf_msgs::FilterState;
pub use definition::{Byte, Field, Ros2Message};
pub use derived_object_msgs::{Object, ObjectArray};
pub use diagnostic_msgs::{DiagnosticArray, DiagnosticStatus, KeyValue};
pub use geometry_msgs::{
    Accel, AccelStamped, AccelWithCovariance, Point, Point32, Polygon, Pose, PoseArray, PoseStamped,
    PoseWithCovariance, Quaternion, Transform, TransformStamped, Twist, TwistStamped, TwistWithCovariance,
    Vector3,
};
pub use hunav_msgs::{Agent, AgentBehavior, Agents, hunav1};
pub use nav_msgs::{Odometry, Path};
pub use nav2_dynamic_msgs::{Obstacle, ObstacleArray};
pub use people_msgs::{People, Person};
pub use rosgraph_msgs::Clock;
pub use sensor_msgs::CompressedImage;
pub use shape_msgs::SolidPrimitive;
pub(crate) use signature::wire_signature;
pub use std_msgs::{ColorRGBA, Float64, Header};
pub use tf2_msgs::TFMessage;
pub use unique_identifier_msgs::UUID;
pub use vision_msgs::{
    BoundingBox3D, Detection3D, Detection3DArray, ObjectHypothesis, ObjectHypothesisWithPose,
};
pub use visualization_msgs::{Marker, MarkerArray, MeshFile, UVCoordinate};
