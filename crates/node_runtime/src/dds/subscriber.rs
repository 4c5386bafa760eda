//! The receiving end of a topic.

use std::fmt;

use messages::Message;
use ros2_client::dds::Subscription;

use super::frame::Frame;

/// Most samples that one call takes, so that a fast sender cannot hold the caller. RustDDS keeps at least the queue's length
/// and up to 64 more.
const READ_LIMIT: usize = 512;

pub(crate) struct Subscriber<T: Message> {
    pub(super) port: Subscription<Frame<T>>,
    pub(super) failures: u64,
}

impl<T: Message> Subscriber<T> {
    pub(crate) fn newest(&mut self) -> Option<T> {
        let mut newest = None;
        self.drain(|message| newest = Some(*message));
        newest
    }

    pub(crate) fn drain(&mut self, mut take: impl FnMut(&T)) -> usize {
        let mut count = 0;
        for _ in 0..READ_LIMIT {
            match self.port.take() {
                Ok(Some((Frame(message), _))) => {
                    take(&message);
                    count += 1;
                }
                Ok(None) => break,
                Err(_) => self.failures += 1,
            }
        }
        count
    }

    pub(crate) const fn failures(&self) -> u64 {
        self.failures
    }
}

impl<T: Message> fmt::Debug for Subscriber<T> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("Subscriber").field("service", &T::SERVICE).finish_non_exhaustive()
    }
}
