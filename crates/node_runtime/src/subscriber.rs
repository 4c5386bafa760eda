//! The receiving end of a service.

use iceoryx2::{port::subscriber::Subscriber as IceoryxSubscriber, service::ipc_threadsafe::Service};
use messages::Message;

use crate::stillborn::StillbornWatch;

/// Receives one type of message from its service. May be moved to another thread.
#[derive(Debug)]
pub struct Subscriber<T: Message> {
    pub(crate) port: IceoryxSubscriber<Service, T, ()>,
    pub(crate) failures: u64,
    /// Last: iceoryx2 may clean up after the dead while it drops the last port of a process.
    pub(crate) _watch: StillbornWatch,
}

impl<T: Message> Subscriber<T> {
    /// The newest message that arrived since the last call, if any; older ones are dropped.
    pub fn newest(&mut self) -> Option<T> {
        let mut newest = None;
        // Bounded, so that a sender faster than this loop cannot hold the caller.
        for _ in 0..=self.port.buffer_size() {
            match self.port.receive() {
                Ok(Some(sample)) => newest = Some(sample),
                Ok(None) => break,
                Err(_) => self.failures += 1,
            }
        }
        newest.map(|sample| *sample)
    }

    /// Calls `take` with every message that arrived since the last call, oldest first, and returns how many there were.
    ///
    /// At most as many as the queue holds, so that a fast sender cannot hold the caller.
    pub fn drain(&mut self, mut take: impl FnMut(&T)) -> usize {
        let mut count = 0;
        for _ in 0..self.port.buffer_size() {
            match self.port.receive() {
                Ok(Some(sample)) => {
                    take(&sample);
                    count += 1;
                }
                Ok(None) => break,
                Err(_) => self.failures += 1,
            }
        }
        count
    }

    /// How often receiving failed, for example because a publisher's memory could not be mapped.
    pub const fn failures(&self) -> u64 {
        self.failures
    }
}
