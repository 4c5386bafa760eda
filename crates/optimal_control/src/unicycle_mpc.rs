//! The paper's nominal controller of the ground robot: model-predictive control of a unicycle, blind to obstacles.
//!
//! What it adds to [`Sqp`] is a heading without jumps and guesses that cope with a goal behind the robot.

use std::f64::consts::{FRAC_PI_6, PI, TAU};

use crate::constraints::{NoConstraints, StageConstraints};
use crate::dynamics::EulerUnicycle;
use crate::sqp::Sqp;
use crate::sqp_settings::{QuadraticWeights, SqpSettings, SqpSetupError, require_positive};
use crate::sqp_status::{SqpError, SqpReport};
use crate::turn_policy::{FirstTurn, turn_then_drive, wrap};

/// How far the heading error may pass half a turn before the shorter way round is taken, rad.
///
/// Without it a robot that faces away from its goal heading would change its mind with every bit of noise.
const BRANCH_HYSTERESIS_RAD: f64 = FRAC_PI_6;
/// A rough guess replaces the previous plan only if it costs less than this share of it.
const GUESS_ADVANTAGE: f64 = 0.999;

/// What a person chooses of the controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnicycleMpcSettings {
    /// Length of a prediction step, s. Paper: 0.1.
    pub step_s: f64,
    /// Horizon, weights, input box `[speed_mps, yaw_rate_radps]` and iteration limit.
    pub sqp: SqpSettings<3, 2>,
}

impl UnicycleMpcSettings {
    /// The paper's: 2 s ahead in steps of 0.1 s, speed in [0.25, 1] m/s, yaw rate in [−0.8, 0.8] rad/s; weights
    /// (50, 50, 1) and (1, 1) as in the first author's public planners.
    pub fn paper() -> Self {
        Self {
            step_s: 0.1,
            sqp: SqpSettings {
                horizon_steps: 20,
                weights: QuadraticWeights {
                    stage_state: [50.0, 50.0, 1.0],
                    terminal_state: [50.0, 50.0, 1.0],
                    control: [1.0, 1.0],
                },
                control_min: [0.25, -0.8],
                control_max: [1.0, 0.8],
                iteration_limit: 10,
                step_tolerance: 1e-4,
            },
        }
    }
}

/// Model-predictive control of `[x, y, heading]` towards a goal pose.
///
/// The cost is the paper's, quadratic in position and heading error; its weights on the position belong to the axes
/// in which the poses are given. With equal weights plans move with the pair of pose and goal, however it is turned.
///
/// The heading error is an angle on the real line: the branch next to the previous error is kept, up to 30° beyond
/// half a turn, so it never jumps as the measured heading wraps. A guess that turns left and one that turns right
/// compete with the previous plan, so that a goal straight behind, where every derivative vanishes, is turned to as
/// well.
///
/// With [`StageConstraints`] it is a planner that avoids what they forbid. They see states `[x_m, y_m, heading_rad]`
/// whose origin is the goal and whose axes and heading (up to full turns) are those of the poses given.
pub struct UnicycleMpc<C = NoConstraints> {
    sqp: Sqp<EulerUnicycle, 3, 2, C>,
    /// Error of the previous call and the goal it belonged to.
    memory: Option<Memory>,
}

#[derive(Debug, Clone, Copy)]
struct Memory {
    goal: [f64; 3],
    heading_error: f64,
}

impl UnicycleMpc {
    /// Sets the controller up, with no plan yet.
    ///
    /// # Errors
    /// Unusable settings.
    pub fn new(settings: &UnicycleMpcSettings) -> Result<Self, SqpSetupError> {
        Self::with_constraints(settings, NoConstraints, 1.0)
    }
}

impl<C: StageConstraints<3, 2>> UnicycleMpc<C> {
    /// Sets a planner up under inequalities, with no plan yet; `violation_weight` as for [`Sqp::with_constraints`].
    ///
    /// # Errors
    /// Unusable settings.
    pub fn with_constraints(
        settings: &UnicycleMpcSettings,
        constraints: C,
        violation_weight: f64,
    ) -> Result<Self, SqpSetupError> {
        require_positive("step_s", settings.step_s)?;
        let dynamics = EulerUnicycle { step_s: settings.step_s };
        let typical_state = [-3.0, 1.0, 0.5];
        let sqp =
            Sqp::with_constraints(dynamics, settings.sqp, constraints, violation_weight, &typical_state)?;
        Ok(Self { sqp, memory: None })
    }

