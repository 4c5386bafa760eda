//! How the simulated crowd is perceived: what a real sensor does worse than a perfect one.

use serde::{Deserialize, Serialize};

use crate::error::{Checked, non_negative, positive, require};

/// Longest time a detection may take, ms.
const LONGEST_LATENCY_MS: u64 = 2_000;

/// Shortcomings of the simulated perception. Each is drawn from the scenario's seed by a stream of its own for each person, so
/// that one more of them leaves the others as they were, whatever the robot does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensingSettings {
    /// People whose centre is farther from the robot's are not seen, m; everybody if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range_m: Option<f64>,
    /// Half the side of the square around the robot, along the axes of `odom`, in which people are seen, m; everywhere if
    /// absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window_m: Option<f64>,
    /// Whole angle around the robot's heading in which people are seen, deg; all around if absent. A robot without heading
    /// keeps the one it starts with.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub field_of_view_deg: Option<f64>,
    /// Whether a person nearer to the robot hides those whose centre lies behind; not if absent.
    #[serde(default)]
    pub occlusion: bool,
    /// Share of the detections that are missing, each on its own, 0 to 1; 0 if absent.
    #[serde(default)]
    pub dropout: f64,
    /// Time from the measurement to its arrival, ms; 0 if absent. Stamps say when it was measured.
    #[serde(default)]
    pub latency_ms: u64,
    /// Error of each position that changes slowly, besides the white `simulation.position_noise_m`; none if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drift: Option<DriftSettings>,
    /// Whether detections come without velocities, as of a sensor that measures positions only; with true ones if absent.
    #[serde(default)]
    pub hide_velocity: bool,
}

/// A first-order Gauss-Markov process on each coordinate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriftSettings {
    /// Its standard deviation, m.
    pub sigma_m: f64,
    /// Its correlation time, s.
    pub tau_s: f64,
}

impl SensingSettings {
    pub(crate) fn validate(&self) -> Checked {
        self.range_m.map_or(Ok(()), |range_m| positive("simulation.sensing.range_m", range_m))?;
        self.window_m.map_or(Ok(()), |window_m| positive("simulation.sensing.window_m", window_m))?;
        if let Some(angle_deg) = self.field_of_view_deg {
            let is_angle = angle_deg > 0.0 && angle_deg <= 360.0;
            require(is_angle, "simulation.sensing.field_of_view_deg", angle_deg, "above 0 and at most 360")?;
        }
        let is_share = (0.0..=1.0).contains(&self.dropout);
        require(is_share, "simulation.sensing.dropout", self.dropout, "0 to 1")?;
        let is_short = self.latency_ms <= LONGEST_LATENCY_MS;
        require(is_short, "simulation.sensing.latency_ms", self.latency_ms, "at most 2000")?;
        self.drift.map_or(Ok(()), |drift| {
            non_negative("simulation.sensing.drift.sigma_m", drift.sigma_m)?;
            positive("simulation.sensing.drift.tau_s", drift.tau_s)
        })
    }
}
