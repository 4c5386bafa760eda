//! The two clocks: the machine's and one that its owner steps.

use std::{
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    time::Duration,
};

use rustix::{
    io::Errno,
    thread::clock_nanosleep_absolute,
    time::{ClockId, Timespec, clock_gettime},
};

/// Tells the time of the stack, ns. Never runs backwards.
pub trait Clock {
    /// Time now, ns since an arbitrary zero.
    fn now_ns(&self) -> u64;
}

impl<C: Clock + ?Sized> Clock for &C {
    fn now_ns(&self) -> u64 {
        (**self).now_ns()
    }
}

impl<C: Clock + ?Sized> Clock for Arc<C> {
    fn now_ns(&self) -> u64 {
        (**self).now_ns()
    }
}

/// `CLOCK_MONOTONIC`: the clock of every process on this machine, unaffected by changes of the date.
#[derive(Debug, Clone, Copy, Default)]
pub struct RealClock;

impl Clock for RealClock {
    fn now_ns(&self) -> u64 {
        let now = clock_gettime(ClockId::Monotonic);
        now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
    }
}

/// A clock that stands still until its owner moves it: virtual time of the evaluation, of lockstep replay and of tests.
#[derive(Debug, Default)]
pub struct SteppedClock {
    now_ns: AtomicU64,
}

impl SteppedClock {
    /// A clock that shows `now_ns`.
    pub const fn new(now_ns: u64) -> Self {
        Self { now_ns: AtomicU64::new(now_ns) }
    }

    /// Moves the clock to `now_ns`. An earlier time than it already shows leaves it where it is.
    pub fn set(&self, now_ns: u64) {
        self.now_ns.fetch_max(now_ns, Ordering::SeqCst);
    }

    /// Moves the clock on.
    pub fn advance(&self, step: Duration) {
        self.now_ns.fetch_add(nanoseconds(step), Ordering::SeqCst);
    }
}

impl Clock for SteppedClock {
    fn now_ns(&self) -> u64 {
        self.now_ns.load(Ordering::SeqCst)
    }
}

/// A duration in ns; the 584 years that a `u64` can hold are the limit.
pub(crate) fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

/// Sleeps until `CLOCK_MONOTONIC` shows `due_ns`, or a signal arrives.
pub(crate) fn sleep_until(due_ns: u64) {
    let due = Timespec {
        tv_sec: (due_ns / 1_000_000_000).cast_signed(),
        tv_nsec: (due_ns % 1_000_000_000).cast_signed(),
    };
    match clock_nanosleep_absolute(ClockId::Monotonic, &due) {
        Ok(()) | Err(Errno::INTR) => {}
        // The call is refused only where the kernel or a sandbox lacks it; a coarser sleep keeps the cycle going.
        Err(_) => std::thread::sleep(Duration::from_micros(100)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stepped_clock_moves_only_when_told_and_never_backwards() {
        let clock = SteppedClock::new(5);
        assert_eq!(clock.now_ns(), 5);
        clock.set(9);
        clock.set(7);
        assert_eq!(clock.now_ns(), 9);
        clock.advance(Duration::from_micros(1));
        assert_eq!(clock.now_ns(), 1_009);
    }

    #[test]
    fn the_real_clock_moves_by_itself() {
        let before_ns = RealClock.now_ns();
        std::thread::sleep(Duration::from_millis(1));
        assert!(RealClock.now_ns() >= before_ns + 1_000_000);
    }
}
