//! Package `sensor_msgs`: only what a marker may carry.

use super::Header;

ros_message! {
    /// A picture file.
    "sensor_msgs/CompressedImage" CompressedImage {
        /// When and in which frame.
        header: Header,
        /// File format.
        format: String,
        /// The file.
        data: Vec<u8>,
    }
}
