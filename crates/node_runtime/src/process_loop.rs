//! The one loop that every process runs.

use std::time::Duration;

use messages::Reason;

use settings::{ProcessRealtime, WaitKind};

use crate::{
    Clock, CycleMeter, HealthReporter, Node, NodeError, Pacer, Pacing, RealClock, Shutdown, Tick, Waiting,
    WakeUp,
    realtime::{Request, enter, is_realtime},
};

/// What a process does in a cycle. Its ports and its pure step live here; time and counting do not.
pub trait Work {
    /// Takes all inputs, steps, hands over all outputs. Allocates nothing, locks nothing, logs nothing.
    fn cycle(&mut self, tick: &Tick, health: &mut HealthReporter);

    /// When the next cycle is due, stack clock, ns, for work that itself says when.
    fn next_due_ns(&self) -> Option<u64> {
        None
    }

    /// Whether the work can never be done again, so that the process had better end and be started anew.
    fn is_over(&self) -> bool {
        false
    }
}

/// Cycles of one process with all that is counted about them. Belongs to the thread that makes it.
#[derive(Debug)]
pub struct ProcessLoop {
    health: HealthReporter,
    meter: CycleMeter,
}

impl ProcessLoop {
    /// Opens the services that tell how the process is doing.
    ///
    /// # Errors
    /// [`NodeError`] if one of them cannot be opened.
    pub fn new(node: &Node) -> Result<Self, NodeError> {
        Ok(Self { health: HealthReporter::new(node)?, meter: CycleMeter::new(node)? })
    }

    /// Runs one cycle that began with `tick`, and counts it.
    pub fn cycle(&mut self, work: &mut impl Work, tick: &Tick) {
        work.cycle(tick, &mut self.health);
        self.health.cycle(tick);
        if !self.meter.end(tick) {
            self.health.error(Reason::PortFailed);
        }
        self.health.report(tick.woke_ns);
    }

    /// Tells how the process is doing before its first cycle: for who waits, and has nothing to open any more once it need not.
    pub fn report(&mut self, now_ns: u64) {
        self.health.report(now_ns);
    }

    /// Asks the kernel for what `realtime` says, then runs cycles as `pacing` and `wake_up` begin them until `shutdown` is
    /// requested or the work is over, with whatever was granted.
    pub fn run(
        &mut self,
        work: &mut impl Work,
        mut pacing: Pacing,
        wake_up: Option<WakeUp>,
        realtime: Option<&ProcessRealtime>,
        shutdown: &Shutdown,
    ) {
        let granted = enter(&realtime.map_or_else(Request::nothing, Request::from));
        let (asked, got) = granted.flags();
        self.health.realtime(asked, got);
        // Locking memory takes a while, in which nothing was due, whatever the work says of that time.
        let begin_ns = RealClock.now_ns();
        pacing.no_earlier_than(begin_ns);
        let period_ns = pacing.period_ns();
        let mut pacer = Pacer::new(pacing, wake_up, waiting(realtime));
        if is_realtime() {
            pacer = pacer.sharing_processor();
        }
        let mut pauses = 0;
        while !shutdown.requested() && !work.is_over() {
            let tick = match work.next_due_ns() {
                Some(due_ns) => pacer.wait_until(due_ns.max(begin_ns)),
                None => pacer.wait(),
            };
            if pacer.pauses() > pauses {
                pauses = pacer.pauses();
                self.health.error(Reason::CapacityExceeded);
            }
            if tick.lateness_ns() >= period_ns {
                self.health.missed_deadline();
            }
            self.cycle(work, &tick);
        }
        self.health.report_now(RealClock.now_ns());
    }
}

/// How a process asks to wait.
fn waiting(realtime: Option<&ProcessRealtime>) -> Waiting {
    match realtime {
        Some(ProcessRealtime { wait: WaitKind::Spin, .. }) => Waiting::Spin,
        Some(realtime) => Waiting::Sleep { spin: Duration::from_micros(realtime.spin_us) },
        None => Waiting::ASLEEP,
    }
}

#[cfg(test)]
mod tests {
    use messages::{ProcessId, RealtimeFlags};
    use settings::SchedulerKind;

    use super::*;
    use crate::ScopedDomain;

    /// Work that is never done: due before the loop, as a source's is that has not been asked yet, and ever after.
    struct Overdue {
        first: Option<Tick>,
        until_ns: u64,
        shutdown: Shutdown,
    }

    impl Work for Overdue {
        fn cycle(&mut self, tick: &Tick, health: &mut HealthReporter) {
            self.first.get_or_insert(*tick);
            if tick.woke_ns >= self.until_ns || health.counters().errors > 0 {
                self.shutdown.request();
            }
        }

        fn next_due_ns(&self) -> Option<u64> {
            Some(0)
        }
    }

    /// Runs overdue work until it is made to pause, or for so long. The first tick, and how the loop did.
    fn run_overdue(longest: Duration, realtime: Option<&ProcessRealtime>) -> (Tick, messages::Health) {
        let domain = ScopedDomain::new();
        let node = Node::open_in(&domain, "overdue", ProcessId::Bridge).unwrap();
        let shutdown = Shutdown::install().unwrap();
        let until_ns = RealClock.now_ns() + crate::clock::nanoseconds(longest);
        let mut work = Overdue { first: None, until_ns, shutdown: shutdown.clone() };
        let mut cycles = ProcessLoop::new(&node).unwrap();
        let pacing = Pacing::event(RealClock.now_ns(), Duration::from_hours(1));
        cycles.run(&mut work, pacing, None, realtime, &shutdown);
        (work.first.unwrap(), *cycles.health.counters())
    }

    #[test]
    fn what_was_due_before_the_loop_began_is_not_late() {
        let begin_ns = RealClock.now_ns();
        let (first, health) = run_overdue(Duration::ZERO, None);
        assert!(first.due_ns >= begin_ns && first.skipped == 0, "{first:?}");
        assert_eq!(health.missed_deadlines, 0);
    }

    #[test]
    fn a_realtime_loop_that_is_never_done_is_made_to_pause_and_says_so() {
        let fifo = ProcessRealtime {
            scheduler: SchedulerKind::Fifo,
            priority: Some(1),
            ..ProcessRealtime::nothing()
        };
        // The class belongs to the thread and ends with it.
        let run = std::thread::spawn(move || run_overdue(Duration::from_secs(5), Some(&fifo)));
        let (_, health) = run.join().unwrap();
        if health.realtime_granted & RealtimeFlags::FIFO == 0 {
            println!("skipped: no right to SCHED_FIFO here");
            return;
        }
        assert_eq!((health.errors, health.last_reason), (1, Reason::CapacityExceeded.code()));
    }
}
