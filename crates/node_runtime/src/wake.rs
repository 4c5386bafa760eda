//! Waking a process when something arrived for it: one listener per process, any number of wakers.

use std::time::Duration;

use iceoryx2::{
    port::{listener::Listener, notifier::Notifier},
    service::ipc_threadsafe::Service,
};
use iceoryx2_cal::event::ListenerWaitError;

use crate::stillborn::StillbornWatch;

/// Shortest time that iceoryx2 can hand to the operating system, which takes zero for "wait for ever".
const SHORTEST_WAIT: Duration = Duration::from_micros(1);

/// Why [`WakeUp::wait`] returned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Woken {
    /// Somebody called [`Waker::wake`], once or several times.
    Notified,
    /// Time ran out, or a signal came in between; look at the clock and at [`crate::Shutdown`].
    TimedOut,
}

/// This process' single listener.
#[derive(Debug)]
pub struct WakeUp {
    pub(crate) listener: Listener<Service>,
    /// Last: iceoryx2 may clean up after the dead while it drops the last port of a process.
    pub(crate) _watch: StillbornWatch,
}

impl WakeUp {
    /// Sleeps until somebody wakes this process or `timeout` has passed. Several wake-ups before the call count as one.
    /// With less than a microsecond left it only looks.
    pub fn wait(&self, timeout: Duration) -> Woken {
        let woken = if timeout < SHORTEST_WAIT {
            self.listener.try_wait(|_| {})
        } else {
            self.listener.timed_wait(|_| {}, timeout)
        };
        match woken {
            Ok(0) | Err(ListenerWaitError::InterruptSignal) => Woken::TimedOut,
            Ok(_) => Woken::Notified,
            Err(ListenerWaitError::ContractViolation | ListenerWaitError::InternalFailure) => {
                // A broken listener must not turn the caller's loop into a busy one: keep its heartbeat.
                std::thread::sleep(timeout);
                Woken::TimedOut
            }
        }
    }
}

/// Wakes one other process.
#[derive(Debug)]
pub struct Waker {
    pub(crate) notifier: Notifier<Service>,
    /// Last: iceoryx2 may clean up after the dead while it drops the last port of a process.
    pub(crate) _watch: StillbornWatch,
}

impl Waker {
    /// Wakes the process. Never blocks, and does nothing if the process is not there or already has a wake-up pending.
    pub fn wake(&self) {
        // The only failures concern the event id, which is fixed, and deadlines, which no service here has.
        let _ = self.notifier.notify();
    }
}
