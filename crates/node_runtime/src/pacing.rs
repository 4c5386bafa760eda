//! When a process' cycles begin: at due times, on inputs, or both. Knows neither a clock nor a port.

use std::time::Duration;

use messages::Trigger;

use crate::{CyclicSchedule, Tick};

/// What begins a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Rule {
    /// Fixed due times alone.
    Timer,
    /// Every input, and one period after the last cycle where none comes.
    Event,
    /// Fixed due times, and the first input between two of them.
    Both,
}

/// Decides when cycles begin; one implementation for the live loop and for virtual time.
#[derive(Debug, Clone)]
pub struct Pacing {
    rule: Rule,
    schedule: CyclicSchedule,
    /// With [`Rule::Both`]: whether an input has begun a cycle since the last due time. A flood of inputs then waits for the
    /// next due time, so that it can at most double the rate.
    input_used: bool,
}

impl Pacing {
    /// Cycles at `first_due_ns + k·period` whatever arrives.
    pub fn timer(first_due_ns: u64, period: Duration) -> Self {
        Self::new(Rule::Timer, first_due_ns, period)
    }

    /// A cycle for every input, and one where `longest_wait` has passed since the last, the first at `first_due_ns`.
    pub fn event(first_due_ns: u64, longest_wait: Duration) -> Self {
        Self::new(Rule::Event, first_due_ns, longest_wait)
    }

    /// Cycles at `first_due_ns + k·period`, and one for the first input between two due times.
    pub fn both(first_due_ns: u64, period: Duration) -> Self {
        Self::new(Rule::Both, first_due_ns, period)
    }

    fn new(rule: Rule, first_due_ns: u64, period: Duration) -> Self {
        Self { rule, schedule: CyclicSchedule::new(first_due_ns, period), input_used: false }
    }

    /// When the next cycle is due if no input comes before, ns.
    pub const fn next_due_ns(&self) -> u64 {
        self.schedule.next_due_ns()
    }

    /// Whether an input would begin a cycle now.
    pub const fn heeds_inputs(&self) -> bool {
        match self.rule {
            Rule::Timer => false,
            Rule::Event => true,
            Rule::Both => !self.input_used,
        }
    }

    /// The time between two due times, or the longest wait for an input, ns.
    pub const fn period_ns(&self) -> u64 {
        self.schedule.period_ns()
    }

    /// Begins a cycle at `now_ns` if one is due, or else if `input` says that something arrived and that counts.
    ///
    /// Where inputs alone set the pace there is one due time only, from which lateness counts however long it is: none is
    /// skipped.
    pub fn begin(&mut self, now_ns: u64, input: bool) -> Option<Tick> {
        let heeded = input && self.heeds_inputs();
        let due_ns = self.schedule.next_due_ns();
        let due = self.schedule.begin(now_ns);
        let tick = due.or_else(|| heeded.then(|| Tick::event(now_ns)))?;
        match (self.rule, tick.trigger) {
            (Rule::Timer, _) => Some(tick),
            (Rule::Both, trigger) => {
                self.input_used = trigger == Trigger::Event;
                Some(tick)
            }
            (Rule::Event, trigger) => {
                self.schedule.restart(now_ns);
                Some(if trigger == Trigger::Timer { Tick::timer(due_ns, now_ns) } else { tick })
            }
        }
    }

    /// Has no cycle due before `due_ns`, for a loop that could not begin yet.
    pub fn no_earlier_than(&mut self, due_ns: u64) {
        self.schedule.set_due(due_ns.max(self.schedule.next_due_ns()));
    }

    /// Has the next cycle due at `due_ns` if it were due later, for a process whose work itself says when.
    pub fn no_later_than(&mut self, due_ns: u64) {
        self.schedule.set_due(due_ns.min(self.schedule.next_due_ns()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Duration = Duration::from_nanos(100);

    #[test]
    fn the_timer_does_not_heed_inputs() {
        let mut pacing = Pacing::timer(1_000, PERIOD);
        assert!(!pacing.heeds_inputs());
        assert_eq!(pacing.begin(950, true), None);
        assert_eq!(pacing.begin(1_010, true), Some(Tick::timer(1_000, 1_010)));
    }

    #[test]
    fn one_input_between_two_due_times_begins_a_cycle_and_the_due_times_stay() {
        let mut pacing = Pacing::both(1_000, PERIOD);
        assert_eq!(pacing.begin(950, true), Some(Tick::event(950)));
        assert!(!pacing.heeds_inputs());
        assert_eq!(pacing.begin(960, true), None, "a flood waits for the timer");
        assert_eq!(pacing.begin(1_001, true), Some(Tick::timer(1_000, 1_001)));
        assert_eq!(pacing.begin(1_050, true), Some(Tick::event(1_050)));
        assert_eq!(pacing.begin(1_350, false), Some(Tick { skipped: 2, ..Tick::timer(1_300, 1_350) }));
    }

    #[test]
    fn with_events_alone_a_period_begins_anew_with_every_cycle() {
        let mut pacing = Pacing::event(1_000, PERIOD);
        assert_eq!(pacing.begin(950, true), Some(Tick::event(950)));
        assert_eq!(pacing.begin(960, true), Some(Tick::event(960)));
        assert_eq!(pacing.begin(1_059, false), None);
        assert_eq!(pacing.begin(1_060, false), Some(Tick::timer(1_060, 1_060)));
        assert_eq!(pacing.next_due_ns(), 1_160);
    }

    #[test]
    fn with_events_alone_lateness_counts_from_the_one_due_time_however_long_it_is() {
        let mut pacing = Pacing::event(1_000, PERIOD);
        assert_eq!(pacing.begin(1_350, false), Some(Tick::timer(1_000, 1_350)));
        pacing.no_later_than(1_360);
        assert_eq!(pacing.begin(1_999, true), Some(Tick::timer(1_360, 1_999)));
        assert_eq!(pacing.next_due_ns(), 2_099);
    }

    #[test]
    fn what_could_not_begin_yet_is_not_late() {
        let mut pacing = Pacing::timer(1_000, PERIOD);
        pacing.no_earlier_than(5_030);
        pacing.no_earlier_than(2_000);
        assert_eq!(pacing.begin(5_031, false), Some(Tick::timer(5_030, 5_031)));
        assert_eq!(pacing.next_due_ns(), 5_130);
    }

    #[test]
    fn work_that_says_when_it_is_due_is_begun_then() {
        let mut pacing = Pacing::event(1_000, PERIOD);
        pacing.no_later_than(1_020);
        assert_eq!(pacing.next_due_ns(), 1_000);
        assert!(pacing.begin(1_000, false).is_some());
        pacing.no_later_than(1_020);
        assert_eq!(pacing.begin(1_010, false), None);
        assert_eq!(pacing.begin(1_030, false), Some(Tick::timer(1_020, 1_030)));
    }
}
