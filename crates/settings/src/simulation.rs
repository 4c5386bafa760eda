//! The simulated crowd and how it is perceived.

use serde::{Deserialize, Serialize};

use crate::error::{Checked, bounds, non_negative, positive, positive_ms, require};

/// People that walk by the social-force model and ignore the robot, and the robot's task among them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimulationSettings {
    /// Seed of the scenario; the same seed gives the same people on every machine.
    pub seed: u64,
    /// Number of people.
    pub people: usize,
    /// Rectangle people walk in, lower corner `[x, y]` in `odom`, m.
    pub arena_min_m: [f64; 2],
    /// Upper corner, m.
    pub arena_max_m: [f64; 2],
    /// Range of the people's desired speeds, m/s.
    pub desired_speed_mps: [f64; 2],
    /// Radius of a person, m.
    pub person_radius_m: f64,
    /// Robot's start `[x m, y m, heading rad]` in `odom`.
    pub start: [f64; 3],
    /// Robot's goal `[x m, y m, heading rad]` in `odom`.
    pub goal: [f64; 3],
    /// No person starts closer to the robot than this, m.
    pub start_clearance_m: f64,
    /// Largest acceleration of the simulated robot, m/s² (rad/s² for the yaw rate); 0 means it follows at once.
    pub acceleration_limit: f64,
    /// Step of the simulation, ms.
    pub step_ms: u64,
    /// Period of the robot state, ms; a multiple of `step_ms`.
    pub robot_state_period_ms: u64,
    /// Period of the detections, ms; a multiple of `step_ms`.
    pub detections_period_ms: u64,
    /// Standard deviation of the noise on detected positions, m.
    pub position_noise_m: f64,
    /// The run ends unsuccessfully after this, s.
    pub timeout_s: f64,
}

impl SimulationSettings {
    pub(crate) fn validate(&self) -> Checked {
        bounds("simulation.arena_min_m / arena_max_m", &self.arena_min_m, &self.arena_max_m)?;
        let [slowest, fastest] = self.desired_speed_mps;
        non_negative("simulation.desired_speed_mps", slowest)?;
        positive("simulation.desired_speed_mps", fastest)?;
        require(
            slowest <= fastest,
            "simulation.desired_speed_mps",
            self.desired_speed_mps,
            "in ascending order",
        )?;
        positive("simulation.person_radius_m", self.person_radius_m)?;
        bounds("simulation.start", &self.start, &self.start)?;
        bounds("simulation.goal", &self.goal, &self.goal)?;
        non_negative("simulation.start_clearance_m", self.start_clearance_m)?;
        non_negative("simulation.acceleration_limit", self.acceleration_limit)?;
        positive_ms("simulation.step_ms", self.step_ms)?;
        let multiple = |period: u64| period > 0 && period.is_multiple_of(self.step_ms);
        let requirement = "a positive multiple of simulation.step_ms";
        let (state, detections) = (self.robot_state_period_ms, self.detections_period_ms);
        require(multiple(state), "simulation.robot_state_period_ms", state, requirement)?;
        require(multiple(detections), "simulation.detections_period_ms", detections, requirement)?;
        non_negative("simulation.position_noise_m", self.position_noise_m)?;
        positive("simulation.timeout_s", self.timeout_s)
    }
}
