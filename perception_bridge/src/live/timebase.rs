//! Which clock the graph's stamps are of, and what they mean on the stack's: the date's, or that of a simulation (`/clock`).

use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};

use messages::Reason;
use recording::ros2::{Clock, Time};

use super::arrival::{Arrival, Measured};
use crate::plausible::plausible;

const S: u64 = 1_000_000_000;
/// The date runs as evenly as the stack's clock, or is steered by less than this between two messages, ns.
const DATE_JUMP_NS: u64 = 100_000_000;
/// A simulation's clock advances by less than this from one message to the next beyond what passes meanwhile, ns.
const FORWARD_JUMP_NS: u64 = S;
/// Messages of `/clock` that overtook each other differ by less than this, ns.
const DISORDER_NS: u64 = 100_000_000;
/// A simulation's clock that was silent for longer tells no time, ns.
const CLOCK_SILENCE_NS: u64 = S;
/// What is this far off is not late, but of another clock, ns.
const FOREIGN_NS: u64 = 86_400 * S;

/// The agreed clock.
pub(super) struct Timebase {
    /// Present while stamps are of `/clock`.
    simulated: Option<Simulated>,
    /// The date minus the stack's clock when somebody last looked, ns.
    date_ahead_ns: Option<i64>,
}

struct Simulated {
    /// The newest message of `/clock`.
    newest: Option<Shown>,
    /// For those who stamp what leaves.
    time: RosTime,
}

/// What a simulation's clock showed when.
#[derive(Clone, Copy)]
struct Shown {
    sim_ns: u64,
    stack_ns: u64,
}

/// The time that messages of this stack are stamped with: the date, or that of the simulation.
#[derive(Debug, Clone, Default)]
pub(super) struct RosTime {
    /// A simulation's time minus the stack's, ns; the smallest number while it is not known.
    sim_ahead_ns: Option<Arc<AtomicI64>>,
}

impl RosTime {
    /// Now, as [`Self::at`].
    pub(super) fn now(&self) -> Time {
        let now = Arrival::now();
        self.at(now.stack_ns, now)
    }

    /// What it was at `stack_ns`; the zero that means "not stamped" while a simulation's clock was not heard.
    pub(super) fn at(&self, stack_ns: u64, now: Arrival) -> Time {
        match self.sim_ahead_ns.as_ref().map(|ahead| ahead.load(Ordering::Relaxed)) {
            None => Time::from_ns(now.wall_ns.saturating_sub(now.stack_ns.saturating_sub(stack_ns))),
            Some(i64::MIN) => Time::default(),
            Some(ahead_ns) => Time::from_ns(stack_ns.saturating_add_signed(ahead_ns)),
        }
    }
}

impl Timebase {
    /// Stamps are of the date, or of `/clock`.
    pub(super) fn new(use_sim_time: bool) -> Self {
        let simulated = use_sim_time.then(|| {
            let sim_ahead_ns = Some(Arc::new(AtomicI64::new(i64::MIN)));
            Simulated { newest: None, time: RosTime { sim_ahead_ns } }
        });
        Self { simulated, date_ahead_ns: None }
    }

    /// What leaves is stamped with this.
    pub(super) fn ros_time(&self) -> RosTime {
        self.simulated.as_ref().map_or_else(RosTime::default, |simulated| simulated.time.clone())
    }

    /// Looks whether the date has been changed since the last look; that matters only where stamps are of it.
    ///
    /// # Errors
    /// [`Reason::ClockJump`], once per change.
    pub(super) fn watch_date(&mut self, arrival: Arrival) -> Result<(), Reason> {
        let ahead_ns = arrival.wall_ns.cast_signed() - arrival.stack_ns.cast_signed();
        let before_ns = self.date_ahead_ns.replace(ahead_ns).unwrap_or(ahead_ns);
        let has_jumped = ahead_ns.abs_diff(before_ns) > DATE_JUMP_NS;
        if has_jumped && self.simulated.is_none() { Err(Reason::ClockJump) } else { Ok(()) }
    }

