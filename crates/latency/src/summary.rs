//! The figures of a run, for JSON and for the terminal.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::{Hop, Statistic};

/// Figures of many lengths, ns. All zero where `count` is zero.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LatencySummary {
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
    /// 99.99th percentile, ns, to three digits.
    pub p99_99_ns: u64,
    /// Largest value, exact, ns.
    pub max_ns: u64,
}

impl LatencySummary {
    /// One of the figures, ns; nothing where nothing was measured.
    pub const fn statistic_ns(&self, statistic: Statistic) -> Option<u64> {
        if self.count == 0 {
            return None;
        }
        Some(match statistic {
            Statistic::P50 => self.p50_ns,
            Statistic::P90 => self.p90_ns,
            Statistic::P99 => self.p99_ns,
            Statistic::P99_9 => self.p99_9_ns,
            Statistic::P99_99 => self.p99_99_ns,
            Statistic::Max => self.max_ns,
        })
    }
}

/// Figures of one hop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct HopSummary {
    /// Which hop.
    pub hop: Hop,
    /// Its figures.
    #[serde(flatten)]
    pub latency: LatencySummary,
}

/// What a recorder counted besides lengths.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    /// Filter cycles seen, by timer and by event.
    pub cycles: u64,
    /// Those of them that an input began.
    pub event_cycles: u64,
    /// Due times of the timer that passed without a cycle.
    pub skipped: u64,
    /// The skipped ones, and cycles that began later than a whole period after they were due.
    pub deadline_misses: u64,
    /// Commands missing from the sequence.
    pub lost_commands: u64,
    /// How often the sequence began anew.
    pub restarts: u64,
}

impl Counts {
    /// Share of the timer's due times whose cycle began less than one period late, 0 to 1; nothing without due times.
    pub fn deadlines_kept(&self) -> Option<f64> {
        let due = self.cycles.saturating_sub(self.event_cycles) + self.skipped;
        (due > 0).then(|| 1.0 - self.deadline_misses as f64 / due as f64)
    }

    /// Adds another run's counts.
    pub(crate) const fn add(&mut self, other: &Self) {
        self.cycles += other.cycles;
        self.event_cycles += other.event_cycles;
        self.skipped += other.skipped;
        self.deadline_misses += other.deadline_misses;
        self.lost_commands += other.lost_commands;
        self.restarts += other.restarts;
    }
}

/// Figures of one run. `Display` gives the table for the terminal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Summary {
    /// Period the filter was meant to keep, ns.
    pub period_ns: u64,
    /// Cycles, misses, losses.
    #[serde(flatten)]
    pub counts: Counts,
    /// One entry per hop, in the order of [`Hop::ALL`].
    pub hops: Vec<HopSummary>,
}

impl Summary {
    /// The figures of one hop.
    pub fn hop(&self, hop: Hop) -> LatencySummary {
        let found = self.hops.iter().find(|summary| summary.hop == hop);
        found.map_or_else(LatencySummary::default, |summary| summary.latency)
    }
}

/// Writes the heading of a table of latencies.
pub(crate) fn write_heading(f: &mut fmt::Formatter<'_>, first: &str) -> fmt::Result {
    write!(f, "{first:<22}{:>9}", "count")?;
    Statistic::ALL.iter().try_for_each(|statistic| write!(f, "{:>11}", statistic.label()))
}

/// Writes one row of a table of latencies, µs.
pub(crate) fn write_row(f: &mut fmt::Formatter<'_>, name: &str, latency: &LatencySummary) -> fmt::Result {
    write!(f, "{name:<22}{:>9}", latency.count)?;
    for statistic in Statistic::ALL {
        match latency.statistic_ns(statistic) {
            Some(value_ns) => write!(f, "{:>11.1}", value_ns as f64 / 1e3)?,
            None => write!(f, "{:>11}", "-")?,
        }
    }
    if latency.negative > 0 {
        write!(f, "  ({} negative)", latency.negative)?;
    }
    Ok(())
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_heading(f, "latency, µs")?;
        for hop in &self.hops {
            writeln!(f)?;
            write_row(f, hop.hop.label(), &hop.latency)?;
        }
        let counts = &self.counts;
        write!(
            f,
            "\n{} filter cycles of {:.3} ms ({} begun by an input): {} deadline misses, {} commands lost, {} restarts",
            counts.cycles,
            self.period_ns as f64 / 1e6,
            counts.event_cycles,
            counts.deadline_misses,
            counts.lost_commands,
            counts.restarts
        )
    }
}
