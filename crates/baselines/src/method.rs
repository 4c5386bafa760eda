//! What every method takes and gives.

use crate::inputs::{Inputs, NoControl};

/// A method of the paper's comparison: constructed once, stepped once per period.
pub trait Method: Send {
    /// Runs one cycle at `now_ns`, stack clock.
    ///
    /// Everything is brought to `now_ns` first: the robot by its measured velocity, obstacles by theirs. What comes back
    /// is to be applied whatever the verdict, as the authors did.
    ///
    /// # Errors
    /// [`NoControl`] where there is nothing to compute from. A problem without solution is no error but a verdict.
    fn step(&mut self, inputs: &Inputs<'_>, now_ns: u64) -> Result<MethodOutput, NoControl>;

    /// Forgets what was carried from cycle to cycle, as between runs.
    fn reset(&mut self);
}

/// What the solver says of the problem it was given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Solved, and every demand is met.
    Feasible,
    /// Some demand is not met: of a planner, at the end of its search and so at least near its guess; of a filter, by no
    /// admissible control.
    Infeasible,
    /// A planner's search ended early. Whether its plan meets every demand, [`MethodOutput::demands_met`] says.
    IterationLimit,
    /// The solver gave up. The control is the best one known before.
    SolverFailed,
}

/// One cycle's result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodOutput {
    /// `[speed m/s, yaw rate rad/s]` or `[ax, ay] m/s²` in `odom`, as the robot is; inside its box, finite.
    pub control: [f64; 2],
    /// What became of the problem.
    pub verdict: Verdict,
    /// Whether what is given meets every demand within the method's own tolerance, however the search ended. Never with
    /// [`Verdict::Infeasible`] or [`Verdict::SolverFailed`], always with [`Verdict::Feasible`].
    pub demands_met: bool,
    /// By how much the worst demand is missed, ≥ 0; unit of the demands (planners m, VO-MPC rad; HO-CBF m/s², C3BF
    /// m²/s²). Small values above zero are usual with [`Verdict::Feasible`] too: solvers have tolerances, and a filter's
    /// active row gives way by its multiplier over the slack's weight.
    pub slack: f64,
    /// Margin without slack, unit of the demands; `+∞` with nobody in sight. Of a filter the largest that any
    /// admissible control has in its worst demand, so the hard problem is feasible exactly where it is ≥ 0; of a planner
    /// that of the plan at hand, so the hard problem is feasible at least there.
    pub hard_feasibility_margin: f64,
    /// What is minimised, without the price of slack: a planner's cost `Σ xᵀQx + uᵀRu`, a filter's `‖u − u_nom‖²`.
    pub cost: f64,
    /// Quadratic programs (planners) or active sets (filters) that were solved.
    pub iterations: u32,
    /// Obstacles that were taken into account.
    pub obstacle_count: u32,
}
