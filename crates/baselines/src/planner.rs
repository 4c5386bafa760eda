//! The planners: model-predictive control of the unicycle under one method's demands.

use dynamics::InputBox;
use messages::MAX_OBSTACLES;
use optimal_control::{
    QuadraticWeights, SqpError, SqpReport, SqpSettings, SqpStatus, UnicycleMpc, UnicycleMpcSettings,
};

use crate::inputs::{Inputs, NoControl};
use crate::method::{Method, MethodOutput, Verdict};
use crate::parameters::PlannerParameters;
use crate::rows::{Avoidance, Demand};
use crate::setup::MethodSetupError;
use crate::surroundings::{Seen, Surroundings, pose_at};

/// Changes of speed (m/s) and yaw rate (rad/s) below this end the search.
const STEP_TOLERANCE: f64 = 1e-4;

/// A planner of the comparison.
pub(crate) struct Planner<R> {
    mpc: UnicycleMpc<Avoidance<R>>,
    surroundings: Surroundings,
    feasibility_tolerance: f64,
    /// Where further searches begin.
    corners: Vec<[f64; 2]>,
    /// The best plan of the cycle while another is searched for.
    best: Vec<[f64; 2]>,
    /// When the plan that stands was made, stack clock, ns.
    planned_at_ns: Option<u64>,
}

impl<R: Demand> Planner<R> {
    pub(crate) fn new(
        parameters: &PlannerParameters,
        demand: R,
        control: InputBox<2>,
        robot_radius_m: f64,
    ) -> Result<Self, MethodSetupError> {
        parameters.validate()?;
        let settings = UnicycleMpcSettings {
            step_s: parameters.step_s,
            sqp: SqpSettings {
                horizon_steps: parameters.horizon_steps,
                weights: QuadraticWeights {
                    stage_state: parameters.state_weight,
                    terminal_state: parameters.terminal_weight,
                    control: parameters.control_weight,
                },
                control_min: control.min,
                control_max: control.max,
                iteration_limit: parameters.iteration_limit,
                step_tolerance: STEP_TOLERANCE,
            },
        };
        let rows = parameters.sight.obstacle_limit.min(MAX_OBSTACLES);
        let demands = Avoidance::new(demand, parameters.step_s, rows, Seen::typical(2.0 * robot_radius_m));
        Ok(Self {
            mpc: UnicycleMpc::with_constraints(&settings, demands, parameters.violation_weight)?,
            surroundings: Surroundings::new(parameters.sight, robot_radius_m),
            feasibility_tolerance: parameters.feasibility_tolerance,
            corners: if parameters.search_again { corners(&control) } else { Vec::new() },
            best: Vec::with_capacity(parameters.horizon_steps),
            planned_at_ns: None,
        })
    }

    /// Searches from every corner of the box until all demands are met; keeps the plan that misses least.
    fn search_again(
        &mut self,
        first: SqpReport,
        pose: &[f64; 3],
        goal: &[f64; 3],
    ) -> Result<SqpReport, SqpError> {
        let mut best = first;
        let (mut iterations, mut qp_iterations) = (first.iterations, first.qp_iterations);
        for corner in 0..self.corners.len() {
            if best.smallest_row >= -self.feasibility_tolerance {
                break;
            }
            self.best.clear();
            self.best.extend_from_slice(self.mpc.controls());
            let report = self.mpc.plan_again_from(pose, goal, self.corners[corner])?;
            iterations += report.iterations;
            qp_iterations += report.qp_iterations;
            let solved = report.status != SqpStatus::QpFailed;
            if solved && report.violation < best.violation {
                best = report;
            } else {
                self.mpc.restore(&self.best);
            }
        }
        Ok(SqpReport { iterations, qp_iterations, ..best })
    }

    /// What became of the search, and whether its plan meets every demand. A plan found by a search that ended early may
    /// well do; what is left after a failed one was planned for another moment.
    fn verdict(&self, status: SqpStatus, margin: f64) -> (Verdict, bool) {
        let is_within = margin >= -self.feasibility_tolerance;
        match status {
            SqpStatus::Converged | SqpStatus::NoDescent if is_within => (Verdict::Feasible, true),
            SqpStatus::Converged | SqpStatus::NoDescent => (Verdict::Infeasible, false),
            SqpStatus::IterationLimit => (Verdict::IterationLimit, is_within),
            SqpStatus::QpFailed => (Verdict::SolverFailed, false),
        }
    }
}

impl<R: Demand> Method for Planner<R> {
    fn step(&mut self, inputs: &Inputs<'_>, now_ns: u64) -> Result<MethodOutput, NoControl> {
        let state = inputs.sound_robot_state()?;
        let goal = inputs.sound_goal()?;
        let obstacles = inputs.sound_obstacles()?;
        let pose = pose_at(state, now_ns);
        let [x, y] = goal.position_in_odom_m;
        let seen = self.surroundings.look(obstacles, [pose[0], pose[1]], now_ns);
        let demands = self.mpc.constraints_mut();
        demands.place(seen, [x, y]);
        let clearance_now = if demands.demand.demands_at_start() {
            seen.iter().map(Seen::clearance_m).fold(f64::INFINITY, f64::min)
        } else {
            f64::INFINITY
        };
        let obstacle_count = seen.len();
        let elapsed_ns = self.planned_at_ns.map_or(0, |at_ns| now_ns.saturating_sub(at_ns));
        let target = [x, y, goal.heading_rad];
        let report = self
            .mpc
            .plan(&pose, &target, elapsed_ns as f64 * 1e-9)
            .and_then(|report| self.search_again(report, &pose, &target))
            // Every input is finite, so this is one too large to compute with.
            .map_err(|_| NoControl::NonFinite { input: "robot_state, goal or obstacles" })?;
        self.planned_at_ns = Some(now_ns);
        let margin = if obstacle_count == 0 { f64::INFINITY } else { report.smallest_row.min(clearance_now) };
        let (verdict, demands_met) = self.verdict(report.status, margin);
        Ok(MethodOutput {
            control: self.mpc.controls()[0],
            verdict,
            demands_met,
            slack: (-margin).max(0.0),
            hard_feasibility_margin: margin,
            cost: report.cost,
            iterations: report.iterations,
            obstacle_count: obstacle_count as u32,
        })
    }

    fn reset(&mut self) {
        self.mpc.reset();
        self.planned_at_ns = None;
    }
}

/// The four corners of the control box, fast ones first.
fn corners(control: &InputBox<2>) -> Vec<[f64; 2]> {
    let (min, max) = (control.min, control.max);
    vec![max, [max[0], min[1]], [min[0], max[1]], min]
}
