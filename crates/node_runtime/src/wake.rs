//! Waking a process when something arrived for it: one listener per process, any number of wakers.

#[cfg(feature = "dds")]
use std::sync::Arc;
use std::{os::fd::BorrowedFd, time::Duration};

use rustix::{
    event::{PollFd, PollFlags, poll},
    io::Errno,
    time::Timespec,
};

#[cfg(feature = "dds")]
use crate::dds;
use crate::{
    clock::{Clock, RealClock, nanoseconds, sleep_until},
    iceoryx,
};

/// Looks of one wait that may find nothing though the listener says that there is something. One is left by a wake-up that was
/// collected before its signal came; more come from a listener that is broken.
const FRUITLESS_LOOKS: usize = 8;

/// Why a wait returned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Woken {
    /// Somebody called [`Waker::wake`], once or several times.
    Notified,
    /// Time ran out, or a signal came in between; look at the clock and at [`crate::Shutdown`].
    TimedOut,
}

/// This process' single listener.
#[derive(Debug)]
pub struct WakeUp(pub(crate) Listener);

/// The listener of one transport.
#[derive(Debug)]
pub(crate) enum Listener {
    Iceoryx(Box<iceoryx::Listener>),
    #[cfg(feature = "dds")]
    Dds(dds::Listener),
}

impl WakeUp {
    /// Sleeps until somebody wakes this process or `timeout` has passed. Several wake-ups before the call count as one.
    pub fn wait(&self, timeout: Duration) -> Woken {
        self.wait_until(RealClock.now_ns().saturating_add(nanoseconds(timeout)))
    }

    /// Sleeps until somebody wakes this process or `CLOCK_MONOTONIC` shows `due_ns`; only looks if it already does.
    ///
    /// The sleep ends on the kernel's high-resolution timer. What it may be late by is the thread's timer slack, or a
    /// thousandth of the sleep where that is longer; a thread of a real-time class has neither.
    pub fn wait_until(&self, due_ns: u64) -> Woken {
        // Twice, because a look resets the listener while a waker may be half-way: what that waker leaves behind is a
        // listener that counts as notified with nothing to read, to which others would send nothing.
        if self.look() == Woken::Notified || self.look() == Woken::Notified {
            return Woken::Notified;
        }
        for _ in 0..FRUITLESS_LOOKS {
            let now_ns = RealClock.now_ns();
            if now_ns >= due_ns {
                return Woken::TimedOut;
            }
            match sleep(self.descriptor(), due_ns - now_ns) {
                Ok(0) | Err(Errno::INTR) => return Woken::TimedOut,
                Ok(_) => {
                    if self.look() == Woken::Notified {
                        return Woken::Notified;
                    }
                }
                Err(_) => break,
            }
        }
        // A broken listener must not turn the caller's loop into a busy one: keep its heartbeat.
        sleep_until(due_ns);
        Woken::TimedOut
    }

    /// Whether somebody woke this process since the last call of any of the three. Does not sleep: for who spins.
    pub fn look(&self) -> Woken {
        match &self.0 {
            Listener::Iceoryx(listener) => listener.look(),
            #[cfg(feature = "dds")]
            Listener::Dds(listener) => listener.look(),
        }
    }

    fn descriptor(&self) -> BorrowedFd<'_> {
        match &self.0 {
            Listener::Iceoryx(listener) => listener.descriptor(),
            #[cfg(feature = "dds")]
            Listener::Dds(listener) => listener.descriptor(),
        }
    }
}

/// Sleeps until the descriptor can be read; 0 once `duration_ns` have passed.
fn sleep(descriptor: BorrowedFd<'_>, duration_ns: u64) -> Result<usize, Errno> {
    let timeout = Timespec {
        tv_sec: (duration_ns / 1_000_000_000).cast_signed(),
        tv_nsec: (duration_ns % 1_000_000_000).cast_signed(),
    };
    poll(&mut [PollFd::new(&descriptor, PollFlags::IN)], Some(&timeout))
}

/// Wakes one other process.
#[derive(Debug)]
pub struct Waker(pub(crate) Notifier);

/// The waker of one transport.
#[derive(Debug)]
pub(crate) enum Notifier {
    Iceoryx(Box<iceoryx::Waker>),
    /// Another process is woken by the message that was sent to it before; this one can be woken.
    #[cfg(feature = "dds")]
    Dds(Option<Arc<ros2_client::dds::rustdds::mio1::Waker>>),
}

impl Waker {
    /// Wakes the process. Never blocks, and does nothing if the process is not there or already has a wake-up pending.
    ///
    /// Over [`crate::Transport::Dds`] it wakes this process only, from another of its threads: there, the message sent before
    /// wakes every other one.
    pub fn wake(&self) {
        match &self.0 {
            Notifier::Iceoryx(waker) => waker.wake(),
            #[cfg(feature = "dds")]
            Notifier::Dds(own) => {
                // It fails only where the system does; the listener then looks when its time is up.
                let _ = own.as_ref().map(|own| own.wake());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::os::fd::{AsRawFd, FromRawFd, OwnedFd};

    use messages::ProcessId;

    use super::*;
    use crate::{Node, ScopedDomain, processor_share::thread_time_ns};

    #[test]
    fn a_broken_listener_sleeps_until_the_due_time() {
        let domain = ScopedDomain::new();
        let node = Node::open_in(&domain, "broken", ProcessId::Filter).unwrap();
        let wake_up = node.wake_up().unwrap();
        // Always readable, and no socket.
        let null = std::fs::File::open("/dev/null").unwrap();
        // SAFETY: the listener keeps its descriptor open and is not used meanwhile; `forget` leaves the closing to it.
        #[expect(unsafe_code, reason = "the descriptor belongs to iceoryx2, which breaks it for nobody")]
        let mut descriptor = unsafe { OwnedFd::from_raw_fd(wake_up.descriptor().as_raw_fd()) };
        rustix::io::dup2(&null, &mut descriptor).unwrap();
        std::mem::forget(descriptor);

        let (begin_ns, taken_before_ns) = (RealClock.now_ns(), thread_time_ns());
        let due_ns = begin_ns + 300_000_000;
        assert_eq!(wake_up.wait_until(due_ns), Woken::TimedOut);
        assert!(RealClock.now_ns() >= due_ns);
        let taken_ns = thread_time_ns() - taken_before_ns;
        assert!(taken_ns < 100_000_000, "{taken_ns} ns of processor time");
    }
}