    /// The inequalities, to be moved before the next plan.
    pub fn constraints_mut(&mut self) -> &mut C {
        self.sqp.constraints_mut()
    }

    /// Forgets the previous plan, as after a jump of the pose.
    pub fn reset(&mut self) {
        self.memory = None;
    }

    /// Plans from `pose` to `goal`, both `[x_m, y_m, heading_rad]` in one frame, any heading.
    ///
    /// `elapsed_s` is the time since the previous plan, by which that plan is shifted to serve as the guess.
    ///
    /// # Errors
    /// [`SqpError::NonFinite`]; the previous plan is then untouched.
    pub fn plan(&mut self, pose: &[f64; 3], goal: &[f64; 3], elapsed_s: f64) -> Result<SqpReport, SqpError> {
        let (start, reference, heading_error) = self.problem(pose, goal)?;
        let dynamics = *self.sqp.dynamics();
        if self.memory.is_some() {
            self.sqp.shift_guess(elapsed_s / dynamics.step_s);
        } else {
            self.sqp.guess_by_policy(&start, |_, state| turn_then_drive(dynamics, FirstTurn::Left, state));
        }
        for first_turn in [FirstTurn::Left, FirstTurn::Right] {
            let policy = |_: usize, state: &[f64; 3]| turn_then_drive(dynamics, first_turn, state);
            self.sqp.guess_by_cheaper_policy(&start, &reference, GUESS_ADVANTAGE, policy);
        }
        let report = self.sqp.solve(&start, &reference)?;
        self.memory = Some(Memory { goal: *goal, heading_error });
        Ok(report)
    }

    /// Plans the problem of the last [`Self::plan`] once more, beginning with one constant control instead of the
    /// previous plan: where inequalities split the plans, each side has its own optimum.
    ///
    /// # Errors
    /// As [`Self::plan`].
    pub fn plan_again_from(
        &mut self,
        pose: &[f64; 3],
        goal: &[f64; 3],
        control: [f64; 2],
    ) -> Result<SqpReport, SqpError> {
        let (start, reference, _) = self.problem(pose, goal)?;
        self.sqp.guess_by_policy(&start, |_, _| control);
        self.sqp.solve(&start, &reference)
    }

    /// Puts back the controls of another plan from the same pose, see [`Sqp::restore`].
    pub fn restore(&mut self, controls: &[[f64; 2]]) {
        self.sqp.restore(controls);
    }

    /// Start and reference as the SQP takes them, and the heading error.
    fn problem(&self, pose: &[f64; 3], goal: &[f64; 3]) -> Result<([f64; 3], [f64; 3], f64), SqpError> {
        for (quantity, values) in [("the pose", pose), ("the goal", goal)] {
            if !values.iter().all(|value| value.is_finite()) {
                return Err(SqpError::NonFinite { quantity });
            }
        }
        let heading_error = self.heading_error(pose, goal);
        // Only the origin moves to the goal, the axes stay: so the third entry is the heading in these axes, and its
        // reference the goal's. The heading error there would let the plan drive off in another direction.
        let start = [pose[0] - goal[0], pose[1] - goal[1], goal[2] + heading_error];
        Ok((start, [0.0, 0.0, goal[2]], heading_error))
    }

    /// Controls `[speed_mps, yaw_rate_radps]` of the plan that stands, one per step.
    pub fn controls(&self) -> &[[f64; 2]] {
        self.sqp.controls()
    }

    /// States `[x_m, y_m, heading_rad]` that the plan leads through, relative to the goal's position, the start first.
    pub fn states(&self) -> &[[f64; 3]] {
        self.sqp.states()
    }

    /// Length of a prediction step, s.
    pub fn step_s(&self) -> f64 {
        self.sqp.dynamics().step_s
    }

    fn heading_error(&self, pose: &[f64; 3], goal: &[f64; 3]) -> f64 {
        let shortest = wrap(pose[2] - goal[2]);
        match self.memory {
            Some(memory) if memory.goal == *goal => {
                let continued = shortest + TAU * ((memory.heading_error - shortest) / TAU).round();
                if continued.abs() <= PI + BRANCH_HYSTERESIS_RAD { continued } else { shortest }
            }
            Some(_) | None => shortest,
        }
    }
}
