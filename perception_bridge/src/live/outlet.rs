//! One topic that is spoken on, with its record on the board.

use std::sync::Arc;

use messages::Reason;
use node_runtime::{Clock, RealClock};
use recording::ros2::Ros2Message;
use ros2_client::dds::Publisher;

use super::board::TopicRecord;

/// A publisher whose messages are counted.
pub(super) struct Outlet<M: Ros2Message> {
    port: Publisher<M>,
    record: Arc<TopicRecord>,
}

impl<M: Ros2Message> Outlet<M> {
    /// Counts what leaves through `port` in `record`.
    pub(super) fn new(port: Publisher<M>, record: Arc<TopicRecord>) -> Self {
        Self { port, record }
    }

    /// Publishes without waiting for anybody.
    ///
    /// # Errors
    /// What DDS says where the message did not leave.
    pub(super) fn publish(&self, message: M) -> Result<(), String> {
        let sent = self.port.publish(message).map_err(|error| error.to_string());
        match &sent {
            Ok(()) => self.record.passed(RealClock.now_ns()),
            Err(_) => self.record.refused(Reason::PortFailed),
        }
        sent
    }

    /// What is known of its topic.
    pub(super) fn record(&self) -> &Arc<TopicRecord> {
        &self.record
    }
}
