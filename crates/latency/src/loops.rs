//! What each process' loop did, from its cycle records.

use messages::{Cycle, ProcessId, Trigger};
use serde::{Deserialize, Serialize};

use crate::Latencies;
use crate::process_key;

/// Figures of one process' loop.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct LoopFigures {
    /// Which process.
    #[serde(with = "process_key")]
    pub process: ProcessId,
    /// Cycles on record.
    pub cycles: u64,
    /// Those of them that an input began.
    pub event_cycles: u64,
    /// Due times of the timer that passed without a cycle.
    pub skipped: u64,
    /// Cycles missing from the record, by gaps in their sequence.
    pub lost_records: u64,
    /// How often the sequence began anew.
    pub restarts: u64,
    /// Oldest due time not served → cycle began; cycles of the timer only.
    pub lateness: Latencies,
    /// Cycle began → outputs handed over.
    pub duration: Latencies,
    /// Processor time of the thread, ns.
    pub cpu_ns: u64,
    /// Page faults that needed no disk.
    pub minor_faults: u64,
    /// Page faults that waited for the disk.
    pub major_faults: u64,
    /// How often the thread gave up its processor; one per cycle is the sleep before it.
    pub voluntary_switches: u64,
    /// How often the thread was pushed off its processor.
    pub involuntary_switches: u64,
}

impl LoopFigures {
    /// None yet.
    pub(crate) fn new(process: ProcessId) -> Self {
        Self {
            process,
            cycles: 0,
            event_cycles: 0,
            skipped: 0,
            lost_records: 0,
            restarts: 0,
            lateness: Latencies::new(),
            duration: Latencies::new(),
            cpu_ns: 0,
            minor_faults: 0,
            major_faults: 0,
            voluntary_switches: 0,
            involuntary_switches: 0,
        }
    }

    /// Processor time of one cycle on average, ns; zero without cycles.
    pub fn cpu_per_cycle_ns(&self) -> f64 {
        self.cpu_ns as f64 / self.cycles.max(1) as f64
    }

    /// Adds another run's figures of the same process.
    pub(crate) fn merge(&mut self, other: &Self) {
        self.cycles += other.cycles;
        self.event_cycles += other.event_cycles;
        self.skipped += other.skipped;
        self.lost_records += other.lost_records;
        self.restarts += other.restarts;
        self.lateness.merge(&other.lateness);
        self.duration.merge(&other.duration);
        self.cpu_ns += other.cpu_ns;
        self.minor_faults += other.minor_faults;
        self.major_faults += other.major_faults;
        self.voluntary_switches += other.voluntary_switches;
        self.involuntary_switches += other.involuntary_switches;
    }

    fn count(&mut self, cycle: &Cycle, lateness: Option<(u64, u64)>) {
        self.cycles += 1;
        match Trigger::try_from(cycle.trigger) {
            Ok(Trigger::Timer) => self.skipped += u64::from(cycle.skipped),
            Ok(Trigger::Event) => self.event_cycles += 1,
            Err(_) => {}
        }
        if let Some((due_ns, woke_ns)) = lateness {
            self.lateness.record_between(due_ns, woke_ns);
        }
        self.duration.record_between(cycle.woke_ns, cycle.done_ns);
    }

    /// Counts what the kernel did for `cycle`'s thread since the cycle before.
    fn count_usage(&mut self, cycle: &Cycle) {
        self.cpu_ns += cycle.cpu_ns;
        self.minor_faults += u64::from(cycle.minor_faults);
        self.major_faults += u64::from(cycle.major_faults);
        self.voluntary_switches += u64::from(cycle.voluntary_switches);
        self.involuntary_switches += u64::from(cycle.involuntary_switches);
    }
}

/// Follows one process' records in the order of their sequence.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct LoopFollower {
    last_sequence: Option<u64>,
    last_due_ns: Option<u64>,
    period_ns: u64,
}

