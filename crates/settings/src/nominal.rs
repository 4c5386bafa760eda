//! Process 3: the nominal controller.

use serde::{Deserialize, Serialize};

use crate::error::{Checked, invalid, non_negative, positive, positive_ms, require};
use crate::{RobotKind, Settings, SettingsError};

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
    /// Pure pursuit of the goal by the unicycle.
    PurePursuit,
    /// None of ours: the place is left to a program of somebody else's.
    External,
}

impl ControllerKind {
    /// Its name in settings and on the command line.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Mpc => "mpc",
            Self::Lqr => "lqr",
            Self::Hold => "hold",
            Self::PurePursuit => "pure_pursuit",
            Self::External => "external",
        }
    }
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

/// Pure pursuit of the goal by the unicycle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PurePursuitSettings {
    /// Distance of the point that is pursued, or the goal's where that is nearer, m.
    pub lookahead_m: f64,
    /// Speed where the way is straight, m/s.
    pub speed_mps: f64,
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
    /// Only `pure_pursuit` needs it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pure_pursuit: Option<PurePursuitSettings>,
}

impl Settings {
    /// Takes another nominal controller than the file names.
    ///
    /// # Errors
    /// [`SettingsError::Invalid`] if it is not for this robot or its own table is missing; nothing changes then.
    pub fn use_controller(&mut self, controller: ControllerKind) -> Result<(), SettingsError> {
        let nominal = NominalSettings { controller, ..self.nominal.clone() };
        nominal.validate(self.robot.kind)?;
        self.nominal = nominal;
        Ok(())
    }
}

impl NominalSettings {
    pub(crate) fn validate(&self, kind: RobotKind) -> Checked {
        positive_ms("nominal.period_ms", self.period_ms)?;
        positive_ms("nominal.max_state_age_ms", self.max_state_age_ms)?;
        positive("nominal.goal_tolerance_m", self.goal_tolerance_m)?;
        let fits = match (self.controller, kind) {
            (ControllerKind::Mpc | ControllerKind::PurePursuit, RobotKind::Unicycle)
            | (ControllerKind::Lqr, RobotKind::DoubleIntegrator)
            | (ControllerKind::Hold | ControllerKind::External, _) => true,
            (ControllerKind::Mpc | ControllerKind::PurePursuit, RobotKind::DoubleIntegrator)
            | (ControllerKind::Lqr, RobotKind::Unicycle) => false,
        };
        let requirement =
            "mpc or pure_pursuit for a unicycle, lqr for a double integrator, hold or external for both";
        require(fits, "nominal.controller", self.controller.label(), requirement)?;
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
        positive("nominal.lqr.max_position_error_m", self.lqr.max_position_error_m)?;
        match &self.pure_pursuit {
            Some(pursuit) => {
                positive("nominal.pure_pursuit.lookahead_m", pursuit.lookahead_m)?;
                positive("nominal.pure_pursuit.speed_mps", pursuit.speed_mps)
            }
            None if self.controller == ControllerKind::PurePursuit => Err(invalid(
                "nominal.controller",
                &self.controller.label(),
                "accompanied by a table [nominal.pure_pursuit] with lookahead_m and speed_mps",
            )),
            None => Ok(()),
        }
    }
}
