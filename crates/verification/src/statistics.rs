//! Shares with their uncertainty, errors in summary, the binomial bound. Not here: what is counted.

use serde::{Deserialize, Serialize};
use statrs::function::beta::inv_beta_reg;

/// A share counted on independent samples, with its 95 % Wilson score interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Share {
    /// Samples that have the property.
    pub count: u64,
    /// Samples looked at.
    pub of: u64,
    /// `count / of`; zero where nothing was looked at.
    pub share: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval; one where nothing was looked at.
    pub high: f64,
}

/// Two-sided 95 % quantile of the normal distribution.
const Z_95: f64 = 1.959_963_984_540_054;

impl Share {
    /// Returns `count` out of `of` with its interval.
    ///
    /// Source: Wilson 1927; unlike `p ± z √(p(1−p)/n)` it holds for rare properties too.
    pub fn new(count: usize, of: usize) -> Self {
        let (count_u64, of_u64) = (count as u64, of as u64);
        if of == 0 {
            return Self { count: count_u64, of: of_u64, share: 0.0, low: 0.0, high: 1.0 };
        }
        let (n, p) = (of as f64, count as f64 / of as f64);
        let z2 = Z_95 * Z_95;
        let centre = p + z2 / (2.0 * n);
        let half = Z_95 * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
        let scale = 1.0 + z2 / n;
        let low = if count == 0 { 0.0 } else { ((centre - half) / scale).max(0.0) };
        let high = if count == of { 1.0 } else { ((centre + half) / scale).min(1.0) };
        Self { count: count_u64, of: of_u64, share: p, low, high }
    }
}

/// Errors `h − V` in summary; positive over-states safety.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ErrorSummary {
    /// States compared.
    pub states: u64,
    /// Mean error, m.
    pub bias_m: f64,
    /// Mean absolute error, m.
    pub mean_m: f64,
    /// 99th percentile of the absolute error, m.
    pub p99_m: f64,
    /// Largest absolute error, m.
    pub max_m: f64,
    /// Largest error on the unsafe side, `max (h − V)`, m.
    pub over_statement_max_m: f64,
}

impl ErrorSummary {
    /// Summarises errors, m; all zero for none.
    pub fn of(errors: &[f64]) -> Self {
        let n = errors.len().max(1) as f64;
        let mut sizes: Vec<f64> = errors.iter().map(|error| error.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        Self {
            states: errors.len() as u64,
            bias_m: errors.iter().sum::<f64>() / n,
            mean_m: sizes.iter().sum::<f64>() / n,
            p99_m: quantile(&sizes, 0.99),
            max_m: quantile(&sizes, 1.0),
            over_statement_max_m: errors.iter().copied().fold(0.0, f64::max),
        }
    }
}

/// The entry of `sorted` below which a share `q` lies; zero for none.
pub(crate) fn quantile(sorted: &[f64], q: f64) -> f64 {
    let last = sorted.len().saturating_sub(1) as f64;
    sorted.get((last * q).floor() as usize).copied().unwrap_or(0.0)
}

/// Returns the smallest ε with `Σ_{i ≤ k} C(N, i) εⁱ (1 − ε)^(N − i) ≤ β`: with confidence `1 − β`, the probability that failed
/// `k` times in `N` independent trials is at most ε.
///
/// That is the upper Clopper–Pearson end, the `1 − β` quantile of Beta(k + 1, N − k), rounded up in its ninth digit because the
/// quantile is found to about 1e-11. Source: the scenario certificate of Lin and Bansal, 2023. One for `k ≥ N`.
pub fn failure_bound(failures: u64, trials: u64, beta: f64) -> f64 {
    if failures >= trials {
        return 1.0;
    }
    let quantile = inv_beta_reg((failures + 1) as f64, (trials - failures) as f64, 1.0 - beta);
    (quantile * (1.0 + 1e-9)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_is_wilsons() {
        // Computed by hand from Wilson's formula with z = 1.959964.
        let share = Share::new(10, 100);
        assert!(
            (share.low - 0.055_229_137).abs() < 1e-8 && (share.high - 0.174_365_663).abs() < 1e-8,
            "{share:?}"
        );
        let none = Share::new(0, 1000);
        assert_eq!((none.share, none.low), (0.0, 0.0));
        assert!((none.high - 3.826_758e-3).abs() < 1e-8, "{none:?}");
        assert_eq!(Share::new(7, 7).high, 1.0);
        assert_eq!((Share::new(0, 0).low, Share::new(0, 0).high), (0.0, 1.0));
    }

    #[test]
    fn without_failures_the_bound_is_the_closed_form() {
        for (trials, beta) in [(688, 1e-3), (13_809, 1e-6), (138_149, 1e-6)] {
            let exact = -(f64::ln(beta) / trials as f64).exp_m1();
            let bound = failure_bound(0, trials, beta);
            assert!(bound >= exact && bound < exact * (1.0 + 1e-8), "{trials}: {bound:e} {exact:e}");
        }
        assert!(failure_bound(0, 138_149, 1e-6) <= 1e-4 && failure_bound(0, 138_148, 1e-6) > 1e-4);
    }

    #[test]
    fn with_failures_the_bound_is_scipys() {
        // scipy.stats.beta.isf(1e-6, k + 1, N - k), scipy 1.17.1, N = 138149.
        let known = [
            (1, 1.207_932_974_053e-4),
            (10, 2.491_863_180_320e-4),
            (1000, 8.382_158_121_145e-3),
            (60_000, 4.406_633_753_465e-1),
        ];
        for (failures, expected) in known {
            let bound = failure_bound(failures, 138_149, 1e-6);
            assert!((bound / expected - 1.0).abs() < 3e-9, "{failures}: {bound:e}");
        }
        assert_eq!(failure_bound(5, 5, 1e-6), 1.0);
    }

    #[test]
    fn the_summary_keeps_signs_apart() {
        let summary = ErrorSummary::of(&[0.1, -0.3, 0.0, 0.0]);
        assert!((summary.bias_m + 0.05).abs() < 1e-15 && (summary.mean_m - 0.1).abs() < 1e-15);
        assert_eq!((summary.max_m, summary.over_statement_max_m, summary.states), (0.3, 0.1, 4));
        assert_eq!(ErrorSummary::of(&[]).max_m, 0.0);
    }
}
