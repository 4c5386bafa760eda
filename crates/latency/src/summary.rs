//! The figures of a run, for JSON and for the terminal.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::Hop;

/// Figures of one hop, ns. All zero where `count` is zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct HopSummary {
    /// Which hop.
    pub hop: Hop,
    /// How many values.
    pub count: u64,
    /// How many stretches ended before they started, by a clock that jumped or a foreign sender. Not in the figures.
    pub negative: u64,
    /// Smallest value, exact, ns.
    pub min_ns: u64,
    /// Median, ns, to three digits.
    pub p50_ns: u64,
    /// 90th percentile, ns, to three digits.
    pub p90_ns: u64,
    /// 99th percentile, ns, to three digits.
    pub p99_ns: u64,
    /// 99.9th percentile, ns, to three digits.
    pub p99_9_ns: u64,
    /// Largest value, exact, ns.
    pub max_ns: u64,
}

impl HopSummary {
    pub(crate) const fn empty(hop: Hop) -> Self {
        Self {
            hop,
            count: 0,
            negative: 0,
            min_ns: 0,
            p50_ns: 0,
            p90_ns: 0,
            p99_ns: 0,
            p99_9_ns: 0,
            max_ns: 0,
        }
    }
}

/// Figures of one run. `Display` gives the table for the terminal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Summary {
    /// Period the filter was meant to keep, ns.
    pub period_ns: u64,
    /// Filter cycles seen.
    pub cycles: u64,
    /// Due times that passed without a cycle, and cycles that began later than a whole period after they were due.
    pub deadline_misses: u64,
    /// Commands missing from the sequence.
    pub lost_commands: u64,
    /// How often the sequence began anew.
    pub restarts: u64,
    /// One entry per hop, in the order of [`Hop::ALL`].
    pub hops: Vec<HopSummary>,
}

impl Summary {
    /// The figures of one hop.
    pub fn hop(&self, hop: Hop) -> HopSummary {
        self.hops.iter().copied().find(|summary| summary.hop == hop).unwrap_or(HopSummary::empty(hop))
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let header = ["count", "p50", "p90", "p99", "p99.9", "max"];
        write!(f, "{:<22}", "latency, µs")?;
        header.iter().try_for_each(|name| write!(f, "{name:>11}"))?;
        for hop in &self.hops {
            write!(f, "\n{:<22}{:>11}", hop.hop, hop.count)?;
            for value_ns in [hop.p50_ns, hop.p90_ns, hop.p99_ns, hop.p99_9_ns, hop.max_ns] {
                if hop.count == 0 {
                    write!(f, "{:>11}", "-")?;
                } else {
                    write!(f, "{:>11.1}", value_ns as f64 / 1e3)?;
                }
            }
            if hop.negative > 0 {
                write!(f, "  ({} negative)", hop.negative)?;
            }
        }
        write!(
            f,
            "\n{} filter cycles of {:.3} ms: {} deadline misses, {} commands lost, {} restarts",
            self.cycles,
            self.period_ns as f64 / 1e6,
            self.deadline_misses,
            self.lost_commands,
            self.restarts
        )
    }
}
