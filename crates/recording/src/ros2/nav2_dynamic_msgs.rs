//! Package `nav2_dynamic_msgs`: tracked obstacles of Nav2's dynamic obstacle tracking.

use super::{Header, Point, UUID, Vector3};

ros_message! {
    /// A tracked obstacle.
    "nav2_dynamic_msgs/Obstacle" Obstacle {
        /// Identity over time.
        uuid: UUID,
        /// Confidence.
        score: f32,
        /// Its centre, m.
        position: Point,
        /// Velocity in the frame of the message, m/s.
        velocity: Vector3,
        /// Edges of a box around it, m.
        size: Vector3,
    }

    /// All obstacles that are followed.
    "nav2_dynamic_msgs/ObstacleArray" ObstacleArray {
        /// When and in which frame.
        header: Header,
        /// The obstacles.
        obstacles: Vec<Obstacle>,
    }
}
