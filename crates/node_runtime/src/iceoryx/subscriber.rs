//! The receiving end of a service in shared memory.

use iceoryx2::port::subscriber::Subscriber as IceoryxSubscriber;
use messages::Message;

use super::{StillbornWatch, service::Service};

#[derive(Debug)]
pub(crate) struct Subscriber<T: Message> {
    pub(super) port: IceoryxSubscriber<Service, T, ()>,
    pub(super) failures: u64,
    /// Last: iceoryx2 may clean up after the dead while it drops the last port of a process.
    pub(super) _watch: StillbornWatch,
}

impl<T: Message> Subscriber<T> {
    pub(crate) fn newest(&mut self) -> Option<T> {
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

    pub(crate) fn drain(&mut self, mut take: impl FnMut(&T)) -> usize {
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

    pub(crate) const fn failures(&self) -> u64 {
        self.failures
    }
}
