//! The robot and what is assumed of the obstacles around it.

use serde::{Deserialize, Serialize};

use crate::error::{Checked, bounds, positive, require};

/// How obstacles may move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ObstacleMotion {
    /// As the robot's kind says: at a constant speed and a bounded turn rate, or with bounded accelerations.
    #[default]
    Walking,
    /// Not at all: walls, posts, parked vehicles. Only for a unicycle robot.
    Static,
}

/// Which dynamics the robot has, and with them the obstacle's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RobotKind {
    /// Kinematic unicycle, control `[speed, yaw rate]`.
    Unicycle,
    /// Planar double integrator, control `[ax, ay]`.
    DoubleIntegrator,
}

/// The robot that is driven.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotSettings {
    /// Dynamics.
    pub kind: RobotKind,
    /// Radius of the disc that covers the robot, m.
    pub radius_m: f64,
    /// Smallest admissible control: `[m/s, rad/s]` or `[m/s², m/s²]`.
    pub control_min: [f64; 2],
    /// Largest admissible control, same units.
    pub control_max: [f64; 2],
    /// Deceleration of the brake fallback, m/s². The ladder brakes with it, below `control_min` if need be.
    pub brake_deceleration_mps2: f64,
}

impl RobotSettings {
    pub(crate) fn validate(&self) -> Checked {
        positive("robot.radius_m", self.radius_m)?;
        bounds("robot.control_min / control_max", &self.control_min, &self.control_max)?;
        positive("robot.brake_deceleration_mps2", self.brake_deceleration_mps2)
    }
}

/// What is assumed of every obstacle. The model must have been trained for exactly this.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObstacleSettings {
    /// How obstacles may move; `walking` if the file does not say.
    #[serde(default)]
    pub motion: ObstacleMotion,
    /// Radius taken where perception gives none, and the one the model was made for, m.
    pub radius_m: f64,
    /// Smallest obstacle input: `[rad/s]` of a walking unicycle, or `[m/s², m/s²]`; empty if static.
    pub disturbance_min: Vec<f64>,
    /// Largest obstacle input, same units.
    pub disturbance_max: Vec<f64>,
    /// Fastest obstacle that the model covers, m/s; 0 if static.
    pub max_speed_mps: f64,
}

impl ObstacleSettings {
    pub(crate) fn validate(&self, kind: RobotKind) -> Checked {
        positive("obstacle.radius_m", self.radius_m)?;
        bounds("obstacle.disturbance_min / disturbance_max", &self.disturbance_min, &self.disturbance_max)?;
        let (expected, requirement) = match (self.motion, kind) {
            (ObstacleMotion::Walking, RobotKind::Unicycle) => {
                (1, "one number, the turn rate, for a unicycle among walking obstacles")
            }
            (ObstacleMotion::Walking, RobotKind::DoubleIntegrator) => {
                (2, "two numbers, the accelerations, for a double integrator")
            }
            (ObstacleMotion::Static, RobotKind::Unicycle) => (0, "empty for obstacles that stand still"),
            (ObstacleMotion::Static, RobotKind::DoubleIntegrator) => {
                return require(
                    false,
                    "obstacle.motion",
                    self.motion,
                    "`walking` for a double integrator (set the accelerations to 0 for things that keep their velocity)",
                );
            }
        };
        require(
            self.disturbance_min.len() == expected,
            "obstacle.disturbance_min",
            &self.disturbance_min,
            requirement,
        )?;
        match self.motion {
            ObstacleMotion::Walking => positive("obstacle.max_speed_mps", self.max_speed_mps),
            ObstacleMotion::Static => require(
                self.max_speed_mps == 0.0,
                "obstacle.max_speed_mps",
                self.max_speed_mps,
                "0 for obstacles that stand still",
            ),
        }
    }
}
