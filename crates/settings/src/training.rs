//! How the residual network is fitted.

use serde::{Deserialize, Serialize};

use crate::error::{Checked, non_negative, positive, require};

/// Fit of the residual network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingSettings {
    /// Seed of the initial weights and of the shuffling.
    pub seed: u64,
    /// Passes over the samples.
    pub epochs: u64,
    /// Samples per step of Adam.
    pub batch_size: usize,
    /// First learning rate of Adam.
    pub learning_rate: f64,
    /// Last learning rate.
    pub final_learning_rate: f64,
    /// Subtracted from V before the fit, m: a margin toward the safe side.
    pub margin_m: f64,
}

impl TrainingSettings {
    pub(crate) fn validate(&self) -> Checked {
        require(self.epochs > 0, "offline.training.epochs", self.epochs, "at least 1")?;
        require(self.batch_size > 0, "offline.training.batch_size", self.batch_size, "at least 1")?;
        positive("offline.training.learning_rate", self.learning_rate)?;
        positive("offline.training.final_learning_rate", self.final_learning_rate)?;
        non_negative("offline.training.margin_m", self.margin_m)
    }
}
