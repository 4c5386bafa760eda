//! Package `diagnostic_msgs`: how parts of a robot say how they are. The constants are left out of the definition.

use super::{Byte, Header};

ros_message! {
    /// A named value, for people.
    "diagnostic_msgs/KeyValue" KeyValue {
        /// What the value is of.
        key: String,
        /// The value.
        value: String,
    }

    /// How one part is.
    "diagnostic_msgs/DiagnosticStatus" DiagnosticStatus {
        /// How bad it is: see the constants of this type.
        level: Byte,
        /// The part, and what about it is said.
        name: String,
        /// What there is to say.
        message: String,
        /// Which piece of hardware, empty if none.
        hardware_id: String,
        /// Details.
        values: Vec<KeyValue>,
    }

    /// How some parts are, as on `/diagnostics`.
    "diagnostic_msgs/DiagnosticArray" DiagnosticArray {
        /// When; the frame is empty.
        header: Header,
        /// The parts.
        status: Vec<DiagnosticStatus>,
    }
}

impl DiagnosticStatus {
    /// All is well.
    pub const OK: Byte = Byte(0);
    /// Worth a look.
    pub const WARN: Byte = Byte(1);
    /// Does not do its work.
    pub const ERROR: Byte = Byte(2);
    /// Has not been heard of for too long.
    pub const STALE: Byte = Byte(3);
}
