//! Process 3: the nominal controller.

use serde::{Deserialize, Serialize};

use crate::RobotKind;
use crate::error::{Checked, non_negative, positive, positive_ms, require};

/// Which controller drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ControllerKind {
    /// Model-predictive controller of the unicycle.
    Mpc,
    /// Linear-quadratic regulator of the double integrator.
    Lqr,
    /// Keeps still.
    Hold,
}

/// Weights and horizon of the unicycle MPC.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MpcSettings {
    /// Steps of the horizon.
    pub horizon_steps: usize,
    /// Length of a step, s.
    pub step_s: f64,
    /// Diagonal of Q, `[x, y, heading]`.
    pub state_weight: [f64; 3],
    /// Diagonal of the terminal Q_N.
    pub terminal_weight: [f64; 3],
    /// Diagonal of R, `[speed, yaw rate]`.
    pub control_weight: [f64; 2],
    /// Most SQP iterations in one cycle.
    pub max_iterations: usize,
    /// A failed solve may be bridged by the shifted old solution this many times in a row.
    pub max_bridged_failures: u32,
}

/// Weights of the double integrator's LQR.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LqrSettings {
    /// Diagonal of Q, `[x, y, vx, vy]`.
    pub state_weight: [f64; 4],
    /// Diagonal of R, `[ax, ay]`.
    pub control_weight: [f64; 2],
    /// The position error is shortened to this length, which bounds the cruising speed, m.
    pub max_position_error_m: f64,
}

/// Settings of `nominal_mpc`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NominalSettings {
    /// Which controller drives.
    pub controller: ControllerKind,
    /// Control period, ms.
    pub period_ms: u64,
    /// Oldest robot state that is answered, ms.
    pub max_state_age_ms: u64,
    /// Closer to the goal than this the robot is asked to stop, m.
    pub goal_tolerance_m: f64,
    /// The unicycle's controller.
    pub mpc: MpcSettings,
    /// The double integrator's controller.
    pub lqr: LqrSettings,
}

impl NominalSettings {
    pub(crate) fn validate(&self, kind: RobotKind) -> Checked {
        positive_ms("nominal.period_ms", self.period_ms)?;
        positive_ms("nominal.max_state_age_ms", self.max_state_age_ms)?;
        positive("nominal.goal_tolerance_m", self.goal_tolerance_m)?;
        let fits = match (self.controller, kind) {
            (ControllerKind::Mpc, RobotKind::Unicycle)
            | (ControllerKind::Lqr, RobotKind::DoubleIntegrator)
            | (ControllerKind::Hold, _) => true,
            (ControllerKind::Mpc, RobotKind::DoubleIntegrator)
            | (ControllerKind::Lqr, RobotKind::Unicycle) => false,
        };
        let requirement = "mpc or hold for a unicycle, lqr or hold for a double integrator";
        require(fits, "nominal.controller", self.controller, requirement)?;
        let mpc = &self.mpc;
        require(mpc.horizon_steps > 0, "nominal.mpc.horizon_steps", mpc.horizon_steps, "at least 1")?;
        positive("nominal.mpc.step_s", mpc.step_s)?;
        for weight in mpc.state_weight.iter().chain(&mpc.terminal_weight) {
            non_negative("nominal.mpc.state_weight / terminal_weight", *weight)?;
        }
        for weight in mpc.control_weight {
            positive("nominal.mpc.control_weight", weight)?;
        }
        require(mpc.max_iterations > 0, "nominal.mpc.max_iterations", mpc.max_iterations, "at least 1")?;
        for weight in self.lqr.state_weight {
            non_negative("nominal.lqr.state_weight", weight)?;
        }
        for weight in self.lqr.control_weight {
            positive("nominal.lqr.control_weight", weight)?;
        }
        positive("nominal.lqr.max_position_error_m", self.lqr.max_position_error_m)
    }
}
