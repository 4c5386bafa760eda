//! The loop's clockwork: sleeps until a process' next cycle begins.

use std::time::Duration;

use crate::{
    Clock, Pacing, RealClock, Tick, WakeUp, Woken,
    clock::{nanoseconds, sleep_until},
    processor_share::{ProcessorShare, thread_time_ns},
};

/// How the time between two cycles is spent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Waiting {
    /// Asleep until this long before a cycle is due, then reading the clock. Inputs wake it from its sleep.
    Sleep {
        /// Zero sleeps all the time.
        spin: Duration,
    },
    /// Awake all the time, looking for inputs. One processor for this process alone; never with SCHED_FIFO, which the kernel
    /// then suspends for up to 50 ms in every second.
    Spin,
}

impl Waiting {
    /// Asleep all the time.
    pub const ASLEEP: Self = Self::Sleep { spin: Duration::ZERO };
}

/// Begins the cycles of one process on `CLOCK_MONOTONIC`.
#[derive(Debug)]
pub struct Pacer {
    pacing: Pacing,
    wake_up: Option<WakeUp>,
    waiting: Waiting,
    share: Option<ProcessorShare>,
    pauses: u64,
}

impl Pacer {
    /// Begins cycles as `pacing` says; `wake_up` is where inputs announce themselves.
    pub const fn new(pacing: Pacing, wake_up: Option<WakeUp>, waiting: Waiting) -> Self {
        Self { pacing, wake_up, waiting, share: None, pauses: 0 }
    }

    /// Begins a cycle every `period`, the first one period from now, whatever arrives.
    pub fn every(period: Duration, waiting: Waiting) -> Self {
        let first_due_ns = RealClock.now_ns().saturating_add(nanoseconds(period));
        Self::new(Pacing::timer(first_due_ns, period), None, waiting)
    }

    /// Leaves a fifth of the processor to others whatever is due or arrives: for a thread of a real-time class, which the
    /// kernel interrupts for nobody else. A rush of 20 ms is served at once. Belongs to the thread that calls it.
    #[must_use]
    pub fn sharing_processor(self) -> Self {
        Self { share: Some(ProcessorShare::new(RealClock.now_ns(), thread_time_ns())), ..self }
    }

    /// How often the loop paused since it had more to do than its share of the processor allows.
    pub const fn pauses(&self) -> u64 {
        self.pauses
    }

    /// Waits until the next cycle begins. Inputs that were announced before it count as announced: whoever reads all its inputs
    /// after this call misses none. Signals do not cut it short, so let a process that must end have a due time soon.
    pub fn wait(&mut self) -> Tick {
        self.leave_time_to_others();
        let mut announced = false;
        loop {
            let now_ns = RealClock.now_ns();
            if let Some(tick) = self.pacing.begin(now_ns, announced) {
                if let (Some(wake_up), false) = (&self.wake_up, announced) {
                    wake_up.look();
                }
                return tick;
            }
            announced = self.rest(now_ns);
        }
    }

    /// As [`Self::wait`], with the cycle due no later than `due_ns`.
    pub fn wait_until(&mut self, due_ns: u64) -> Tick {
        self.pacing.no_later_than(due_ns);
        self.wait()
    }

    /// Sleeps, whatever is due, if the thread has taken too much of its processor.
    fn leave_time_to_others(&mut self) {
        let Some(share) = &mut self.share else { return };
        let now_ns = RealClock.now_ns();
        let pause_ns = share.pause_ns(now_ns, thread_time_ns());
        if pause_ns > 0 {
            self.pauses += 1;
            sleep_until(now_ns + pause_ns);
        }
    }

