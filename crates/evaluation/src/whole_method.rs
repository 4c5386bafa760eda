//! The seam for methods that are no filter of ours: what they are given, what they answer.
//!
//! Not here: how a method's answers reach the robot (`seat`), and the methods themselves (crate `baselines`, see `baseline`).

use messages::{Goal, NominalCommand, Obstacles, RobotState};

/// The newest message of each kind; `None` where none has arrived yet.
#[derive(Debug, Clone, Copy, Default)]
pub struct MethodInputs<'a> {
    /// Where the robot is.
    pub robot_state: Option<&'a RobotState>,
    /// What is around it.
    pub obstacles: Option<&'a Obstacles>,
    /// Where it shall go.
    pub goal: Option<&'a Goal>,
    /// What the nominal controller of the settings would do; `None` for a method that corrects none.
    pub nominal: Option<&'a NominalCommand>,
}

/// One answer of a method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodCommand {
    /// The control, `[speed m/s, yaw rate rad/s]` or `[ax, ay] m/s²` in `odom`, as the robot is. Finite. Applied whatever
    /// `feasible` says, as the authors of the methods did.
    pub control: [f64; 2],
    /// Whether the method's own demands are all met.
    pub feasible: bool,
    /// By how much the worst demand is missed, ≥ 0, in the unit of the method's demands.
    pub slack: f64,
    /// Margin of the method's demands without slack, in their unit; negative where they cannot be met, `+∞` with nobody
    /// in sight.
    pub hard_margin: f64,
    /// Obstacles that were taken into account.
    pub obstacle_count: u32,
}

/// A complete method: from what is known to a control.
pub trait WholeMethod {
    /// Whether it corrects a nominal command. A planner does not: no nominal controller runs beside it.
    fn corrects_nominal(&self) -> bool;

    /// Runs one cycle at `now_ns`, virtual time; `None` where there is nothing to compute from: the robot then brakes.
    fn step(&mut self, inputs: &MethodInputs<'_>, now_ns: u64) -> Option<MethodCommand>;
}
