//! The one loop that every process runs.

use std::time::Duration;

use messages::Reason;

use settings::{ProcessRealtime, WaitKind};

use crate::{
    Clock, CycleMeter, HealthReporter, Node, NodeError, Pacer, Pacing, RealClock, Shutdown, Tick, Waiting,
    WakeUp,
    realtime::{Request, enter},
};

/// What a process does in a cycle. Its ports and its pure step live here; time and counting do not.
pub trait Work {
    /// Takes all inputs, steps, hands over all outputs. Allocates nothing, locks nothing, logs nothing.
    fn cycle(&mut self, tick: &Tick, health: &mut HealthReporter);

    /// When the next cycle is due, stack clock, ns, for work that itself says when.
    fn next_due_ns(&self) -> Option<u64> {
        None
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

    /// Asks the kernel for what `realtime` says, then runs cycles as `pacing` and `wake_up` begin them until `shutdown` is
    /// requested, with whatever was granted.
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
        // Locking memory takes a while, in which nothing was due.
        pacing.no_earlier_than(RealClock.now_ns());
        let mut pacer = Pacer::new(pacing, wake_up, waiting(realtime));
        while !shutdown.requested() {
            let tick = match work.next_due_ns() {
                Some(due_ns) => pacer.wait_until(due_ns),
                None => pacer.wait(),
            };
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
        None => Waiting::Sleep { spin: Duration::ZERO },
    }
}
