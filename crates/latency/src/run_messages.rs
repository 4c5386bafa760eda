//! One run in memory, as far as its timing goes.

use messages::{Cycle, Health, ProcessId, SafeCommand};
use serde::{Deserialize, Serialize};

use crate::process_key;

/// Memory of one process.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Resident {
    /// Which process.
    #[serde(with = "process_key")]
    pub process: ProcessId,
    /// Largest resident memory seen, shared pages included, bytes.
    pub resident_bytes: u64,
    /// Largest proportional share of resident memory, bytes: shared pages are divided among those who share them. Zero
    /// where it could not be read.
    pub proportional_bytes: u64,
    /// Largest locked memory, bytes.
    pub locked_bytes: u64,
}

/// The messages of one run that tell its timing, each kind in the order it was recorded, and what the caller saw besides.
#[derive(Debug, Clone, Default)]
pub struct RunMessages {
    /// Every command of the filter.
    pub safe_commands: Vec<SafeCommand>,
    /// Every cycle of every process.
    pub cycles: Vec<Cycle>,
    /// Every health message.
    pub health: Vec<Health>,
    /// Memory of each process, as sampled from outside while it ran.
    pub resident: Vec<Resident>,
}

impl RunMessages {
    /// When the filter began the first cycle that used detections, stack clock, ns; nothing where none did. Before it the
    /// processes start, connect and touch their memory for the first time.
    pub fn first_use_ns(&self) -> Option<u64> {
        let first = self.safe_commands.iter().find(|command| command.ledger.detections_ingress_ns != 0);
        first.map(|command| command.ledger.filter_woke_ns)
    }

    /// When anything began first and ended last, stack clock, ns; nothing for an empty run.
    pub fn span_ns(&self) -> Option<(u64, u64)> {
        let commands = self.safe_commands.iter().map(|command| &command.ledger);
        let commands = commands.map(|ledger| (ledger.filter_woke_ns, ledger.filter_published_ns));
        let cycles = self.cycles.iter().map(|cycle| (cycle.woke_ns, cycle.done_ns));
        commands.chain(cycles).reduce(|all, one| (all.0.min(one.0), all.1.max(one.1)))
    }
}
