//! What is to be certified, checked before any work.

use barrier::Model;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::cell::StateBox;
use super::enclosure::BoxCondition;
use super::error::AffineError;

/// Sines are exact to 2⁻⁴⁸ up to here (`elementary::sin_cos`).
const LARGEST_SUM: f64 = 1e9;

/// What to prove, and how hard to try.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AffineSettings {
    /// Box of relative states to certify, inside the trained box.
    pub region: StateBox,
    /// `α` of the condition, 1/s.
    pub alpha_per_s: f64,
    /// `ε` to prove: `C ≥ −ε` wherever `h̄ ≥ 0`, m/s.
    pub epsilon_mps: f64,
    /// Once a counterexample to `ε` is found: how closely the smallest `ε` that does hold is sought, m/s.
    pub gap_mps: f64,
    /// Most boxes to examine, earlier runs of a resumed search included.
    pub boxes: u64,
    /// Boxes between two checkpoints.
    pub checkpoint_boxes: u64,
}

impl AffineSettings {
    /// Returns settings with the customary search parameters: a gap of 0.05 m/s, a checkpoint every five million boxes,
    /// and no limit on boxes (the caller's progress callback ends the search).
    pub fn new(region: StateBox, alpha_per_s: f64, epsilon_mps: f64) -> Self {
        Self { region, alpha_per_s, epsilon_mps, gap_mps: 0.05, boxes: u64::MAX, checkpoint_boxes: 5_000_000 }
    }
}

/// What a checkpoint must agree on with a search that goes on from it. The budget is free.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Identity {
    pub(crate) subject_sha256: String,
    /// Bit patterns, as text would round.
    pub(crate) region: [[u64; 4]; 2],
    pub(crate) alpha_per_s: u64,
    pub(crate) epsilon_mps: u64,
    pub(crate) gap_mps: u64,
}

impl Identity {
    pub(crate) fn new(model: &Model, settings: &AffineSettings) -> Self {
        Self {
            subject_sha256: subject_sha256(model),
            region: [settings.region.min.map(f64::to_bits), settings.region.max.map(f64::to_bits)],
            alpha_per_s: settings.alpha_per_s.to_bits(),
            epsilon_mps: settings.epsilon_mps.to_bits(),
            gap_mps: settings.gap_mps.to_bits(),
        }
    }

    /// Returns in what two differ.
    pub(crate) fn difference(&self, other: &Self) -> Option<&'static str> {
        [
            (self.subject_sha256 != other.subject_sha256, "model"),
            (self.region != other.region, "region"),
            (self.alpha_per_s != other.alpha_per_s, "alpha_per_s"),
            (self.epsilon_mps != other.epsilon_mps, "epsilon_mps"),
            (self.gap_mps != other.gap_mps, "gap_mps"),
        ]
        .into_iter()
        .find_map(|(differs, what)| differs.then_some(what))
    }
}

/// Returns the SHA-256, hexadecimal, of everything the statement depends on: parameters, encoding, pair, true boxes and
/// radius. Unlike the model's own hash it does not change when a certificate is stored in the model.
pub fn subject_sha256(model: &Model) -> String {
    let metadata = model.metadata();
    let mut hasher = Sha256::new();
    for layer in model.weights().layers() {
        for parameter in layer.weight.iter().chain(&layer.bias) {
            hasher.update(parameter.to_le_bytes());
        }
    }
    hasher.update(format!("{} {}", metadata.dynamics, metadata.encoding));
    let (control, disturbance) = (&metadata.control, &metadata.disturbance);
    let ends = control.min.iter().chain(&control.max).chain(&disturbance.min).chain(&disturbance.max);
    for end in ends.chain([&metadata.failure_radius_m]) {
        hasher.update(end.to_le_bytes());
    }
    hasher.finalize().iter().fold(String::new(), |hex, byte| hex + &format!("{byte:02x}"))
}

/// Checks the settings against the model.
pub(crate) fn check(
    model: &Model,
    settings: &AffineSettings,
    condition: &BoxCondition,
) -> Result<(), AffineError> {
    let (region, grid) = (&settings.region, &model.metadata().grid);
    for axis in 0..4 {
        let (min, max) = (region.min[axis], region.max[axis]);
        if !(min.is_finite() && max.is_finite() && min <= max) {
            return Err(AffineError::Region { axis, min, max });
        }
        let (trained_min, trained_max) = (grid.min[axis], grid.max[axis]);
        if min < trained_min || max > trained_max {
            return Err(AffineError::OutsideDomain { axis, min, max, trained_min, trained_max });
        }
    }
    let positive = [
        ("alpha_per_s", settings.alpha_per_s),
        ("epsilon_mps", settings.epsilon_mps),
        ("gap_mps", settings.gap_mps),
    ];
    for (name, value) in positive {
        if !(value > 0.0 && value.is_finite()) {
            return Err(AffineError::NotPositive { name, value });
        }
    }
    let most = core::array::from_fn(|i| region.min[i].abs().max(region.max[i].abs()));
    let sum = condition.network().largest_sum(&most);
    if sum > LARGEST_SUM {
        return Err(AffineError::Weights { sum, limit: LARGEST_SUM });
    }
    Ok(())
}
