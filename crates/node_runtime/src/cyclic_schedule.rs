//! Absolute due times, hence no drift, and the cycles that begin at them. Knows no clock.

use std::time::Duration;

use messages::Trigger;

use crate::clock::nanoseconds;

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
}
