//! Package `tf2_msgs`: transforms between frames.

use super::TransformStamped;

ros_message! {
    /// Some transforms, as on `/tf` and `/tf_static`.
    "tf2_msgs/TFMessage" TFMessage {
        /// The transforms.
        transforms: Vec<TransformStamped>,
    }
}
