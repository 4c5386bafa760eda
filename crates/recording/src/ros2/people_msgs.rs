//! Package `people_msgs`: tracked people, as published for ROS 2 by wg-perception.

use super::{Header, Point};

ros_message! {
    /// A person.
    "people_msgs/Person" Person {
        /// Identity over time.
        name: String,
        /// Where, m.
        position: Point,
        /// Velocity in the frame of the message, m/s.
        velocity: Point,
        /// Confidence in [0, 1].
        reliability: f64,
        /// Names of further properties.
        tagnames: Vec<String>,
        /// Their values.
        tags: Vec<String>,
    }

    /// All people that are followed.
    "people_msgs/People" People {
        /// When and in which frame.
        header: Header,
        /// The people.
        people: Vec<Person>,
    }
}
