//! Waking a process by the data that arrives for it.

use std::{
    cell::RefCell,
    os::fd::{AsFd, BorrowedFd},
    time::Duration,
};

use ros2_client::dds::rustdds::mio1::{Events, Poll, Registry};

use crate::Woken;

/// Readers that one look can tell of.
const EVENTS: usize = 8;

/// Collects what the readers of one process report.
#[derive(Debug)]
pub(crate) struct Listener {
    poll: RefCell<(Poll, Events)>,
    /// Another handle of the same poll, whose descriptor can be borrowed.
    registry: Registry,
}

impl Listener {
    pub(super) fn new(poll: Poll, registry: Registry) -> Self {
        Self { poll: RefCell::new((poll, Events::with_capacity(EVENTS))), registry }
    }

    /// Collects the arrivals that nobody has looked at.
    pub(crate) fn look(&self) -> Woken {
        let (poll, events) = &mut *self.poll.borrow_mut();
        match poll.poll(events, Some(Duration::ZERO)) {
            Ok(()) if !events.is_empty() => Woken::Notified,
            Ok(()) | Err(_) => Woken::TimedOut,
        }
    }

    /// What can be read once there is something to collect.
    pub(crate) fn descriptor(&self) -> BorrowedFd<'_> {
        self.registry.as_fd()
    }
}
