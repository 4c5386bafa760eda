//! From a stream of safe commands to one histogram per hop.

use messages::SafeCommand;

use crate::{Hop, QuantilePoint, Summary, histogram::HopHistogram, hop::Stretch};

/// Why two recorders cannot become one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "filter periods differ ({ours_ns} ns and {theirs_ns} ns): deadline misses do not add up; summarise the runs apart"
)]
pub struct MergeError {
    /// Period of the recorder that was to grow, ns.
    pub ours_ns: u64,
    /// Period of the other one, ns.
    pub theirs_ns: u64,
}

/// Collects the latencies of one filter's commands, in the order they were published.
///
/// Holds about 3 MB; [`Recorder::record`] does not allocate.
#[derive(Debug, Clone)]
pub struct Recorder {
    period_ns: u64,
    hops: Vec<HopHistogram>,
    cycles: u64,
    deadline_misses: u64,
    lost_commands: u64,
    restarts: u64,
    last: Last,
}

/// What tells a first use from a repeated one. Zero where nothing was seen.
#[derive(Debug, Clone, Copy, Default)]
struct Last {
    sequence: u64,
    due_ns: u64,
    woke_ns: u64,
    detections_ingress_ns: u64,
    robot_state_ingress_ns: u64,
    nominal_published_ns: u64,
}

impl Recorder {
    /// An empty recorder for a filter that runs every `period_ns` ns.
    pub fn new(period_ns: u64) -> Self {
        Self {
            period_ns,
            hops: Hop::ALL.iter().map(|_| HopHistogram::new()).collect(),
            cycles: 0,
            deadline_misses: 0,
            lost_commands: 0,
            restarts: 0,
            last: Last::default(),
        }
    }

    /// Takes every command of a finished run.
    pub fn of<'a>(period_ns: u64, commands: impl IntoIterator<Item = &'a SafeCommand>) -> Self {
        let mut recorder = Self::new(period_ns);
        commands.into_iter().for_each(|command| recorder.record(command));
        recorder
    }

    /// Takes one command. The same command given twice in a row counts once.
    pub fn record(&mut self, command: &SafeCommand) {
        if command.sequence == self.last.sequence
            && command.ledger.filter_woke_ns == self.last.woke_ns
            && self.cycles > 0
        {
            return;
        }
        self.follow_sequence(command);
        let due_ns = command.ledger.filter_due_ns;
        let mut command = *command;
        command.ledger.filter_due_ns = self.oldest_due_ns(&command);
        let command = &command;
        let ledger = &command.ledger;
        self.cycles += 1;
        let skipped = (due_ns - ledger.filter_due_ns) / self.period_ns.max(1);
        let late = ledger.filter_woke_ns.saturating_sub(ledger.filter_due_ns) > self.period_ns;
        self.deadline_misses += skipped.max(u64::from(late && due_ns != 0));

        self.record_hops(&Hop::OF_CYCLE, command);
        if ledger.detections_ingress_ns != self.last.detections_ingress_ns {
            self.record_hops(&Hop::OF_DETECTIONS, command);
        }
        if ledger.robot_state_ingress_ns != self.last.robot_state_ingress_ns {
            self.record_hops(&[Hop::RobotStateToFilter], command);
        }
        if ledger.nominal_published_ns != self.last.nominal_published_ns {
            self.record_hops(&Hop::OF_NOMINAL, command);
        }

        self.last = Last {
            sequence: command.sequence,
            due_ns,
            woke_ns: ledger.filter_woke_ns,
            detections_ingress_ns: ledger.detections_ingress_ns,
            robot_state_ingress_ns: ledger.robot_state_ingress_ns,
            nominal_published_ns: ledger.nominal_published_ns,
        };
    }

    /// Adds everything `other` has seen, as if it were a run of its own.
    ///
    /// # Errors
    /// [`MergeError`] if the filter periods differ.
    pub fn merge(&mut self, other: &Self) -> Result<(), MergeError> {
        if self.period_ns != other.period_ns {
            return Err(MergeError { ours_ns: self.period_ns, theirs_ns: other.period_ns });
        }
        self.hops.iter_mut().zip(&other.hops).for_each(|(ours, theirs)| ours.merge(theirs));
        self.cycles += other.cycles;
        self.deadline_misses += other.deadline_misses;
        self.lost_commands += other.lost_commands;
        self.restarts += other.restarts;
        Ok(())
    }

    /// The figures so far.
    pub fn summary(&self) -> Summary {
        Summary {
            period_ns: self.period_ns,
            cycles: self.cycles,
            deadline_misses: self.deadline_misses,
            lost_commands: self.lost_commands,
            restarts: self.restarts,
            hops: Hop::ALL.iter().map(|&hop| self.hops[hop.index()].summary(hop)).collect(),
        }
    }

    /// The percentile curve of one hop, from its smallest value to its largest; empty where nothing was measured.
    pub fn curve(&self, hop: Hop) -> Vec<QuantilePoint> {
        self.hops[hop.index()].curve()
    }

    fn record_hops(&mut self, hops: &[Hop], command: &SafeCommand) {
        for hop in hops {
            if let Some(stretch) = hop.stretch(&command.ledger) {
                self.hops[hop.index()].record(&stretch);
            }
        }
    }

    /// The oldest due time this cycle answers for, ns. A timer that wakes late by whole periods skips to its newest due
    /// time; taking that one would hide exactly the longest delays (coordinated omission).
    fn oldest_due_ns(&self, command: &SafeCommand) -> u64 {
        let due_ns = command.ledger.filter_due_ns;
        match command.sequence.checked_sub(self.last.sequence) {
            Some(steps) if steps > 0 && self.last.due_ns != 0 => {
                due_ns.min(self.last.due_ns.saturating_add(steps.saturating_mul(self.period_ns)))
            }
            Some(_) | None => due_ns,
        }
    }

    /// A gap in the sequence is a loss, a fall is a restarted filter; a period is measured only without either.
    fn follow_sequence(&mut self, command: &SafeCommand) {
        if self.cycles == 0 {
            return;
        }
        match command.sequence.checked_sub(self.last.sequence) {
            None | Some(0) => self.restarts += 1,
            Some(1) => {
                let stretch = Stretch { start_ns: self.last.woke_ns, end_ns: command.ledger.filter_woke_ns };
                self.hops[Hop::FilterPeriod.index()].record(&stretch);
            }
            Some(step) => self.lost_commands += step - 1,
        }
    }
}