impl LoopFollower {
    /// The oldest due time not served and the beginning of `cycle`, ns; nothing for a cycle without due time. Records may
    /// be given once only.
    ///
    /// A record does not tell its timer's period. Two due times in a row do, with the number of skipped ones between them;
    /// until then a cycle that skipped counts from its own due time.
    pub(crate) fn lateness_ns(&mut self, cycle: &Cycle) -> Option<(u64, u64)> {
        if Trigger::try_from(cycle.trigger) != Ok(Trigger::Timer) || cycle.due_ns == 0 {
            return None;
        }
        let skipped = u64::from(cycle.skipped);
        if let Some(step_ns) = self.last_due_ns.and_then(|last_ns| cycle.due_ns.checked_sub(last_ns)) {
            self.period_ns = step_ns / (skipped + 1);
        }
        self.last_due_ns = Some(cycle.due_ns);
        Some((cycle.due_ns.saturating_sub(skipped.saturating_mul(self.period_ns)), cycle.woke_ns))
    }

    /// How many records are missing before `cycle`, and whether its process began anew.
    pub(crate) fn follow(&mut self, cycle: &Cycle) -> (u64, bool) {
        let found = match self.last_sequence.map(|last| cycle.sequence.checked_sub(last)) {
            // What came before the record began is no loss of it.
            None => (0, false),
            Some(None | Some(0)) => (0, true),
            Some(Some(step)) => (step - 1, false),
        };
        if found != (0, false) {
            self.last_due_ns = None;
        }
        self.last_sequence = Some(cycle.sequence);
        found
    }
}

/// The loops of one run.
pub(crate) struct Loops {
    /// Figures of cycles that began at or after the measured time began, one entry per process that appeared.
    pub(crate) measured: Vec<LoopFigures>,
    /// Figures of those before.
    pub(crate) start_up: Vec<LoopFigures>,
}

impl Loops {
    /// Reads the cycle records of all processes, in any order between processes.
    ///
    /// What is lost counts where the gap ends. Records are put into the order of their beginning first: messages of one
    /// process keep their order through a recorder, but a restarted process counts from 1 again.
    pub(crate) fn of(cycles: &[Cycle], measured_from_ns: u64) -> Self {
        let mut loops = Self { measured: Vec::new(), start_up: Vec::new() };
        for &process in ProcessId::ALL {
            let mut own: Vec<&Cycle> =
                cycles.iter().filter(|cycle| cycle.process == process.code()).collect();
            if own.is_empty() {
                continue;
            }
            own.sort_by_key(|cycle| cycle.woke_ns);
            own.dedup_by_key(|cycle| (cycle.sequence, cycle.woke_ns));
            let mut follower = LoopFollower::default();
            let (mut measured, mut start_up) = (LoopFigures::new(process), LoopFigures::new(process));
            for cycle in own {
                let (lost, restarted) = follower.follow(cycle);
                let lateness = follower.lateness_ns(cycle);
                let figures = if cycle.woke_ns < measured_from_ns { &mut start_up } else { &mut measured };
                figures.lost_records += lost;
                figures.restarts += u64::from(restarted);
                figures.count(cycle, lateness);
                // No cycle came before a process' first one: what the kernel did since is its start-up, even where the
                // other processes were measured by then.
                let begins = measured_from_ns > 0 && cycle.sequence == 1 && !restarted;
                if begins { &mut start_up } else { figures }.count_usage(cycle);
            }
            loops.measured.push(measured);
            loops.start_up.push(start_up);
        }
        loops
    }
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    fn cycle(sequence: u64, woke_ns: u64, minor_faults: u32) -> Cycle {
        Cycle {
            process: ProcessId::Nominal.code(),
            sequence,
            woke_ns,
            done_ns: woke_ns + 10,
            minor_faults,
            ..Cycle::zeroed()
        }
    }

    #[test]
    fn a_process_that_starts_late_brings_its_start_up_not_into_the_figures() {
        let cycles = [cycle(1, 2_000, 2_500), cycle(2, 3_000, 1), cycle(1, 4_000, 700)];
        let Loops { measured, start_up } = Loops::of(&cycles, 1_000);
        assert_eq!((measured[0].cycles, start_up[0].cycles), (3, 0), "every cycle is measured");
        assert_eq!(start_up[0].minor_faults, 2_500);
        assert_eq!(measured[0].minor_faults, 701, "a restart meanwhile is no start-up");
        assert_eq!(
            Loops::of(&cycles, 0).measured[0].minor_faults,
            3_201,
            "everything, where all is measured"
        );
    }
}
