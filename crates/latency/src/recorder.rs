//! From a stream of safe commands to one histogram per hop.

use messages::{Ledger, SafeCommand, Trigger};

use crate::{Counts, Hop, HopSummary, Latencies, QuantilePoint, Summary, hop::Stretch};

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
    hops: Vec<Latencies>,
    counts: Counts,
    last: Option<Last>,
}

/// What tells a first use from a repeated one. Times are zero where nothing was seen.
#[derive(Debug, Clone, Copy)]
struct Last {
    sequence: u64,
    woke_ns: u64,
    /// Beginning of the newest cycle of the timer; nothing where a command since is missing.
    timer_woke_ns: Option<u64>,
    detections_ingress_ns: u64,
    robot_state_ingress_ns: u64,
    nominal_published_ns: u64,
}

impl Recorder {
    /// An empty recorder for a filter that runs every `period_ns` ns.
    pub fn new(period_ns: u64) -> Self {
        let hops = Hop::ALL.iter().map(|_| Latencies::new()).collect();
        Self { period_ns, hops, counts: Counts::default(), last: None }
    }

    /// Takes every command of a finished run.
    pub fn of<'a>(period_ns: u64, commands: impl IntoIterator<Item = &'a SafeCommand>) -> Self {
        let mut recorder = Self::new(period_ns);
        commands.into_iter().for_each(|command| recorder.record(command));
        recorder
    }

    /// Takes one command. The same command given twice in a row counts once.
    pub fn record(&mut self, command: &SafeCommand) {
        let ledger = &command.ledger;
        let last = self.last;
        if last.is_some_and(|last| last.sequence == command.sequence && last.woke_ns == ledger.filter_woke_ns)
        {
            return;
        }
        let unbroken = self.follow_sequence(command.sequence);
        self.counts.cycles += 1;
        let before = last.filter(|_| unbroken).and_then(|last| last.timer_woke_ns);
        let timer_woke_ns = match Trigger::try_from(ledger.filter_trigger) {
            Ok(Trigger::Timer) => {
                self.record_timer(ledger, before);
                Some(ledger.filter_woke_ns)
            }
            Ok(Trigger::Event) => {
                self.counts.event_cycles += 1;
                before
            }
            // A newer filter's trigger: its due time may mean anything.
            Err(_) => before,
        };

        self.record_hops(&Hop::OF_CYCLE, ledger);
        if last.is_none_or(|last| ledger.detections_ingress_ns != last.detections_ingress_ns) {
            self.record_hops(&Hop::OF_DETECTIONS, ledger);
        }
        if last.is_none_or(|last| ledger.robot_state_ingress_ns != last.robot_state_ingress_ns) {
            self.record_hops(&[Hop::RobotStateToFilter], ledger);
        }
        if last.is_none_or(|last| ledger.nominal_published_ns != last.nominal_published_ns) {
            self.record_hops(&Hop::OF_NOMINAL, ledger);
        }

        self.last = Some(Last {
            sequence: command.sequence,
            woke_ns: ledger.filter_woke_ns,
            timer_woke_ns,
            detections_ingress_ns: ledger.detections_ingress_ns,
            robot_state_ingress_ns: ledger.robot_state_ingress_ns,
            nominal_published_ns: ledger.nominal_published_ns,
        });
    }

    /// Gives the figures so far and forgets them, but not what tells a first use from a repeated one: what follows counts
    /// as the rest of the same run.
    pub fn take(&mut self) -> Summary {
        let summary = self.summary();
        self.hops.iter_mut().for_each(Latencies::clear);
        self.counts = Counts::default();
        summary
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
        self.counts.add(&other.counts);
        Ok(())
    }

    /// The figures so far.
    pub fn summary(&self) -> Summary {
        let of = |&hop: &Hop| HopSummary { hop, latency: self.hops[hop.index()].summary() };
        Summary { period_ns: self.period_ns, counts: self.counts, hops: Hop::ALL.iter().map(of).collect() }
    }

    /// Cycles, misses, losses so far.
    pub const fn counts(&self) -> Counts {
        self.counts
    }

    /// The lengths of one hop.
    pub fn latencies(&self, hop: Hop) -> &Latencies {
        &self.hops[hop.index()]
    }

    /// The percentile curve of one hop, from its smallest value to its largest; empty where nothing was measured.
    pub fn curve(&self, hop: Hop) -> Vec<QuantilePoint> {
        self.latencies(hop).curve()
    }

    fn record_hops(&mut self, hops: &[Hop], ledger: &Ledger) {
        for hop in hops {
            if let Some(stretch) = hop.stretch(ledger) {
                self.hops[hop.index()].record(&stretch);
            }
        }
    }

    /// Lateness, misses and period of a cycle that the timer began.
    ///
    /// A timer that wakes late by whole periods skips to its newest due time. Taking that one would hide exactly the
    /// longest delays (coordinated omission), so that lateness counts from the oldest due time not served.
    fn record_timer(&mut self, ledger: &Ledger, before_woke_ns: Option<u64>) {
        let skipped = u64::from(ledger.filter_skipped);
        let start_ns = ledger.filter_due_ns.saturating_sub(skipped.saturating_mul(self.period_ns));
        let end_ns = ledger.filter_woke_ns;
        if ledger.filter_due_ns != 0 {
            self.hops[Hop::FilterLateness.index()].record(&Stretch { start_ns, end_ns });
            let late = end_ns.saturating_sub(start_ns) > self.period_ns;
            self.counts.skipped += skipped;
            self.counts.deadline_misses += skipped.max(u64::from(late));
        }
        if let Some(start_ns) = before_woke_ns {
            self.hops[Hop::FilterPeriod.index()].record(&Stretch { start_ns, end_ns });
        }
    }

    /// A gap in the sequence is a loss, a fall is a restarted filter. Returns whether there was neither.
    const fn follow_sequence(&mut self, sequence: u64) -> bool {
        let Some(last) = self.last else { return false };
        match sequence.checked_sub(last.sequence) {
            Some(1) => return true,
            None | Some(0) => self.counts.restarts += 1,
            Some(step) => self.counts.lost_commands += step - 1,
        }
        false
    }
}