    /// Takes in what a simulation's clock shows.
    ///
    /// # Errors
    /// [`Reason::ClockJump`] if it went back or far forwards; the new time holds from then on. [`Reason::BackwardStamp`] for
    /// one that was overtaken, [`Reason::MalformedInput`] for one before zero.
    pub(super) fn take_clock(&mut self, message: &Clock, arrival: Arrival) -> Result<(), Reason> {
        let Some(simulated) = &mut self.simulated else { return Ok(()) };
        let seconds = u64::try_from(message.clock.sec).map_err(|_| Reason::MalformedInput)?;
        let sim_ns = seconds * S + u64::from(message.clock.nanosec);
        let shown = Shown { sim_ns, stack_ns: arrival.stack_ns };
        let verdict = match simulated.newest {
            None => Ok(()),
            Some(before) => before.leads_to(shown),
        };
        if verdict != Err(Reason::BackwardStamp) {
            simulated.newest = Some(shown);
            if let Some(ahead) = &simulated.time.sim_ahead_ns {
                ahead.store(sim_ns.cast_signed() - shown.stack_ns.cast_signed(), Ordering::Relaxed);
            }
        }
        verdict
    }

    /// When a message with this stamp, which arrived now, was measured. One without a stamp holds when it arrives.
    ///
    /// A simulation's seconds count as long as the stack's: one that does not run in real time is not driven well.
    ///
    /// # Errors
    /// [`Reason::ForeignClock`] for a stamp of another clock than the agreed one, or while that one was not heard;
    /// [`Reason::FutureStamp`] and [`Reason::MalformedInput`] for one that is too far off all the same.
    pub(super) fn measured(&self, stamp: &Time, arrival: Arrival) -> Result<Measured, Reason> {
        let now_ns = match &self.simulated {
            None => arrival.wall_ns,
            Some(simulated) => simulated.now_ns(arrival.stack_ns).ok_or(Reason::ForeignClock)?,
        };
        let Some(stamp_ns) = stamp.to_ns() else {
            return Ok(Measured { valid_at_ns: arrival.stack_ns, source_ns: now_ns });
        };
        plausible(now_ns, stamp_ns).map_err(|reason| {
            let others = [arrival.wall_ns, arrival.stack_ns];
            let of_other = others.iter().any(|other_ns| plausible(*other_ns, stamp_ns).is_ok());
            if of_other || stamp_ns.abs_diff(now_ns) > FOREIGN_NS { Reason::ForeignClock } else { reason }
        })?;
        // Both are near the arrival, so their difference fits.
        let ahead_ns = stamp_ns.cast_signed() - now_ns.cast_signed();
        Ok(Measured { valid_at_ns: arrival.stack_ns.saturating_add_signed(ahead_ns), source_ns: stamp_ns })
    }
}

impl Simulated {
    /// What it shows now, ns; `None` if it was not heard lately.
    fn now_ns(&self, stack_ns: u64) -> Option<u64> {
        let since_ns = |shown: Shown| stack_ns.saturating_sub(shown.stack_ns);
        let newest = self.newest.filter(|shown| since_ns(*shown) <= CLOCK_SILENCE_NS)?;
        Some(newest.sim_ns.saturating_add(since_ns(newest)))
    }
}

