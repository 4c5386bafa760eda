//! What shapes a fit beside the settings a user chooses: which states are drawn, and how errors count.

use crate::error::TrainError;
use serde::{Deserialize, Serialize};

/// The fixed part of a training run. [`Recipe::default`] is the one that made the shipped models; it is written into
/// their metadata.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Recipe {
    /// Samples in the pool, rounded up to whole blocks; one epoch is one pass over it.
    pub pool_samples: usize,
    /// Share of the pool within [`Recipe::near_band_m`] of the zero level, outside the failure set.
    pub share_near: f64,
    /// Share outside the failure set where the residual exceeds 2 cm.
    pub share_active: f64,
    /// Share inside the failure set. What remains is drawn from everywhere outside it.
    pub share_inside: f64,
    /// Half-width of the band about `V = 0` that counts as near, m.
    pub near_band_m: f64,
    /// Share of samples moved off their node, uniformly within its cell. The rest sit on nodes.
    pub jitter_share: f64,
    /// How far states beyond either end of a periodic axis are shown, in its unit: the network is not periodic by
    /// itself.
    pub seam_overlap: f64,
    /// Added to the weight of a sample at `V = 0` where the fit over-estimates `V`; falls off linearly to 0 at
    /// [`Recipe::near_band_m`].
    pub overestimate_weight: f64,
    /// Errors beyond this count linearly instead of quadratically, m.
    pub huber_m: f64,
    /// Scale of the first layer's initial weights, rad per unit of the state.
    pub first_layer_gain: f64,
    /// Share of all steps over which the learning rate rises from 0.
    pub warm_up_share: f64,
}

impl Default for Recipe {
    fn default() -> Self {
        Self {
            pool_samples: 1 << 21,
            share_near: 0.35,
            share_active: 0.25,
            share_inside: 0.05,
            near_band_m: 0.4,
            jitter_share: 0.1,
            seam_overlap: 0.36,
            overestimate_weight: 3.0,
            huber_m: 0.02,
            first_layer_gain: 0.5,
            warm_up_share: 0.01,
        }
    }
}

impl Recipe {
    /// Checks every field once.
    ///
    /// # Errors
    /// [`TrainError::Setting`] names the first field out of range.
    pub fn validate(&self) -> Result<(), TrainError> {
        let share = |setting, value: f64| {
            require((0.0..=1.0).contains(&value), setting, value, "use a share in [0, 1]")
        };
        let positive = |setting, value: f64| {
            require(value.is_finite() && value > 0.0, setting, value, "use a positive number")
        };
        let non_negative =
            |setting, value: f64| require(value.is_finite() && value >= 0.0, setting, value, "use 0 or more");
        require(self.pool_samples > 0, "pool_samples", self.pool_samples as f64, "use at least 1")?;
        share("share_near", self.share_near)?;
        share("share_active", self.share_active)?;
        share("share_inside", self.share_inside)?;
        share(
            "share_near + share_active + share_inside",
            self.share_near + self.share_active + self.share_inside,
        )?;
        positive("near_band_m", self.near_band_m)?;
        share("jitter_share", self.jitter_share)?;
        non_negative("seam_overlap", self.seam_overlap)?;
        non_negative("overestimate_weight", self.overestimate_weight)?;
        positive("huber_m", self.huber_m)?;
        positive("first_layer_gain", self.first_layer_gain)?;
        share("warm_up_share", self.warm_up_share)
    }
}

/// Turns a failed condition into the error that names the setting.
pub(crate) fn require(
    holds: bool,
    setting: &'static str,
    value: f64,
    expected: &'static str,
) -> Result<(), TrainError> {
    if holds { Ok(()) } else { Err(TrainError::Setting { setting, value, expected }) }
}
