//! Process 2: how velocities come from positions.

use serde::{Deserialize, Serialize};

use crate::error::{Checked, non_negative, positive, positive_ms};

/// Where velocities come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EstimatorKind {
    /// The paper's backward difference of positions.
    BackwardDifference,
    /// The velocity that perception measured; differences where a detection carries none.
    Provided,
}

/// Settings of `obstacle_estimator`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EstimatorSettings {
    /// Where velocities come from.
    pub kind: EstimatorKind,
    /// Longest time without detections before the estimator gives a sign of life, ms.
    pub heartbeat_ms: u64,
    /// How long an unseen obstacle is predicted before it is dropped, ms.
    pub coast_ms: u64,
    /// An implied speed above this is a jump, not a motion: the track starts anew, m/s.
    pub teleport_speed_mps: f64,
    /// Two sightings farther apart than this give no velocity, ms.
    pub max_difference_interval_ms: u64,
    /// Below this speed the heading is kept and its rate is zero, m/s.
    pub heading_hold_speed_mps: f64,
    /// Speed rates beyond this are clipped: differences of noisy positions are no accelerations, m/s².
    pub max_speed_rate_mps2: f64,
    /// Turn rates beyond this are clipped, rad/s.
    pub max_heading_rate_radps: f64,
    /// Farthest an anonymous detection may lie from a predicted track to be taken for it, m.
    pub association_gate_m: f64,
}

impl EstimatorSettings {
    pub(crate) fn validate(&self) -> Checked {
        positive_ms("estimator.heartbeat_ms", self.heartbeat_ms)?;
        positive_ms("estimator.coast_ms", self.coast_ms)?;
        positive("estimator.teleport_speed_mps", self.teleport_speed_mps)?;
        positive_ms("estimator.max_difference_interval_ms", self.max_difference_interval_ms)?;
        non_negative("estimator.heading_hold_speed_mps", self.heading_hold_speed_mps)?;
        positive("estimator.max_speed_rate_mps2", self.max_speed_rate_mps2)?;
        positive("estimator.max_heading_rate_radps", self.max_heading_rate_radps)?;
        positive("estimator.association_gate_m", self.association_gate_m)
    }
}
