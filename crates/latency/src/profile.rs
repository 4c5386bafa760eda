//! The figures of one profile: several repeats of one run, what they were measured on, and their pooled figures.

use std::io::{Read, Write};

use serde::{Deserialize, Serialize};

use crate::loops::Loops;
use crate::{
    Conditions, Counts, Hop, HopSummary, Latencies, LoopFigures, Recorder, Resident, Rights, RunMessages,
    Summary,
};

/// Name and version of the file format, in its field `format`.
pub const PROFILE_FORMAT: &str = "cncbf-profile/1";

/// The lengths of one hop.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct HopLatencies {
    /// Which hop.
    pub hop: Hop,
    /// Its lengths.
    #[serde(flatten)]
    pub latencies: Latencies,
}

/// What happened before the measured time of a repeat began. Not in its figures, but told beside them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct StartUp {
    /// First filter cycle → beginning of the measured time, ns.
    pub duration_ns: u64,
    /// Filter cycles, misses, losses meanwhile.
    #[serde(flatten)]
    pub counts: Counts,
    /// Largest lateness of the filter's timer, ns.
    pub max_lateness_ns: u64,
    /// Longest computation of the filter, ns.
    pub max_compute_ns: u64,
    /// Page faults of all loops that needed no disk.
    pub minor_faults: u64,
    /// Page faults of all loops that waited for the disk.
    pub major_faults: u64,
}

/// Figures of one repeat.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct RepeatFigures {
    /// When the measured time began, stack clock, ns; zero where everything was measured.
    pub measured_from_ns: u64,
    /// Beginning of the measured time → last command, ns.
    pub duration_ns: u64,
    /// Filter cycles, misses, losses.
    #[serde(flatten)]
    pub counts: Counts,
    /// What came before.
    pub start_up: StartUp,
    /// One entry per hop, in the order of [`Hop::ALL`].
    pub hops: Vec<HopLatencies>,
    /// One entry per process that recorded cycles.
    pub loops: Vec<LoopFigures>,
    /// Memory of each process.
    pub resident: Vec<Resident>,
    /// Real-time rights of each process.
    pub rights: Vec<Rights>,
}

impl RepeatFigures {
    /// Figures of `run`. What began before `measured_from_ns` (stack clock, ns) counts as start-up; zero measures
    /// everything, [`RunMessages::first_use_ns`] measures what follows the first cycle that used detections, itself included.
    pub fn of(filter_period_ns: u64, run: &RunMessages, measured_from_ns: u64) -> Self {
        let mut recorder = Recorder::new(filter_period_ns);
        let mut commands = run.safe_commands.iter().peekable();
        while let Some(command) = commands.next_if(|command| command.ledger.filter_woke_ns < measured_from_ns)
        {
            recorder.record(command);
        }
        let before = recorder.take();
        commands.for_each(|command| recorder.record(command));
        let loops = Loops::of(&run.cycles, measured_from_ns);

        let first_ns = run.safe_commands.first().map_or(0, |command| command.ledger.filter_woke_ns);
        let last_ns = run.safe_commands.last().map_or(0, |command| command.ledger.filter_published_ns);
        Self {
            measured_from_ns,
            duration_ns: last_ns.saturating_sub(measured_from_ns.max(first_ns)),
            counts: recorder.counts(),
            start_up: StartUp {
                duration_ns: measured_from_ns.saturating_sub(first_ns),
                counts: before.counts,
                max_lateness_ns: before.hop(Hop::FilterLateness).max_ns,
                max_compute_ns: before.hop(Hop::FilterCompute).max_ns,
                minor_faults: loops.start_up.iter().map(|figures| figures.minor_faults).sum(),
                major_faults: loops.start_up.iter().map(|figures| figures.major_faults).sum(),
            },
            hops: Hop::ALL
                .iter()
                .map(|&hop| HopLatencies { hop, latencies: recorder.latencies(hop).clone() })
                .collect(),
            loops: loops.measured,
            resident: run.resident.clone(),
            rights: Rights::of(&run.health),
        }
    }

    /// Resident memory of all processes together, bytes: the proportional shares where all are known, the plain sum, which
    /// counts shared pages several times, elsewhere; nothing where none was sampled.
    pub fn resident_bytes(&self) -> Option<u64> {
        let known = self.resident.iter().all(|resident| resident.proportional_bytes > 0);
        let of = |resident: &Resident| {
            if known { resident.proportional_bytes } else { resident.resident_bytes }
        };
        (!self.resident.is_empty()).then(|| self.resident.iter().map(of).sum())
    }
}

