//! What a run reports: how it went and how well the result fits.

use crate::network::FittedNetwork;
use serde::{Deserialize, Serialize};

/// Weights and what is known about them.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainedNetwork {
    /// The network.
    pub network: FittedNetwork,
    /// How the run went and how well it fits.
    pub report: TrainingReport,
}

/// How a run went and how well its result fits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrainingReport {
    /// Passes over the pool.
    pub epochs: u64,
    /// Samples per pass.
    pub samples_per_epoch: usize,
    /// Mean loss of the value over each epoch, m².
    pub loss_history: Vec<f64>,
    /// Errors of the value.
    pub fit: FitError,
    /// The barrier condition under the true input boxes, at states drawn uniformly from the domain; absent where the run was
    /// given no game.
    pub condition: Option<ConditionReport>,
}

/// Absolute errors `|V_Θ - V|`, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ErrorSummary {
    /// States counted.
    pub states: usize,
    /// Mean of `V_Θ - V`: positive where the fit is too optimistic.
    pub bias_m: f64,
    /// Mean.
    pub mean_m: f64,
    /// 99th percentile.
    pub p99_m: f64,
    /// Largest.
    pub max_m: f64,
}

/// Errors of a fit against known values. "Outside" means outside the failure set (`ℓ > 0`): inside it nothing can be
/// saved, and the filter's answer there does not depend on details.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FitError {
    /// States outside the failure set.
    pub outside: ErrorSummary,
    /// Those of them with `|V| < 0.2` m.
    pub near_zero: ErrorSummary,
    /// Share of the unsafe states outside the failure set (`V < 0 < ℓ`) that the fit calls safe.
    pub false_safe_share: f64,
    /// Lowest value among them, m, ≤ 0.
    pub false_safe_worst_m: f64,
    /// Share of the safe states that the fit calls unsafe.
    pub false_unsafe_share: f64,
    /// Mean jump of the residual between the two ends of a periodic axis, m. The raw input has no period.
    pub seam_mean_m: f64,
    /// Largest such jump, m.
    pub seam_max_m: f64,
}

/// How well a fit meets the barrier condition `max_u min_d ∇h·ζ + α·h ≥ 0` outside the failure set.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ConditionReport {
    /// Gain α, 1/s.
    pub alpha_per_s: f64,
    /// States with `h ≥ 0`.
    pub states: usize,
    /// Share of them that violates the condition.
    pub violated_share: f64,
    /// Share of those with `0 ≤ h < 0.05` m that violates it.
    pub violated_near_zero_share: f64,
    /// Share of those with `|h| < 0.05` m that violates it.
    pub violated_band_share: f64,
    /// Lowest left-hand side where `h ≥ 0`, m/s.
    pub worst_mps: f64,
}
