//! Package `std_msgs`: header, scalar, colour.

use super::Time;

ros_message! {
    /// When and in which frame.
    "std_msgs/Header" Header {
        /// Time of measurement.
        stamp: Time,
        /// Coordinate frame of the content.
        frame_id: String,
    }

    /// One number.
    "std_msgs/Float64" Float64 {
        /// The number.
        data: f64,
    }

    /// A colour, each part in [0, 1].
    "std_msgs/ColorRGBA" ColorRGBA {
        /// Red.
        r: f32,
        /// Green.
        g: f32,
        /// Blue.
        b: f32,
        /// Opacity.
        a: f32,
    }
}