/// The figures of all repeats together.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct PooledFigures {
    /// Filter cycles, misses, losses.
    #[serde(flatten)]
    pub counts: Counts,
    /// One entry per hop, in the order of [`Hop::ALL`].
    pub hops: Vec<HopLatencies>,
    /// One entry per process that recorded cycles in any repeat.
    pub loops: Vec<LoopFigures>,
}

impl PooledFigures {
    fn of(repeats: &[RepeatFigures]) -> Self {
        let mut counts = Counts::default();
        let mut hops: Vec<_> =
            Hop::ALL.iter().map(|&hop| HopLatencies { hop, latencies: Latencies::new() }).collect();
        let mut loops: Vec<LoopFigures> = Vec::new();
        for repeat in repeats {
            counts.add(&repeat.counts);
            for theirs in &repeat.hops {
                if let Some(ours) = hops.iter_mut().find(|ours| ours.hop == theirs.hop) {
                    ours.latencies.merge(&theirs.latencies);
                }
            }
            for theirs in &repeat.loops {
                match loops.iter_mut().find(|ours| ours.process == theirs.process) {
                    Some(ours) => ours.merge(theirs),
                    None => loops.push(theirs.clone()),
                }
            }
        }
        loops.sort_by_key(|figures| figures.process);
        Self { counts, hops, loops }
    }
}

/// Why a file is no profile that this version can use.
#[derive(Debug, thiserror::Error)]
pub enum ReadProfileError {
    /// Not a profile at all, cut off, or edited by hand.
    #[error("not a profile ({0}); give the profile.json that `cncbf profile` wrote")]
    NotAProfile(#[from] serde_json::Error),
    /// A profile without any repeat: nothing can be held against it.
    #[error("the profile holds no repeats; measure the baseline anew")]
    NoRepeats,
    /// A profile of another version.
    #[error(
        "the profile is of format {found:?}, this version reads {PROFILE_FORMAT:?}; measure the baseline anew"
    )]
    OtherFormat {
        /// What its field `format` says.
        found: String,
    },
}

/// The figures of one profile. `Display` gives the tables for the terminal.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ProfileFigures {
    /// [`PROFILE_FORMAT`].
    pub format: String,
    /// What it was measured on.
    pub conditions: Conditions,
    /// All repeats together.
    pub pooled: PooledFigures,
    /// Each repeat by itself.
    pub repeats: Vec<RepeatFigures>,
}

impl ProfileFigures {
    /// Puts the repeats of one run together.
    pub fn new(conditions: Conditions, repeats: Vec<RepeatFigures>) -> Self {
        let pooled = PooledFigures::of(&repeats);
        Self { format: PROFILE_FORMAT.to_owned(), conditions, pooled, repeats }
    }

    /// Reads the JSON that [`ProfileFigures::write`] wrote. The pooled figures are reckoned anew from the repeats.
    ///
    /// # Errors
    /// [`ReadProfileError`] if it is something else.
    pub fn read(reader: impl Read) -> Result<Self, ReadProfileError> {
        let value: serde_json::Value = serde_json::from_reader(reader)?;
        match value.get("format").and_then(serde_json::Value::as_str) {
            Some(PROFILE_FORMAT) | None => {}
            Some(found) => return Err(ReadProfileError::OtherFormat { found: found.to_owned() }),
        }
        let figures: Self = serde_json::from_value(value)?;
        if figures.repeats.is_empty() {
            return Err(ReadProfileError::NoRepeats);
        }
        Ok(Self::new(figures.conditions, figures.repeats))
    }

    /// Writes versioned JSON: figures for people and scripts, and every histogram, so that comparisons can be made again.
    ///
    /// # Errors
    /// What the writer fails with.
    pub fn write(&self, writer: impl Write) -> std::io::Result<()> {
        serde_json::to_writer_pretty(writer, self).map_err(std::io::Error::from)
    }

    /// The pooled lengths of one hop.
    pub fn hop(&self, hop: Hop) -> Option<&Latencies> {
        self.pooled.hops.iter().find(|of| of.hop == hop).map(|of| &of.latencies)
    }

    /// The pooled figures in short.
    pub fn summary(&self) -> Summary {
        Summary {
            period_ns: self.conditions.filter_period_ns,
            counts: self.pooled.counts,
            hops: self
                .pooled
                .hops
                .iter()
                .map(|of| HopSummary { hop: of.hop, latency: of.latencies.summary() })
                .collect(),
        }
    }

    /// Resident memory of all processes together in the repeat that needed most, bytes.
    pub fn resident_bytes(&self) -> Option<u64> {
        self.repeats.iter().filter_map(RepeatFigures::resident_bytes).max()
    }
}
