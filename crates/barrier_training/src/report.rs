//! What a training run hands back.

use serde::{Deserialize, Serialize};

/// Weights and what is known of them.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainedModel {
    /// Flat parameters, layout of [`crate::network`].
    pub parameters: Vec<f32>,
    /// How the fit went.
    pub report: TrainingReport,
}

/// How the fit went.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrainingReport {
    /// Passes over the samples.
    pub epochs: u64,
    /// Samples of one pass.
    pub samples_per_epoch: usize,
    /// Mean loss of each epoch, m². Taken while the weights moved.
    pub loss_history: Vec<f64>,
    /// Errors of the final weights.
    pub fit: FitError,
}

/// Errors `V_Θ - V` of a fit at the nodes of its grid, m. Positive means over-estimated safety.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FitError {
    /// All nodes outside the failure set.
    pub outside: ErrorSummary,
    /// Nodes outside the failure set with `|V| < 0.2 m`.
    pub near_zero: ErrorSummary,
    /// Share of the nodes with `V < 0 < ℓ` that the fit calls safe.
    pub false_safe_share: f64,
    /// Lowest `V` among them, m; 0 if there is none.
    pub false_safe_worst_m: f64,
    /// Share of the nodes with `V ≥ 0` that the fit calls unsafe.
    pub false_unsafe_share: f64,
    /// Jump of the fit across the ends of a periodic axis, outside the failure set: mean, m.
    pub seam_mean_m: f64,
    /// The same, largest, m.
    pub seam_max_m: f64,
}

/// Summary of one set of errors, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ErrorSummary {
    /// Number of nodes.
    pub nodes: usize,
    /// Mean of the signed error.
    pub bias_m: f64,
    /// Mean of the absolute error.
    pub mean_m: f64,
    /// 99th percentile of the absolute error.
    pub p99_m: f64,
    /// Largest absolute error.
    pub max_m: f64,
}

/// How well a fit meets the condition of a control barrier function, at the nodes of its grid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ConditionReport {
    /// Class-K gain α, 1/s.
    pub alpha_per_s: f64,
    /// Nodes with `V_Θ ≥ 0`.
    pub nodes: usize,
    /// Share of them with `max_u min_d ∇V_Θ·ż + α V_Θ < 0`.
    pub violated_share: f64,
    /// The same where `V_Θ < 0.05 m`.
    pub violated_near_zero_share: f64,
    /// Lowest value of that expression, m/s.
    pub worst_mps: f64,
}
