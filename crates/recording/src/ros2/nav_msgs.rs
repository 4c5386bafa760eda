//! Package `nav_msgs`: odometry and paths.

use super::{Header, PoseStamped, PoseWithCovariance, TwistWithCovariance};

ros_message! {
    /// Pose in `header.frame_id`, velocity in `child_frame_id`.
    "nav_msgs/Odometry" Odometry {
        /// When, and the frame of the pose.
        header: Header,
        /// The frame of the robot, in which the twist is expressed.
        child_frame_id: String,
        /// Pose of the robot.
        pose: PoseWithCovariance,
        /// Velocity of the robot.
        twist: TwistWithCovariance,
    }

    /// Poses to follow, in order.
    "nav_msgs/Path" Path {
        /// When, and the frame of the poses.
        header: Header,
        /// The poses.
        poses: Vec<PoseStamped>,
    }
}
