//! The receiving end of a service.

use messages::Message;

#[cfg(feature = "dds")]
use crate::dds;
use crate::iceoryx;

/// Receives one type of message from its service. May be moved to another thread.
#[derive(Debug)]
pub struct Subscriber<T: Message>(pub(crate) Link<T>);

/// The subscriber of one transport.
#[derive(Debug)]
pub(crate) enum Link<T: Message> {
    Iceoryx(iceoryx::Subscriber<T>),
    #[cfg(feature = "dds")]
    Dds(Box<dds::Subscriber<T>>),
}

impl<T: Message> Subscriber<T> {
    /// The newest message that arrived since the last call, if any; older ones are dropped.
    pub fn newest(&mut self) -> Option<T> {
        match &mut self.0 {
            Link::Iceoryx(subscriber) => subscriber.newest(),
            #[cfg(feature = "dds")]
            Link::Dds(subscriber) => subscriber.newest(),
        }
    }

    /// Calls `take` with every message that arrived since the last call, oldest first, and returns how many there were.
    ///
    /// At most as many as the queue holds, so that a fast sender cannot hold the caller.
    pub fn drain(&mut self, take: impl FnMut(&T)) -> usize {
        match &mut self.0 {
            Link::Iceoryx(subscriber) => subscriber.drain(take),
            #[cfg(feature = "dds")]
            Link::Dds(subscriber) => subscriber.drain(take),
        }
    }

    /// How often receiving failed, for example because a publisher's memory could not be mapped.
    pub const fn failures(&self) -> u64 {
        match &self.0 {
            Link::Iceoryx(subscriber) => subscriber.failures(),
            #[cfg(feature = "dds")]
            Link::Dds(subscriber) => subscriber.failures(),
        }
    }
}
