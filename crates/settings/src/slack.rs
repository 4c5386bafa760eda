//! A stricter game to train on: a weaker robot against a stronger obstacle than the filter will assume.
//!
//! The exact value function satisfies the condition of a control barrier function with equality on its boundary, so any
//! unbiased fit of it violates the condition on about half of the boundary. The value of a stricter game leaves room.

use serde::{Deserialize, Serialize};

use crate::Settings;
use crate::error::{Checked, require};

/// By how much the solved game is stricter than the true one. Both scales default to 1, the true game.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SlackSettings {
    /// The robot's control box is shrunk about its centre by this factor, in (0, 1].
    #[serde(default = "one")]
    pub control_scale: f64,
    /// The obstacle's disturbance box is widened about its centre by this factor, at least 1.
    #[serde(default = "one")]
    pub disturbance_scale: f64,
}

fn one() -> f64 {
    1.0
}

/// The inputs for which the value function is solved, in the units of [`Settings::robot`] and [`Settings::obstacle`].
#[derive(Debug, Clone, PartialEq)]
pub struct TrainingGame {
    /// Smallest control of the robot.
    pub control_min: [f64; 2],
    /// Largest control of the robot.
    pub control_max: [f64; 2],
    /// Smallest disturbance of the obstacle; empty for one that stands still.
    pub disturbance_min: Vec<f64>,
    /// Largest disturbance of the obstacle.
    pub disturbance_max: Vec<f64>,
}

impl SlackSettings {
    pub(crate) fn validate(&self) -> Checked {
        require(
            self.control_scale > 0.0 && self.control_scale <= 1.0,
            "offline.slack.control_scale",
            self.control_scale,
            "in (0, 1]",
        )?;
        require(
            self.disturbance_scale.is_finite() && self.disturbance_scale >= 1.0,
            "offline.slack.disturbance_scale",
            self.disturbance_scale,
            "finite and at least 1",
        )
    }
}

impl Settings {
    /// Returns the game to solve: the true input boxes, scaled as `offline.slack` says.
    ///
    /// Without slack these are the true boxes to the bit. A model fitted to the result still states the true ones, since it
    /// is those that the filter works with.
    pub fn training_game(&self) -> TrainingGame {
        let slack = self.offline.as_ref().and_then(|offline| offline.slack);
        let SlackSettings { control_scale, disturbance_scale } =
            slack.unwrap_or(SlackSettings { control_scale: 1.0, disturbance_scale: 1.0 });
        let (robot, obstacle) = (&self.robot, &self.obstacle);
        let control = |j: usize| scaled(robot.control_min[j], robot.control_max[j], control_scale);
        let disturbance = obstacle.disturbance_min.iter().zip(&obstacle.disturbance_max);
        let (disturbance_min, disturbance_max) =
            disturbance.map(|(&min, &max)| scaled(min, max, disturbance_scale)).unzip();
        TrainingGame {
            control_min: [control(0).0, control(1).0],
            control_max: [control(0).1, control(1).1],
            disturbance_min,
            disturbance_max,
        }
    }
}

/// Returns the interval `[min, max]` scaled about its centre; a scale of 1 changes no bit.
fn scaled(min: f64, max: f64, scale: f64) -> (f64, f64) {
    let inset = 0.5 * (1.0 - scale) * (max - min);
    (min + inset, max - inset)
}
