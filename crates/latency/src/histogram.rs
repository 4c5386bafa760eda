//! One histogram with its raw extremes.

use hdrhistogram::Histogram;
use serde::{Deserialize, Serialize};

use crate::LatencySummary;
use crate::hop::Stretch;

/// Largest value the histogram resolves, one hour in ns. Larger ones count here and stay exact in the maximum.
pub(crate) const LARGEST_NS: u64 = 3_600_000_000_000;

/// Significant decimal digits of a percentile.
pub(crate) const DIGITS: u8 = 3;

/// A point of a percentile curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct QuantilePoint {
    /// Share of values at or below `value_ns`, in (0, 1].
    pub quantile: f64,
    /// Latency, ns.
    pub value_ns: u64,
}

/// A share of the values: which of them a figure tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Statistic {
    /// Median.
    #[serde(rename = "p50")]
    P50,
    /// 90th percentile.
    #[serde(rename = "p90")]
    P90,
    /// 99th percentile.
    #[serde(rename = "p99")]
    P99,
    /// 99.9th percentile.
    #[serde(rename = "p99.9")]
    P99_9,
    /// 99.99th percentile.
    #[serde(rename = "p99.99")]
    P99_99,
    /// Largest value.
    #[serde(rename = "max")]
    Max,
}

impl Statistic {
    /// Every statistic, towards the tail.
    pub const ALL: [Self; 6] = [Self::P50, Self::P90, Self::P99, Self::P99_9, Self::P99_99, Self::Max];

    /// Share of values at or below the figure.
    pub const fn quantile(self) -> f64 {
        match self {
            Self::P50 => 0.5,
            Self::P90 => 0.9,
            Self::P99 => 0.99,
            Self::P99_9 => 0.999,
            Self::P99_99 => 0.9999,
            Self::Max => 1.0,
        }
    }

    /// Name in files, tables and budgets.
    pub const fn label(self) -> &'static str {
        match self {
            Self::P50 => "p50",
            Self::P90 => "p90",
            Self::P99 => "p99",
            Self::P99_9 => "p99.9",
            Self::P99_99 => "p99.99",
            Self::Max => "max",
        }
    }
}

/// Lengths of one kind of stretch: an HdrHistogram to three digits, and the smallest and largest value exactly.
///
/// In JSON: the figures of [`LatencySummary`], and under `histogram` the standard compressed HdrHistogram text.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(try_from = "crate::histogram_text::Text", into = "crate::histogram_text::Text")]
pub struct Latencies {
    pub(crate) values: Histogram<u64>,
    pub(crate) negative: u64,
    pub(crate) min_ns: u64,
    pub(crate) max_ns: u64,
}

impl Default for Latencies {
    fn default() -> Self {
        Self::new()
    }
}

impl Latencies {
    /// None yet. Of fixed size, about 260 kB: nothing that follows allocates.
    #[expect(clippy::missing_panics_doc, reason = "constant bounds cannot be refused")]
    pub fn new() -> Self {
        let values = Histogram::new_with_bounds(1, LARGEST_NS, DIGITS)
            .expect("bounds and digits are constants in range");
        Self { values, negative: 0, min_ns: u64::MAX, max_ns: 0 }
    }

    /// Counts a stretch from `start_ns` to `end_ns`. One that ends before it starts has no length: it is counted apart.
    pub fn record_between(&mut self, start_ns: u64, end_ns: u64) {
        match end_ns.checked_sub(start_ns) {
            Some(length_ns) => {
                self.values.saturating_record(length_ns);
                self.min_ns = self.min_ns.min(length_ns);
                self.max_ns = self.max_ns.max(length_ns);
            }
            None => self.negative += 1,
        }
    }

    pub(crate) fn record(&mut self, stretch: &Stretch) {
        self.record_between(stretch.start_ns, stretch.end_ns);
    }

    /// Adds everything `other` counted.
    #[expect(clippy::missing_panics_doc, reason = "equal bounds cannot be refused")]
    pub fn merge(&mut self, other: &Self) {
        self.values.add(&other.values).expect("all histograms have the same fixed bounds");
        self.negative += other.negative;
        self.min_ns = self.min_ns.min(other.min_ns);
        self.max_ns = self.max_ns.max(other.max_ns);
    }

    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.values.reset();
        (self.negative, self.min_ns, self.max_ns) = (0, u64::MAX, 0);
    }

    /// How many lengths.
    pub fn count(&self) -> u64 {
        self.values.len()
    }

    /// One figure, ns; nothing where nothing was measured. Percentiles to three digits, the maximum exact.
    pub fn statistic_ns(&self, statistic: Statistic) -> Option<u64> {
        match statistic {
            _ if self.values.is_empty() => None,
            Statistic::Max => Some(self.max_ns),
            Statistic::P50 | Statistic::P90 | Statistic::P99 | Statistic::P99_9 | Statistic::P99_99 => {
                // A bucket's upper end may lie beyond what was seen, hence the clamp.
                Some(self.values.value_at_quantile(statistic.quantile()).clamp(self.min_ns, self.max_ns))
            }
        }
    }

    /// All figures.
    pub fn summary(&self) -> LatencySummary {
        let statistic_ns = |statistic| self.statistic_ns(statistic).unwrap_or(0);
        LatencySummary {
            count: self.count(),
            negative: self.negative,
            min_ns: if self.values.is_empty() { 0 } else { self.min_ns },
            p50_ns: statistic_ns(Statistic::P50),
            p90_ns: statistic_ns(Statistic::P90),
            p99_ns: statistic_ns(Statistic::P99),
            p99_9_ns: statistic_ns(Statistic::P99_9),
            p99_99_ns: statistic_ns(Statistic::P99_99),
            max_ns: self.max_ns,
        }
    }

    /// The percentile curve, from the smallest value to the largest, denser towards the tail; empty where nothing was
    /// measured.
    pub fn curve(&self) -> Vec<QuantilePoint> {
        const STEPS_PER_HALVING: u32 = 5;
        if self.values.is_empty() {
            return Vec::new();
        }
        self.values
            .iter_quantiles(STEPS_PER_HALVING)
            .map(|step| QuantilePoint {
                quantile: step.quantile_iterated_to(),
                value_ns: step.value_iterated_to().clamp(self.min_ns, self.max_ns),
            })
            .collect()
    }
}
