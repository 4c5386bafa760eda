//! Package `unique_identifier_msgs`: identities.

ros_message! {
    /// An identity that is unique without anybody handing it out.
    "unique_identifier_msgs/UUID" UUID {
        /// Its bytes.
        uuid: [u8; 16],
    }
}
