//! The sending end of a topic.

use std::fmt;

use messages::Message;
use ros2_client::{WriteError, dds::Publisher as RosPublisher};

use super::frame::Frame;
use crate::PortError;

pub(crate) struct Publisher<T: Message> {
    pub(super) port: RosPublisher<Frame<T>>,
}

impl<T: Message> Publisher<T> {
    pub(crate) fn send(&self, message: &T) -> Result<(), PortError> {
        let service = T::SERVICE;
        self.port.publish(Frame(*message)).map_err(|error| PortError::NotDelivered {
            service,
            cause: match error {
                WriteError::WouldBlock { .. } => "too much is unconfirmed",
                WriteError::Serialization { .. } => "it could not be encoded",
                WriteError::Poisoned { .. } => "DDS' own thread is gone",
                WriteError::Io(_) => "its socket failed",
                WriteError::Internal { .. } | WriteError::Middleware { .. } => "DDS failed inside",
            },
        })
    }
}

impl<T: Message> fmt::Debug for Publisher<T> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("Publisher").field("service", &T::SERVICE).finish_non_exhaustive()
    }
}