impl Shown {
    /// Whether a clock that showed this can show `next`.
    fn leads_to(self, next: Self) -> Result<(), Reason> {
        let passed_ns = next.stack_ns.saturating_sub(self.stack_ns);
        if next.sim_ns.saturating_add(DISORDER_NS) < self.sim_ns {
            Err(Reason::ClockJump)
        } else if next.sim_ns < self.sim_ns {
            Err(Reason::BackwardStamp)
        } else if (next.sim_ns - self.sim_ns).saturating_sub(passed_ns) > FORWARD_JUMP_NS {
            Err(Reason::ClockJump)
        } else {
            Ok(())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;
    const DATE_NS: u64 = 1_700_000_000 * S;

    fn at(stack_ns: u64) -> Arrival {
        Arrival { stack_ns, wall_ns: DATE_NS + stack_ns }
    }

    fn clock(sim_ns: u64) -> Clock {
        Clock { clock: Time::from_ns(sim_ns) }
    }

    fn of(timebase: &Timebase, stamp_ns: u64, stack_ns: u64) -> Result<u64, Reason> {
        timebase.measured(&Time::from_ns(stamp_ns), at(stack_ns)).map(|measured| measured.valid_at_ns)
    }

    #[test]
    fn stamps_of_the_date_keep_their_age_and_others_are_refused() {
        let timebase = Timebase::new(false);
        assert_eq!(of(&timebase, DATE_NS + 50 * S - S / 10, 50 * S), Ok(50 * S - S / 10));
        let unstamped = timebase.measured(&Time::default(), at(50 * S));
        assert_eq!(unstamped, Ok(Measured { valid_at_ns: 50 * S, source_ns: DATE_NS + 50 * S }));
        assert_eq!(of(&timebase, DATE_NS + 51 * S, 50 * S), Err(Reason::FutureStamp));
        assert_eq!(of(&timebase, DATE_NS + 39 * S, 50 * S), Err(Reason::MalformedInput));
        assert_eq!(of(&timebase, 1_234 * S, 50 * S), Err(Reason::ForeignClock), "simulated time");
        assert_eq!(
            of(&timebase, 50 * S - MS, 50 * S),
            Err(Reason::ForeignClock),
            "time since the machine began"
        );
    }

    #[test]
    fn simulated_stamps_keep_their_age_and_need_the_clock() {
        let mut timebase = Timebase::new(true);
        let time = timebase.ros_time();
        assert_eq!(of(&timebase, 77 * S, 50 * S), Err(Reason::ForeignClock), "no /clock was heard");
        assert_eq!(time.now(), Time::default());
        assert_eq!(timebase.take_clock(&clock(77 * S), at(50 * S)), Ok(()));
        assert_eq!(of(&timebase, 77 * S - 30 * MS, 50 * S + 10 * MS), Ok(50 * S - 30 * MS));
        assert_eq!(
            of(&timebase, 77 * S + 20 * MS, 50 * S + 10 * MS),
            Ok(50 * S + 20 * MS),
            "before its /clock"
        );
        assert_eq!(of(&timebase, 79 * S, 50 * S), Err(Reason::FutureStamp));
        assert_eq!(of(&timebase, DATE_NS + 50 * S, 50 * S), Err(Reason::ForeignClock), "the date");
        assert_eq!(of(&timebase, 77 * S, 52 * S), Err(Reason::ForeignClock), "/clock fell silent");
        assert_eq!(time.at(50 * S + 20 * MS, at(51 * S)), Time::from_ns(77 * S + 20 * MS));
        let date = Timebase::new(false).ros_time();
        assert_eq!(date.at(50 * S, at(51 * S)), Time::from_ns(DATE_NS + 50 * S));
    }

    #[test]
    fn a_clock_that_jumps_is_noticed_and_its_new_time_holds() {
        let mut timebase = Timebase::new(true);
        assert_eq!(timebase.take_clock(&clock(77 * S), at(50 * S)), Ok(()));
        assert_eq!(
            timebase.take_clock(&clock(77 * S - 10 * MS), at(50 * S + MS)),
            Err(Reason::BackwardStamp)
        );
        assert_eq!(of(&timebase, 77 * S, 50 * S + MS), Ok(50 * S), "one that was overtaken changes nothing");
        assert_eq!(timebase.take_clock(&clock(2 * S), at(50 * S + 10 * MS)), Err(Reason::ClockJump));
        assert_eq!(of(&timebase, 2 * S, 50 * S + 10 * MS), Ok(50 * S + 10 * MS));
        assert_eq!(of(&timebase, 77 * S, 50 * S + 10 * MS), Err(Reason::FutureStamp), "of the old time");
        assert_eq!(timebase.take_clock(&clock(9 * S), at(51 * S)), Err(Reason::ClockJump));
        assert_eq!(timebase.take_clock(&clock(29 * S), at(71 * S)), Ok(()), "it was silent meanwhile");
        let before_zero = Clock { clock: Time { sec: -1, nanosec: 0 } };
        assert_eq!(timebase.take_clock(&before_zero, at(72 * S)), Err(Reason::MalformedInput));
    }

    #[test]
    fn a_change_of_the_date_is_noticed_once() {
        let mut timebase = Timebase::new(false);
        let hour_ns = 3_600 * S;
        let changed = |stack_ns| Arrival { stack_ns, wall_ns: DATE_NS + stack_ns - hour_ns };
        assert_eq!(timebase.watch_date(at(S)), Ok(()));
        assert_eq!(timebase.watch_date(at(900 * S)), Ok(()));
        assert_eq!(timebase.watch_date(changed(901 * S)), Err(Reason::ClockJump));
        assert_eq!(timebase.watch_date(changed(902 * S)), Ok(()));
        let mut simulated = Timebase::new(true);
        assert_eq!(simulated.watch_date(at(S)), Ok(()));
        assert_eq!(simulated.watch_date(changed(2 * S)), Ok(()), "the date means nothing in a simulation");
    }
}