    /// Lets some time pass, at most until a cycle is due, and returns whether an input was announced that may begin one.
    fn rest(&self, now_ns: u64) -> bool {
        let spin_ns = match self.waiting {
            Waiting::Sleep { spin } => nanoseconds(spin),
            Waiting::Spin => u64::MAX,
        };
        let sleep_end_ns = self.pacing.next_due_ns().saturating_sub(spin_ns);
        let asleep = now_ns < sleep_end_ns;
        match self.wake_up.as_ref().filter(|_| self.pacing.heeds_inputs()) {
            Some(wake_up) if asleep => return wake_up.wait_until(sleep_end_ns) == Woken::Notified,
            Some(wake_up) if wake_up.look() == Woken::Notified => return true,
            None if asleep => sleep_until(sleep_end_ns),
            Some(_) | None => std::hint::spin_loop(),
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Node, ScopedDomain};
    use messages::{ProcessId, Trigger};

    const PERIOD: Duration = Duration::from_millis(200);

    fn pacer(domain: &ScopedDomain, waiting: Waiting) -> (Pacer, crate::Waker, Node) {
        let node = Node::open_in(domain, "pacer", ProcessId::Filter).unwrap();
        let (waker, wake_up) = (node.waker(ProcessId::Filter).unwrap(), node.wake_up().unwrap());
        let pacing = Pacing::both(RealClock.now_ns() + nanoseconds(PERIOD), PERIOD);
        (Pacer::new(pacing, Some(wake_up), waiting), waker, node)
    }

    #[test]
    fn inputs_begin_cycles_between_due_times_whether_it_sleeps_or_spins() {
        for waiting in [Waiting::ASLEEP, Waiting::Sleep { spin: Duration::from_millis(1) }, Waiting::Spin] {
            let domain = ScopedDomain::new();
            let (mut pacer, waker, _node) = pacer(&domain, waiting);
            let first = pacer.wait();
            assert_eq!(first.trigger, Trigger::Timer);
            waker.wake();
            let second = pacer.wait();
            assert_eq!(second.trigger, Trigger::Event, "{waiting:?}");
            // The second announcement of this period waits for the timer, and is not left over for an empty cycle after it.
            waker.wake();
            let third = pacer.wait();
            assert_eq!(third.trigger, Trigger::Timer, "{waiting:?}");
            assert_eq!((third.due_ns - first.due_ns) % nanoseconds(PERIOD), 0);
            assert_eq!(pacer.wait().trigger, Trigger::Timer, "{waiting:?}");
        }
    }

    #[test]
    fn a_due_time_set_from_outside_is_kept() {
        let pacing = Pacing::event(RealClock.now_ns() + nanoseconds(PERIOD), PERIOD);
        let mut pacer = Pacer::new(pacing, None, Waiting::ASLEEP);
        let due_ns = RealClock.now_ns() + 3_000_000;
        let tick = pacer.wait_until(due_ns);
        assert!(tick.due_ns == due_ns && tick.woke_ns >= due_ns);
    }
    #[test]
    fn what_is_always_due_leaves_time_to_others_where_it_must() {
        let start_ns = RealClock.now_ns();
        let pacing = Pacing::event(start_ns, PERIOD);
        let mut pacer = Pacer::new(pacing, None, Waiting::ASLEEP).sharing_processor();
        let taken_before_ns = thread_time_ns();
        while RealClock.now_ns() < start_ns + 400_000_000 {
            pacer.wait_until(start_ns);
        }
        let (all_ns, taken_ns) = (RealClock.now_ns() - start_ns, thread_time_ns() - taken_before_ns);
        assert!(taken_ns <= all_ns / 100 * 81 + 21_000_000, "{taken_ns} of {all_ns}");
    }

    #[test]
    fn a_spinning_timer_is_never_early() {
        let mut timer =
            Pacer::every(Duration::from_millis(1), Waiting::Sleep { spin: Duration::from_micros(300) });
        for _ in 0..20 {
            let tick = timer.wait();
            assert!(tick.woke_ns >= tick.due_ns);
        }
    }

    #[test]
    fn ticks_and_skips_together_account_for_all_time_that_passed() {
        let period = Duration::from_millis(2);
        let mut timer = Pacer::every(period, Waiting::ASLEEP);
        let start_ns = timer.pacing.next_due_ns();
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
