//! The record of a process' own cycles.

use messages::{Cycle, Trigger};

use crate::{Clock, Node, NodeError, Publisher, RealClock, Tick, UsageMeter};

/// Publishes a [`Cycle`] for every cycle of a process, after its work is done. Belongs to the thread that makes it.
#[derive(Debug)]
pub struct CycleMeter {
    publisher: Publisher<Cycle>,
    usage: UsageMeter,
    process: u32,
    sequence: u64,
}

impl CycleMeter {
    /// A meter that counts from now, published on `node`.
    ///
    /// # Errors
    /// [`NodeError`] if the service cannot be opened.
    pub fn new(node: &Node) -> Result<Self, NodeError> {
        Ok(Self {
            publisher: node.publisher()?,
            usage: UsageMeter::new(),
            process: node.process().code(),
            sequence: 0,
        })
    }

    /// Ends the cycle that began with `tick`. False if the record could not be sent.
    #[must_use]
    pub fn end(&mut self, tick: &Tick) -> bool {
        self.sequence += 1;
        let done_ns = RealClock.now_ns();
        let usage = self.usage.since_last();
        let due_ns = match tick.trigger {
            Trigger::Timer => tick.due_ns,
            Trigger::Event => 0,
        };
        let cycle = Cycle {
            sequence: self.sequence,
            due_ns,
            woke_ns: tick.woke_ns,
            done_ns,
            cpu_ns: usage.cpu_ns,
            process: self.process,
            processor: rustix::thread::sched_getcpu() as u32,
            trigger: tick.trigger.code(),
            skipped: tick.skipped.min(u32::MAX.into()) as u32,
            minor_faults: usage.minor_faults,
            major_faults: usage.major_faults,
            voluntary_switches: usage.voluntary_switches,
            involuntary_switches: usage.involuntary_switches,
        };
        self.publisher.send(&cycle).is_ok()
    }
}
