//! Package `rosgraph_msgs`: simulated time.

use super::Time;

ros_message! {
    /// What a simulation's clock shows, as on `/clock`.
    "rosgraph_msgs/Clock" Clock {
        /// The time.
        clock: Time,
    }
}
