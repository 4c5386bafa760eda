//! The unicycle MPC and what happens when its solver fails.

use optimal_control::{
    QuadraticWeights, SqpError, SqpReport, SqpSettings, SqpSetupError, SqpStatus, UnicycleMpc,
    UnicycleMpcSettings,
};
use settings::{MpcSettings, RobotSettings};

use crate::Silence;

/// Changes of speed (m/s) and yaw rate (rad/s) below this are not worth another iteration.
const STEP_TOLERANCE: f64 = 1e-4;

/// The MPC with its count of failures in a row.
pub(crate) struct MpcDrive {
    mpc: UnicycleMpc,
    max_bridged_failures: u32,
    /// When the plan that stands was made for, stack clock, ns; `None` without a plan.
    planned_at_ns: Option<u64>,
    failures_in_a_row: u32,
}

impl MpcDrive {
    pub(crate) fn new(mpc: &MpcSettings, robot: &RobotSettings) -> Result<Self, SqpSetupError> {
        let settings = UnicycleMpcSettings {
            step_s: mpc.step_s,
            sqp: SqpSettings {
                horizon_steps: mpc.horizon_steps,
                weights: QuadraticWeights {
                    stage_state: mpc.state_weight,
                    terminal_state: mpc.terminal_weight,
                    control: mpc.control_weight,
                },
                control_min: robot.control_min,
                control_max: robot.control_max,
                iteration_limit: u32::try_from(mpc.max_iterations).unwrap_or(u32::MAX),
                step_tolerance: STEP_TOLERANCE,
            },
        };
        Ok(Self {
            mpc: UnicycleMpc::new(&settings)?,
            max_bridged_failures: mpc.max_bridged_failures,
            planned_at_ns: None,
            failures_in_a_row: 0,
        })
    }

    /// Forgets the plan, as when the robot has stopped at its goal.
    pub(crate) fn reset(&mut self) {
        self.mpc.reset();
        self.planned_at_ns = None;
        self.failures_in_a_row = 0;
    }

    /// First control `[speed_mps, yaw_rate_radps]` of the plan from `pose` at `valid_at_ns`, and the SQP iterations.
    ///
    /// After a failure the previous plan, shifted to now, speaks, at most `max_bridged_failures` times in a row.
    pub(crate) fn control(
        &mut self,
        pose: &[f64; 3],
        goal: &[f64; 3],
        valid_at_ns: u64,
    ) -> Result<([f64; 2], u32), Silence> {
        let had_plan = self.planned_at_ns.is_some();
        let elapsed_ns =
            self.planned_at_ns.map_or(0, |planned_at_ns| valid_at_ns.saturating_sub(planned_at_ns));
        let outcome = self.mpc.plan(pose, goal, elapsed_ns as f64 * 1e-9);
        if let Ok(report) = &outcome {
            // From here on the shifted plan starts at this state, whether or not it was improved.
            self.planned_at_ns = Some(valid_at_ns);
            if is_plan(report) {
                self.failures_in_a_row = 0;
                return Ok((self.mpc.controls()[0], report.iterations));
            }
        }
        self.failures_in_a_row = self.failures_in_a_row.saturating_add(1);
        let may_bridge = match outcome {
            Ok(_) => had_plan && self.failures_in_a_row <= self.max_bridged_failures,
            // Nothing was shifted, and nothing that was asked for makes sense.
            Err(SqpError::NonFinite { .. }) => false,
        };
        if may_bridge {
            return Ok((self.mpc.controls()[0], 0));
        }
        self.mpc.reset();
        self.planned_at_ns = None;
        Err(Silence::SolverFailed)
    }
}

/// Whether at least one QP was solved, so that the controls answer this state and not only the previous one.
fn is_plan(report: &SqpReport) -> bool {
    match report.status {
        SqpStatus::Converged | SqpStatus::IterationLimit | SqpStatus::NoDescent => true,
        SqpStatus::QpFailed => report.iterations > 1,
    }
}
