//! Package `geometry_msgs`: points, poses, velocities, transforms. Metres, radians, seconds.

use super::Header;

ros_message! {
    /// A point, m.
    "geometry_msgs/Point" Point {
        /// Along x.
        x: f64,
        /// Along y.
        y: f64,
        /// Along z.
        z: f64,
    }

    /// A vector; its unit is that of its use.
    "geometry_msgs/Vector3" Vector3 {
        /// Along x.
        x: f64,
        /// Along y.
        y: f64,
        /// Along z.
        z: f64,
    }

    /// An orientation as a unit quaternion.
    "geometry_msgs/Quaternion" Quaternion {
        /// i part.
        x: f64,
        /// j part.
        y: f64,
        /// k part.
        z: f64,
        /// Real part.
        w: f64,
    }

    /// A position and an orientation.
    "geometry_msgs/Pose" Pose {
        /// Where.
        position: Point,
        /// Turned how.
        orientation: Quaternion,
    }

    /// A pose with the covariance of `[x, y, z, rotation x, rotation y, rotation z]`.
    "geometry_msgs/PoseWithCovariance" PoseWithCovariance {
        /// The pose.
        pose: Pose,
        /// Row-major 6×6.
        covariance: [[f64; 6]; 6],
    }

    /// A pose with time and frame.
    "geometry_msgs/PoseStamped" PoseStamped {
        /// When and in which frame.
        header: Header,
        /// The pose.
        pose: Pose,
    }

    /// Many poses of the same time and frame.
    "geometry_msgs/PoseArray" PoseArray {
        /// When and in which frame.
        header: Header,
        /// The poses.
        poses: Vec<Pose>,
    }

    /// Linear and angular velocity, m/s and rad/s.
    "geometry_msgs/Twist" Twist {
        /// Linear.
        linear: Vector3,
        /// Angular.
        angular: Vector3,
    }

    /// A twist with the covariance of `[vx, vy, vz, rate x, rate y, rate z]`.
    "geometry_msgs/TwistWithCovariance" TwistWithCovariance {
        /// The twist.
        twist: Twist,
        /// Row-major 6×6.
        covariance: [[f64; 6]; 6],
    }

    /// A twist with time and frame.
    "geometry_msgs/TwistStamped" TwistStamped {
        /// When and in which frame.
        header: Header,
        /// The twist.
        twist: Twist,
    }

    /// Linear and angular acceleration, m/s² and rad/s².
    "geometry_msgs/Accel" Accel {
        /// Linear.
        linear: Vector3,
        /// Angular.
        angular: Vector3,
    }

    /// An acceleration with the covariance of `[ax, ay, az, and those of the rotation]`.
    "geometry_msgs/AccelWithCovariance" AccelWithCovariance {
        /// The acceleration.
        accel: Accel,
        /// Row-major 6×6.
        covariance: [[f64; 6]; 6],
    }

    /// A point in single precision, m.
    "geometry_msgs/Point32" Point32 {
        /// Along x.
        x: f32,
        /// Along y.
        y: f32,
        /// Along z.
        z: f32,
    }

    /// A closed outline.
    "geometry_msgs/Polygon" Polygon {
        /// Its corners, in order.
        points: Vec<Point32>,
    }

    /// An acceleration with time and frame.
    "geometry_msgs/AccelStamped" AccelStamped {
        /// When and in which frame.
        header: Header,
        /// The acceleration.
        accel: Accel,
    }

    /// A rigid motion: first rotate, then translate.
    "geometry_msgs/Transform" Transform {
        /// m.
        translation: Vector3,
        /// Unit quaternion.
        rotation: Quaternion,
    }

    /// Takes coordinates in `child_frame_id` to coordinates in `header.frame_id`.
    "geometry_msgs/TransformStamped" TransformStamped {
        /// When, and the parent frame.
        header: Header,
        /// The child frame.
        child_frame_id: String,
        /// The transform.
        transform: Transform,
    }
}

impl Quaternion {
    /// Rotation about z by `heading_rad`.
    pub fn from_heading(heading_rad: f64) -> Self {
        let (sin, cos) = (0.5 * heading_rad).sin_cos();
        Self { x: 0.0, y: 0.0, z: sin, w: cos }
    }
}
