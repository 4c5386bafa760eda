//! Which states a fit is shown: how many, and from which part of the domain.

use serde::{Deserialize, Serialize};

use crate::error::{Checked, non_negative, positive, require};
use crate::training::share;

/// The pool of samples of a fit. The boundary of the safe set fills a few percent of the domain, so states are drawn by
/// stratum; what the shares leave is drawn from everywhere outside the failure set.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SampleSettings {
    /// Samples in the pool, rounded up to whole blocks; one epoch is one pass over it.
    pub count: usize,
    /// Share within `near_band_m` of the zero level, outside the failure set.
    pub share_near: f64,
    /// Share outside the failure set where the residual `ℓ - V` exceeds 2 cm.
    pub share_active: f64,
    /// Share inside the failure set.
    pub share_inside: f64,
    /// Half-width of the band about `V = 0` that counts as near, m.
    pub near_band_m: f64,
    /// Grid only: share of samples moved off their node, uniformly within its cell. The rest sit on nodes.
    pub jitter_share: f64,
    /// Raw encoding only: how far beyond either end of a periodic axis states are shown, in its unit.
    pub seam_overlap: f64,
}

impl Default for SampleSettings {
    fn default() -> Self {
        Self {
            count: 1 << 21,
            share_near: 0.35,
            share_active: 0.25,
            share_inside: 0.05,
            near_band_m: 0.4,
            jitter_share: 0.1,
            seam_overlap: 0.36,
        }
    }
}

impl SampleSettings {
    pub(crate) fn validate(&self) -> Checked {
        require(self.count > 0, "offline.training.samples.count", self.count, "at least 1")?;
        share("offline.training.samples.share_near", self.share_near)?;
        share("offline.training.samples.share_active", self.share_active)?;
        share("offline.training.samples.share_inside", self.share_inside)?;
        let sum = self.share_near + self.share_active + self.share_inside;
        share("offline.training.samples.share_near + share_active + share_inside", sum)?;
        positive("offline.training.samples.near_band_m", self.near_band_m)?;
        share("offline.training.samples.jitter_share", self.jitter_share)?;
        non_negative("offline.training.samples.seam_overlap", self.seam_overlap)
    }
}
