//! How sure a table's figures are: intervals of shares and medians, and the paired comparison of two methods.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use statrs::distribution::{Binomial, DiscreteCDF};

/// Quantile of the normal distribution that leaves 2.5 % above it: all intervals are of 95 %.
const Z: f64 = 1.959_963_984_540_054;
/// How often a sample is drawn anew for a bootstrap interval.
const RESAMPLES: usize = 2_000;
/// The same values give the same interval.
const SEED: u64 = 0x636e_6362_6600_0006;

/// Wilson's score interval of a share: `successes` of `trials`, 95 %. `[0, 1]` without trials.
///
/// Of the intervals in closed form the one that keeps its level near 0 and 1 (Wilson 1927).
pub fn wilson(successes: u64, trials: u64) -> [f64; 2] {
    if trials == 0 {
        return [0.0, 1.0];
    }
    let (n, share) = (trials as f64, successes as f64 / trials as f64);
    let scale = 1.0 + Z * Z / n;
    let centre = (share + Z * Z / (2.0 * n)) / scale;
    let half = Z / scale * (share * (1.0 - share) / n + Z * Z / (4.0 * n * n)).sqrt();
    // Exactly none and exactly all reach the end in exact arithmetic.
    let low = if successes == 0 { 0.0 } else { centre - half };
    let high = if successes == trials { 1.0 } else { centre + half };
    [low, high]
}

/// McNemar's exact test: two-sided p of "both methods are equally likely to be the one that succeeds", where in `only_first`
/// scenarios the first succeeded alone and in `only_second` the second. 1 where they never differ.
pub fn mcnemar_exact(only_first: u64, only_second: u64) -> f64 {
    let differing = only_first + only_second;
    // A fair coin is a distribution for every number of throws; without any there is nothing to tell apart.
    Binomial::new(0.5, differing).map_or(1.0, |coin| (2.0 * coin.cdf(only_first.min(only_second))).min(1.0))
}

/// Difference of two shares on the same trials, first minus second, with its 95 % interval: of the trials `both` succeeded,
/// `only_first` or `only_second` did, or `neither`. `[-1, 1]` without trials.
///
/// Newcombe's hybrid score interval for paired data with the continuity-corrected φ (Statistics in Medicine 17 (1998),
/// method 10): Wilson's intervals of both shares, joined under the correlation that the trials show.
pub fn paired_difference(both: u64, only_first: u64, only_second: u64, neither: u64) -> (f64, [f64; 2]) {
    let trials = both + only_first + only_second + neither;
    if trials == 0 {
        return (0.0, [-1.0, 1.0]);
    }
    let n = trials as f64;
    let (first, second) = (both + only_first, both + only_second);
    let difference = (only_first as f64 - only_second as f64) / n;
    let away = |successes: u64| {
        let (share, [low, high]) = (successes as f64 / n, wilson(successes, trials));
        [share - low, high - share]
    };
    let ([first_down, first_up], [second_down, second_up]) = (away(first), away(second));
    let phi = correlation([both, only_first, only_second, neither].map(|count| count as f64));
    // Rounding must not take the root of less than nothing where both move together.
    let joined = |a: f64, b: f64| (a * a - 2.0 * phi * a * b + b * b).max(0.0).sqrt();
    (difference, [difference - joined(first_down, second_up), difference + joined(first_up, second_down)])
}

/// φ of a table of pairs, a positive one corrected for continuity; zero where one share is none or all.
fn correlation([both, only_first, only_second, neither]: [f64; 4]) -> f64 {
    let n = both + only_first + only_second + neither;
    let margins =
        (both + only_first) * (only_second + neither) * (both + only_second) * (only_first + neither);
    if margins == 0.0 {
        return 0.0;
    }
    let product = both * neither - only_first * only_second;
    let corrected = if product > 0.0 { (product - 0.5 * n).max(0.0) } else { product };
    corrected / margins.sqrt()
}

/// Centre and spread of some values.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Spread {
    /// How many.
    pub count: u64,
    /// Arithmetic mean.
    pub mean: f64,
    /// Median.
    pub median: f64,
    /// 95 % interval of the median, by bootstrap (percentiles); the values' range where there are fewer than five.
    pub median_interval: [f64; 2],
}

impl Spread {
    /// Of `values`, all finite; nothing without any.
    pub fn of(values: &[f64]) -> Option<Self> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (first, last) = (*sorted.first()?, *sorted.last()?);
        Some(Self {
            count: sorted.len() as u64,
            mean: sorted.iter().sum::<f64>() / sorted.len() as f64,
            median: median_of_sorted(&sorted),
            median_interval: if sorted.len() < 5 { [first, last] } else { bootstrapped(&sorted) },
        })
    }
}

fn median_of_sorted(sorted: &[f64]) -> f64 {
    let (low, high) = ((sorted.len() - 1) / 2, sorted.len() / 2);
    0.5 * (sorted[low] + sorted[high])
}

fn bootstrapped(sorted: &[f64]) -> [f64; 2] {
    let mut random = Pcg64::seed_from_u64(SEED);
    let mut medians: Vec<f64> = (0..RESAMPLES)
        .map(|_| {
            let mut drawn: Vec<f64> =
                (0..sorted.len()).map(|_| sorted[random.random_range(0..sorted.len())]).collect();
            drawn.sort_by(f64::total_cmp);
            median_of_sorted(&drawn)
        })
        .collect();
    medians.sort_by(f64::total_cmp);
    [0.025, 0.975].map(|share| medians[(share * (RESAMPLES - 1) as f64).round() as usize])
}
