//! One histogram with its raw extremes.

use hdrhistogram::Histogram;
use serde::{Deserialize, Serialize};

use crate::{Hop, HopSummary, hop::Stretch};

/// Largest value the histogram resolves, one hour in ns. Larger ones count here and stay exact in the maximum.
const LARGEST_NS: u64 = 3_600_000_000_000;

/// Significant decimal digits of a percentile.
const DIGITS: u8 = 3;

/// A point of a percentile curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct QuantilePoint {
    /// Share of values at or below `value_ns`, in (0, 1].
    pub quantile: f64,
    /// Latency, ns.
    pub value_ns: u64,
}

/// Latencies of one hop.
#[derive(Debug, Clone)]
pub(crate) struct HopHistogram {
    values: Histogram<u64>,
    negative: u64,
    min_ns: u64,
    max_ns: u64,
}

impl HopHistogram {
    /// An empty histogram of fixed size, which never allocates again.
    pub(crate) fn new() -> Self {
        let values = Histogram::new_with_bounds(1, LARGEST_NS, DIGITS)
            .expect("bounds and digits are constants in range");
        Self { values, negative: 0, min_ns: u64::MAX, max_ns: 0 }
    }

    /// Counts one stretch. One that ends before it starts has no length: it is counted apart.
    pub(crate) fn record(&mut self, stretch: &Stretch) {
        match stretch.end_ns.checked_sub(stretch.start_ns) {
            Some(length_ns) => {
                self.values.saturating_record(length_ns);
                self.min_ns = self.min_ns.min(length_ns);
                self.max_ns = self.max_ns.max(length_ns);
            }
            None => self.negative += 1,
        }
    }

    pub(crate) fn merge(&mut self, other: &Self) {
        self.values.add(&other.values).expect("both histograms have the same fixed bounds");
        self.negative += other.negative;
        self.min_ns = self.min_ns.min(other.min_ns);
        self.max_ns = self.max_ns.max(other.max_ns);
    }

    pub(crate) fn summary(&self, hop: Hop) -> HopSummary {
        let count = self.values.len();
        if count == 0 {
            return HopSummary { hop, negative: self.negative, ..HopSummary::empty(hop) };
        }
        let quantile_ns = |quantile| self.quantile_ns(quantile);
        HopSummary {
            hop,
            count,
            negative: self.negative,
            min_ns: self.min_ns,
            p50_ns: quantile_ns(0.5),
            p90_ns: quantile_ns(0.9),
            p99_ns: quantile_ns(0.99),
            p99_9_ns: quantile_ns(0.999),
            max_ns: self.max_ns,
        }
    }

    /// The percentile curve, from the smallest value to the largest, denser towards the tail.
    pub(crate) fn curve(&self) -> Vec<QuantilePoint> {
        const STEPS_PER_HALVING: u32 = 5;
        self.values
            .iter_quantiles(STEPS_PER_HALVING)
            .map(|step| QuantilePoint {
                quantile: step.quantile_iterated_to(),
                value_ns: step.value_iterated_to().clamp(self.min_ns, self.max_ns),
            })
            .collect()
    }

    /// A bucket's upper end may lie beyond what was seen, hence the clamp.
    fn quantile_ns(&self, quantile: f64) -> u64 {
        self.values.value_at_quantile(quantile).clamp(self.min_ns, self.max_ns)
    }
}
