//! Package `derived_object_msgs` 4.0: detected and tracked objects. The constants are left out of the definition.

use super::{Accel, Header, Polygon, Pose, SolidPrimitive, Twist};

ros_message! {
    /// An object, detected or tracked.
    "derived_object_msgs/Object" Object {
        /// When and in which frame.
        header: Header,
        /// Identity given by the sensor.
        id: u32,
        /// Whether it is tracked: see the constants of this type.
        detection_level: u8,
        /// Whether the fields of its class count.
        object_classified: bool,
        /// Where.
        pose: Pose,
        /// Velocity in the frame of the header. Counts for a tracked object.
        twist: Twist,
        /// Acceleration in the frame of the header. Counts for a tracked object.
        accel: Accel,
        /// Points on its outline, perhaps none.
        polygon: Polygon,
        /// A solid around it.
        shape: SolidPrimitive,
        /// Class: see the constants of this type.
        classification: u8,
        /// Confidence in the class, 255 is certain.
        classification_certainty: u8,
        /// For how many frames it has had this class.
        classification_age: u32,
    }

    /// All objects of one frame of perception.
    "derived_object_msgs/ObjectArray" ObjectArray {
        /// When and in which frame.
        header: Header,
        /// The objects.
        objects: Vec<Object>,
    }
}

impl Object {
    /// Followed over several frames, so that velocity and acceleration count.
    pub const TRACKED: u8 = 1;
    /// A person on foot.
    pub const PEDESTRIAN: u8 = 4;
    /// A bicycle.
    pub const BIKE: u8 = 5;
    /// A car.
    pub const CAR: u8 = 6;
    /// A truck.
    pub const TRUCK: u8 = 7;
    /// A motorcycle.
    pub const MOTORCYCLE: u8 = 8;
    /// Another vehicle.
    pub const OTHER_VEHICLE: u8 = 9;
    /// A barrier.
    pub const BARRIER: u8 = 10;
    /// A sign.
    pub const SIGN: u8 = 11;
}
