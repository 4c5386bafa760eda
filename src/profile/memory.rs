//! Memory of the stack's processes, looked at from outside while they run.

use latency::Resident;
use launcher::Launcher;
use messages::ProcessId;
use node_runtime::{Clock, RealClock};
use procfs::process::Process;

use crate::session::Moment;

/// Between two looks, ns. A look reads counters that the kernel keeps anyway.
const PERIOD_NS: u64 = 1_000_000_000;

/// The processes of a stack.
const PROCESSES: [ProcessId; 5] =
    [ProcessId::Bridge, ProcessId::Estimator, ProcessId::Nominal, ProcessId::Filter, ProcessId::Recorder];

/// Keeps the largest values seen of each process.
#[derive(Debug, Default)]
pub(super) struct MemoryWatch {
    due_ns: u64,
    largest: Vec<Resident>,
}

impl MemoryWatch {
    /// Looks if it is time to.
    ///
    /// The proportional shares are asked for once, at the end: the kernel then walks all pages of a process, which would
    /// disturb a run that is measured.
    pub(super) fn look(&mut self, launcher: &Launcher, moment: Moment) {
        let now_ns = RealClock.now_ns();
        if moment == Moment::Running && now_ns < self.due_ns {
            return;
        }
        self.due_ns = now_ns + PERIOD_NS;
        for process in PROCESSES {
            if let Some(seen) = launcher.pid(process).and_then(|pid| read(process, pid, moment)) {
                self.keep(seen);
            }
        }
    }

    fn keep(&mut self, seen: Resident) {
        match self.largest.iter_mut().find(|known| known.process == seen.process) {
            Some(known) => {
                known.resident_bytes = known.resident_bytes.max(seen.resident_bytes);
                known.proportional_bytes = known.proportional_bytes.max(seen.proportional_bytes);
                known.locked_bytes = known.locked_bytes.max(seen.locked_bytes);
            }
            None => self.largest.push(seen),
        }
    }

    /// What was seen.
    pub(super) fn largest(self) -> Vec<Resident> {
        self.largest
    }
}

/// Nothing for a process that has just ended.
fn read(process: ProcessId, pid: u32, moment: Moment) -> Option<Resident> {
    let proc = Process::new(i32::try_from(pid).ok()?).ok()?;
    let status = proc.status().ok()?;
    let kilobytes = |value: Option<u64>| value.unwrap_or(0) * 1024;
    let proportional_bytes = match moment {
        Moment::Running => 0,
        Moment::Ending => proportional_bytes(&proc).unwrap_or(0),
    };
    Some(Resident {
        process,
        resident_bytes: kilobytes(status.vmrss),
        proportional_bytes,
        locked_bytes: kilobytes(status.vmlck),
    })
}

fn proportional_bytes(process: &Process) -> Option<u64> {
    let rollup = process.smaps_rollup().ok()?;
    rollup.memory_map_rollup.0.first()?.extension.map.get("Pss").copied()
}
