//! How the residual network is fitted. Which states it is shown stands in `samples`.

use serde::{Deserialize, Serialize};

use crate::error::{Checked, SettingsError, non_negative, positive, require};
use crate::samples::SampleSettings;

/// What the network sees of the relative state.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Encoding {
    /// The state as it is, as in the paper. Not periodic in the heading.
    #[default]
    Raw,
    /// `[z₁, z₂, cos z₃, sin z₃, z₄]`: periodic in the heading, no seam.
    HeadingCosSin,
    /// `[z₁, z₂]`: for an obstacle that does not move.
    Position,
}

/// Where the values to be fitted come from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TargetSource {
    /// The value function solved on the grid.
    #[default]
    Grid,
    /// The exact value of the double-integrator pair; no grid is solved.
    ClosedForm,
}

/// The barrier condition as a part of the loss: `h` is pushed until
/// `max_u min_d ∇h·ζ(z, u, d) + α·h ≥ margin` holds near its zero level under the true input boxes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConditionSettings {
    /// Gain α of the condition, 1/s.
    pub alpha_per_s: f64,
    /// What the condition is asked to exceed zero by, m/s.
    pub margin_mps: f64,
    /// Weight of a squared violation beside a squared error of the value, s².
    pub weight: f64,
    /// Violations beyond this count linearly instead of quadratically, m/s.
    pub knee_mps: f64,
    /// Samples of the condition are states with `band_m[0] < h < band_m[1]` of the current network, m.
    pub band_m: [f64; 2],
    /// Samples of the condition per sample of the value, in [0, 1].
    pub samples_per_value: f64,
    /// Share of the epochs before which the condition does not count; its weight then rises linearly over as many epochs.
    pub start_share: f64,
}

/// Fit of the residual network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingSettings {
    /// Seed of the initial weights and of the shuffling.
    pub seed: u64,
    /// Passes over the samples.
    pub epochs: u64,
    /// Samples per step of Adam, a multiple of 256.
    pub batch_size: usize,
    /// First learning rate of Adam.
    pub learning_rate: f64,
    /// Last learning rate.
    pub final_learning_rate: f64,
    /// Subtracted from V before the fit, m: a margin toward the safe side.
    pub margin_m: f64,
    /// What the network sees of the relative state.
    #[serde(default)]
    pub encoding: Encoding,
    /// Where the values to be fitted come from.
    #[serde(default)]
    pub target: TargetSource,
    /// Errors beyond this count linearly instead of quadratically, m.
    #[serde(default = "huber_m")]
    pub huber_m: f64,
    /// Added to the weight of a sample at `V = 0` where the fit over-estimates `V`; falls off linearly to 0 at
    /// `samples.near_band_m`.
    #[serde(default = "overestimate_weight")]
    pub overestimate_weight: f64,
    /// Weight of a sample at `V ≤ 0` where the fit under-estimates `V`, in [0, 1]; rises linearly to 1 at
    /// `samples.near_band_m`. Below 1 the network may sink under V where the barrier condition asks for it.
    #[serde(default = "one")]
    pub underestimate_weight: f64,
    /// Scale of the first layer's initial weights, rad per unit of the input.
    #[serde(default = "first_layer_gain")]
    pub first_layer_gain: f64,
    /// Share of all steps over which the learning rate rises from 0.
    #[serde(default = "warm_up_share")]
    pub warm_up_share: f64,
    /// Which states are shown.
    #[serde(default)]
    pub samples: SampleSettings,
    /// The barrier condition in the loss; absent means the value alone is fitted, as in the paper.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition: Option<ConditionSettings>,
}

fn huber_m() -> f64 {
    0.02
}

fn overestimate_weight() -> f64 {
    3.0
}

fn one() -> f64 {
    1.0
}

fn first_layer_gain() -> f64 {
    0.5
}

fn warm_up_share() -> f64 {
    0.01
}

impl TrainingSettings {
    /// Checks every field; what [`crate::Settings::parse`] does for a file.
    ///
    /// # Errors
    /// [`SettingsError`] names the first field out of range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        require(self.epochs > 0, "offline.training.epochs", self.epochs, "at least 1")?;
        require(
            self.batch_size > 0 && self.batch_size.is_multiple_of(256),
            "offline.training.batch_size",
            self.batch_size,
            "a positive multiple of 256",
        )?;
        positive("offline.training.learning_rate", self.learning_rate)?;
        positive("offline.training.final_learning_rate", self.final_learning_rate)?;
        non_negative("offline.training.margin_m", self.margin_m)?;
        positive("offline.training.huber_m", self.huber_m)?;
        non_negative("offline.training.overestimate_weight", self.overestimate_weight)?;
        share("offline.training.underestimate_weight", self.underestimate_weight)?;
        positive("offline.training.first_layer_gain", self.first_layer_gain)?;
        share("offline.training.warm_up_share", self.warm_up_share)?;
        self.samples.validate()?;
        self.condition.as_ref().map_or(Ok(()), ConditionSettings::validate)
    }
}

impl ConditionSettings {
    fn validate(&self) -> Checked {
        positive("offline.training.condition.alpha_per_s", self.alpha_per_s)?;
        non_negative("offline.training.condition.margin_mps", self.margin_mps)?;
        positive("offline.training.condition.weight", self.weight)?;
        positive("offline.training.condition.knee_mps", self.knee_mps)?;
        let [low, high] = self.band_m;
        let ordered = low.is_finite() && high.is_finite() && low < high && high > 0.0;
        require(ordered, "offline.training.condition.band_m", self.band_m, "ascending, its end above 0")?;
        share("offline.training.condition.samples_per_value", self.samples_per_value)?;
        positive("offline.training.condition.samples_per_value", self.samples_per_value)?;
        share("offline.training.condition.start_share", self.start_share)
    }
}

/// Refuses anything but a share of a whole.
pub(crate) fn share(key: &'static str, value: f64) -> Checked {
    require((0.0..=1.0).contains(&value), key, value, "in [0, 1]")
}
