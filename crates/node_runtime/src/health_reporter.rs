//! How a process is doing, counted and published a few times a second.

use messages::{Health, ProcessId, Reason};

use crate::{Node, NodeError, Publisher, Tick};

/// Shortest time between two reports, ns.
const REPORT_PERIOD_NS: u64 = 200_000_000;

/// Counts what a process does and publishes the counters at most five times a second.
#[derive(Debug)]
pub struct HealthReporter {
    publisher: Publisher<Health>,
    counters: Health,
}

impl HealthReporter {
    /// Counters at zero, published on `node`.
    ///
    /// # Errors
    /// [`NodeError`] if the service cannot be opened.
    pub fn new(node: &Node) -> Result<Self, NodeError> {
        Ok(Self { publisher: node.publisher()?, counters: zeroed(node.process()) })
    }

    /// Counts a cycle, and the due times it skipped as missed deadlines. One that an input began cannot be late.
    pub fn cycle(&mut self, tick: &Tick) {
        self.counters.cycles += 1;
        self.counters.missed_deadlines += tick.skipped;
        self.counters.max_lateness_ns = self.counters.max_lateness_ns.max(tick.lateness_ns());
    }

    /// Counts a cycle that began later than a whole period though it skipped no due time.
    pub fn missed_deadline(&mut self) {
        self.counters.missed_deadlines += 1;
    }

    /// Counts inputs that were used.
    pub fn accepted(&mut self, count: u64) {
        self.counters.accepted_inputs += count;
    }

    /// Counts one input that was refused, and why.
    pub fn refused(&mut self, reason: Reason) {
        self.counters.refused_inputs += 1;
        self.counters.last_reason = reason.code();
    }

    /// Counts something else that went wrong.
    pub fn error(&mut self, reason: Reason) {
        self.counters.errors = self.counters.errors.saturating_add(1);
        self.counters.last_reason = reason.code();
    }

    /// Notes what the process asked the kernel for and what it got, as [`messages::RealtimeFlags`] bits.
    pub fn realtime(&mut self, asked: u32, granted: u32) {
        (self.counters.realtime_asked, self.counters.realtime_granted) = (asked, granted);
    }

    /// Publishes the counters if the last report is long enough ago. `now_ns` is the stack clock's time.
    pub fn report(&mut self, now_ns: u64) {
        if self.counters.published_ns == 0
            || now_ns.saturating_sub(self.counters.published_ns) >= REPORT_PERIOD_NS
        {
            self.report_now(now_ns);
        }
    }

    /// Publishes the counters, for example before the process ends.
    pub fn report_now(&mut self, now_ns: u64) {
        self.counters.published_ns = now_ns;
        if self.publisher.send(&self.counters).is_err() {
            self.error(Reason::PortFailed);
        }
    }

    /// The counters so far.
    pub const fn counters(&self) -> &Health {
        &self.counters
    }
}

/// Counters of a process that has done nothing yet.
fn zeroed(process: ProcessId) -> Health {
    Health {
        published_ns: 0,
        cycles: 0,
        missed_deadlines: 0,
        max_lateness_ns: 0,
        accepted_inputs: 0,
        refused_inputs: 0,
        process: process.code(),
        pid: std::process::id(),
        last_reason: Reason::None.code(),
        errors: 0,
        realtime_asked: 0,
        realtime_granted: 0,
    }
}
