//! What a change or a budget is about.

use core::fmt;

use messages::ProcessId;
use serde::{Deserialize, Serialize};

use crate::process_key;
use crate::{Hop, Latencies, PooledFigures};

/// Something that has a distribution of lengths.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// A hop of the path from sensor to command.
    Hop(Hop),
    /// How late a process' timer begins its cycles.
    LoopLateness(#[serde(with = "process_key")] ProcessId),
    /// How long a process' cycles take.
    LoopDuration(#[serde(with = "process_key")] ProcessId),
}

/// Ends of the keys of loops: `filter_loop_lateness`, `bridge_loop_duration`.
const LATENESS: &str = "_loop_lateness";
const DURATION: &str = "_loop_duration";

impl Quantity {
    /// Every quantity of the four processes, hops first.
    pub fn all() -> impl Iterator<Item = Self> {
        const PROCESSES: [ProcessId; 4] =
            [ProcessId::Bridge, ProcessId::Estimator, ProcessId::Nominal, ProcessId::Filter];
        let loops = PROCESSES.into_iter().flat_map(|id| [Self::LoopLateness(id), Self::LoopDuration(id)]);
        Hop::ALL.into_iter().map(Self::Hop).chain(loops)
    }

    /// The quantity of that key, for example `end_to_end` or `filter_loop_lateness`.
    pub fn of_key(key: &str) -> Option<Self> {
        Self::all().find(|quantity| quantity.to_string() == key)
    }

    /// Its lengths in figures of one repeat or of all.
    pub(crate) fn latencies<'a>(
        self,
        hops: &'a [crate::HopLatencies],
        loops: &'a [crate::LoopFigures],
    ) -> Option<&'a Latencies> {
        let of = |process| loops.iter().find(|figures| figures.process == process);
        match self {
            Self::Hop(hop) => hops.iter().find(|of| of.hop == hop).map(|of| &of.latencies),
            Self::LoopLateness(process) => of(process).map(|figures| &figures.lateness),
            Self::LoopDuration(process) => of(process).map(|figures| &figures.duration),
        }
    }

    /// Its lengths in the figures of all repeats.
    pub fn pooled(self, figures: &PooledFigures) -> Option<&Latencies> {
        self.latencies(&figures.hops, &figures.loops)
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Hop(hop) => f.pad(hop.key()),
            Self::LoopLateness(process) => f.pad(&format!("{process}{LATENESS}")),
            Self::LoopDuration(process) => f.pad(&format!("{process}{DURATION}")),
        }
    }
}
