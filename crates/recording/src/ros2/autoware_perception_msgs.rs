//! Package `autoware_perception_msgs`: tracked objects. The constants are left out of the definition; decoding needs none.

use super::{AccelWithCovariance, Header, Polygon, PoseWithCovariance, TwistWithCovariance, UUID, Vector3};

ros_message! {
    /// What an object may be.
    "autoware_perception_msgs/ObjectClassification" ObjectClassification {
        /// Class: see the constants of this type.
        label: u8,
        /// Confidence in [0, 1].
        probability: f32,
    }

    /// Extent of an object.
    "autoware_perception_msgs/Shape" Shape {
        /// Which of the others counts: see the constants of this type.
        r#type: u8,
        /// Outline in the object's frame, m.
        footprint: Polygon,
        /// Edges of a box, or diameter, diameter and height of a cylinder, m.
        dimensions: Vector3,
    }

    /// How a tracked object moves.
    "autoware_perception_msgs/TrackedObjectKinematics" TrackedObjectKinematics {
        /// Where it is.
        pose_with_covariance: PoseWithCovariance,
        /// Its velocity in its own frame.
        twist_with_covariance: TwistWithCovariance,
        /// Its acceleration in its own frame.
        acceleration_with_covariance: AccelWithCovariance,
        /// What is known of the orientation: see the constants of this type.
        orientation_availability: u8,
        /// Whether it stands.
        is_stationary: bool,
    }

    /// An object followed over time.
    "autoware_perception_msgs/TrackedObject" TrackedObject {
        /// Identity over time.
        object_id: UUID,
        /// Confidence in [0, 1] that there is something.
        existence_probability: f32,
        /// What it may be.
        classification: Vec<ObjectClassification>,
        /// How it moves.
        kinematics: TrackedObjectKinematics,
        /// Its extent.
        shape: Shape,
    }

    /// All objects that are followed.
    "autoware_perception_msgs/TrackedObjects" TrackedObjects {
        /// When and in which frame.
        header: Header,
        /// The objects.
        objects: Vec<TrackedObject>,
    }
}

impl ObjectClassification {
    /// Highest label of something on an engine: car, truck, bus, trailer are 1 to 4.
    pub const TRAILER: u8 = 4;
    /// A motorcycle.
    pub const MOTORCYCLE: u8 = 5;
    /// A bicycle.
    pub const BICYCLE: u8 = 6;
    /// A person on foot.
    pub const PEDESTRIAN: u8 = 7;
}

impl Shape {
    /// A box.
    pub const BOUNDING_BOX: u8 = 0;
    /// A cylinder.
    pub const CYLINDER: u8 = 1;
    /// A prism over the footprint.
    pub const POLYGON: u8 = 2;
}

impl TrackedObjectKinematics {
    /// The orientation is known.
    pub const AVAILABLE: u8 = 2;
}
