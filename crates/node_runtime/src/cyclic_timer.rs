//! The cyclic loop's timer: absolute due times on `CLOCK_MONOTONIC`, hence no drift.
//!
//! Scheduling class, memory locking and affinity belong to the thread that waits here and are not set by the timer.

use std::time::Duration;

use messages::Trigger;
use rustix::{
    io::Errno,
    thread::{ClockId, clock_nanosleep_absolute},
    time::Timespec,
};

use crate::clock::{Clock, RealClock, nanoseconds};

/// One cycle's beginning, as planned and as it was.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tick {
    /// What began it.
    pub trigger: Trigger,
    /// When the cycle was due, ns; `woke_ns` where an input began it.
    pub due_ns: u64,
    /// When it began, ns; not before `due_ns`.
    pub woke_ns: u64,
    /// Due times between the timer's last cycle and this one that passed without a cycle.
    pub skipped: u64,
}

impl Tick {
    /// A cycle of the timer that was due at `due_ns` and began at `woke_ns`.
    pub const fn timer(due_ns: u64, woke_ns: u64) -> Self {
        Self { trigger: Trigger::Timer, due_ns, woke_ns, skipped: 0 }
    }

    /// A cycle that an input began at `woke_ns`.
    pub const fn event(woke_ns: u64) -> Self {
        Self { trigger: Trigger::Event, due_ns: woke_ns, woke_ns, skipped: 0 }
    }

    /// How late the cycle began, ns.
    pub const fn lateness_ns(&self) -> u64 {
        self.woke_ns.saturating_sub(self.due_ns)
    }
}

/// Due times `start + k·period`, without a clock.
///
/// A cycle that begins more than one period late takes the newest due time that has passed; those before are skipped and
/// counted. The phase never shifts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CyclicSchedule {
    period_ns: u64,
    next_due_ns: u64,
}

impl CyclicSchedule {
    /// The schedule whose first cycle is due at `first_due_ns`. A period of zero is taken as 1 ns.
    pub fn new(first_due_ns: u64, period: Duration) -> Self {
        Self { period_ns: nanoseconds(period).max(1), next_due_ns: first_due_ns }
    }

    /// When the next cycle is due, ns.
    pub const fn next_due_ns(&self) -> u64 {
        self.next_due_ns
    }

    /// Period, ns.
    pub const fn period_ns(&self) -> u64 {
        self.period_ns
    }

    /// Puts the next cycle one period after `now_ns`; the others follow it.
    pub const fn restart(&mut self, now_ns: u64) {
        self.next_due_ns = now_ns.saturating_add(self.period_ns);
    }

    /// Sets when the next cycle is due; the others follow it.
    pub const fn set_due(&mut self, due_ns: u64) {
        self.next_due_ns = due_ns;
    }

    /// Begins a cycle at `now_ns` if one is due.
    pub const fn begin(&mut self, now_ns: u64) -> Option<Tick> {
        if now_ns < self.next_due_ns {
            return None;
        }
        let skipped = (now_ns - self.next_due_ns) / self.period_ns;
        let due_ns = self.next_due_ns + skipped * self.period_ns;
        self.next_due_ns = due_ns + self.period_ns;
        Some(Tick { trigger: Trigger::Timer, due_ns, woke_ns: now_ns, skipped })
    }
}

/// Begins cycles on `CLOCK_MONOTONIC`, sleeping in between with `clock_nanosleep(TIMER_ABSTIME)`.
#[derive(Debug)]
pub struct CyclicTimer {
    schedule: CyclicSchedule,
    clock: RealClock,
    spin_ns: u64,
}

impl CyclicTimer {
    /// A timer whose first cycle is due one period from now. Only the real clock can be slept on.
    pub fn new(clock: RealClock, period: Duration) -> Self {
        let first_due_ns = clock.now_ns().saturating_add(nanoseconds(period));
        Self { schedule: CyclicSchedule::new(first_due_ns, period), clock, spin_ns: 0 }
    }

    /// Sleeps only until `spin` before a cycle is due and reads the clock for the rest: sooner awake, for that much more
    /// processor time in every period. A SCHED_FIFO thread must leave the processor most of the time, so keep it short.
    #[must_use]
    pub fn spinning(self, spin: Duration) -> Self {
        Self { spin_ns: nanoseconds(spin), ..self }
    }

    /// Sleeps until the next cycle is due and begins it. Returns at once if it already is. Signals do not cut it short.
    pub fn wait(&mut self) -> Tick {
        loop {
            let now_ns = self.clock.now_ns();
            if let Some(tick) = self.schedule.begin(now_ns) {
                return tick;
            }
            let sleep_end_ns = self.schedule.next_due_ns().saturating_sub(self.spin_ns);
            if now_ns < sleep_end_ns {
                sleep_until(sleep_end_ns);
            } else {
                std::hint::spin_loop();
            }
        }
    }

    /// The due times.
    pub const fn schedule(&self) -> &CyclicSchedule {
        &self.schedule
    }
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

    const PERIOD: Duration = Duration::from_nanos(100);

    #[test]
    fn lateness_below_a_period_does_not_shift_the_phase() {
        let mut schedule = CyclicSchedule::new(1_000, PERIOD);
        assert_eq!(schedule.begin(999), None);
        assert_eq!(schedule.begin(1_099), Some(Tick::timer(1_000, 1_099)));
        assert_eq!(schedule.begin(1_099), None);
        assert_eq!(schedule.begin(1_100), Some(Tick::timer(1_100, 1_100)));
    }

    #[test]
    fn whole_periods_that_were_slept_through_are_skipped_and_counted() {
        let mut schedule = CyclicSchedule::new(1_000, PERIOD);
        assert_eq!(schedule.begin(1_350), Some(Tick { skipped: 3, ..Tick::timer(1_300, 1_350) }));
        assert_eq!(schedule.next_due_ns(), 1_400);
    }

    #[test]
    fn a_zero_period_does_not_divide_by_zero() {
        assert!(CyclicSchedule::new(0, Duration::ZERO).begin(10).is_some());
    }

    #[test]
    fn a_spinning_timer_is_never_early() {
        let mut timer =
            CyclicTimer::new(RealClock, Duration::from_millis(1)).spinning(Duration::from_micros(300));
        for _ in 0..20 {
            let tick = timer.wait();
            assert!(tick.woke_ns >= tick.due_ns);
        }
    }

    #[test]
    fn ticks_and_skips_together_account_for_all_time_that_passed() {
        let period = Duration::from_millis(2);
        let mut timer = CyclicTimer::new(RealClock, period);
        let start_ns = timer.schedule().next_due_ns();
        let (mut due_times, mut last) = (0, None);
        for _ in 0..50 {
            let tick = timer.wait();
            due_times += 1 + tick.skipped;
            assert!(tick.woke_ns >= tick.due_ns && tick.lateness_ns() < nanoseconds(period));
            last = Some(tick);
        }
        let last = last.unwrap();
        assert_eq!(last.due_ns, start_ns + (due_times - 1) * nanoseconds(period));
        assert!(RealClock.now_ns() >= last.due_ns);
    }
}
