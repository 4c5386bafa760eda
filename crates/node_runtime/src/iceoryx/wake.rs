//! Waking a process through iceoryx2's events.

use std::os::fd::BorrowedFd;

use iceoryx2::{
    port::{listener::Listener as IceoryxListener, notifier::Notifier},
    prelude::FileDescriptorBased,
};
use iceoryx2_cal::event::ListenerWaitError;

use super::{StillbornWatch, service::Service};
use crate::Woken;

#[derive(Debug)]
pub(crate) struct Listener {
    pub(super) port: IceoryxListener<Service>,
    /// Last: iceoryx2 may clean up after the dead while it drops the last port of a process.
    pub(super) _watch: StillbornWatch,
}

impl Listener {
    /// Collects the wake-ups that are pending.
    pub(crate) fn look(&self) -> Woken {
        match self.port.try_wait(|_| {}) {
            Ok(0)
            | Err(
                ListenerWaitError::InterruptSignal
                | ListenerWaitError::ContractViolation
                | ListenerWaitError::InternalFailure,
            ) => Woken::TimedOut,
            Ok(_) => Woken::Notified,
        }
    }

    /// What can be read once there is something to collect.
    pub(crate) fn descriptor(&self) -> BorrowedFd<'_> {
        // SAFETY: the number stays a descriptor's for as long as the listener lives, which is borrowed as long as the
        // result, and nothing here closes it.
        #[expect(unsafe_code, reason = "iceoryx2 tells its socket as a number only")]
        unsafe {
            BorrowedFd::borrow_raw(self.port.file_descriptor().native_handle())
        }
    }
}

#[derive(Debug)]
pub(crate) struct Waker {
    pub(super) port: Notifier<Service>,
    /// Last: iceoryx2 may clean up after the dead while it drops the last port of a process.
    pub(super) _watch: StillbornWatch,
}

impl Waker {
    pub(crate) fn wake(&self) {
        // The only failures concern the event id, which is fixed, and deadlines, which no service here has.
        let _ = self.port.notify();
    }
}
