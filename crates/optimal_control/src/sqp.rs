//! Sequential quadratic programming along trajectories that always obey the dynamics.
//!
//! Each iteration linearises around the current trajectory, lets the QP choose a change of the controls, and rolls
//! the changed controls out through the true dynamics. So every iterate obeys dynamics and input box, the cost itself
//! decides how far to go, and whatever stops the search leaves usable controls behind.

use crate::constraints::{ConstraintRow, NoConstraints, StageConstraints};
use crate::dynamics::DiscreteDynamics;
use crate::expansion::{
    Violation, cost, curvature, directional_derivative, expand, linearise_constraints, predicted_violation,
    roll_out, violation,
};
use crate::sqp_settings::{SqpSettings, SqpSetupError, require_positive};
use crate::sqp_status::{SqpError, SqpReport, SqpStatus};
use crate::trajectory_qp::{Stage, TrajectoryQp};

/// Share of the decrease promised by the QP that a step must keep (Armijo).
const SUFFICIENT_DECREASE: f64 = 1e-4;
/// Halvings of a step before it counts as no descent.
const HALVING_LIMIT: u32 = 12;
/// A promised decrease below this share of the cost is not worth having.
const RELATIVE_DECREASE: f64 = 1e-10;
/// Where the cost after a full step is what the QP said, up to this share, the next QP would have as little to add.
const MODEL_ERROR: f64 = 1e-8;

/// Box-constrained optimal control with quadratic cost around one reference state, with inequalities if there are any.
///
/// Minimises `J(u) = Σ_{k<N} (x_k−r)ᵀQ(x_k−r) + u_kᵀR u_k + (x_N−r)ᵀQ_N(x_N−r)` subject to
/// `x_{k+1} = f(x_k, u_k)` and `u_min ≤ u_k ≤ u_max`, from the controls left by the previous call.
///
/// With inequalities `g(x_k, u_k, x_{k+1}) ≥ 0` it minimises the exact penalty `J + ρ Σ max(0, −g)`. Where the
/// inequalities can be met near the guess and `ρ` exceeds every multiplier, its minimum is that of the hard problem; a
/// smaller `ρ` makes them soft; where they cannot be met, what stands violates them least in the sum. So the QPs always
/// have a solution, and [`SqpReport::smallest_row`] says whether the inequalities hold.
///
/// Clarabel allocates while it solves; nothing else here does after construction.
pub struct Sqp<D, const NX: usize, const NU: usize, C = NoConstraints> {
    dynamics: D,
    settings: SqpSettings<NX, NU>,
    constraints: C,
    /// `ρ`, cost per unit of a violated row.
    violation_weight: f64,
    qp: TrajectoryQp<NX, NU>,
    stages: Vec<Stage<NX, NU>>,
    /// The inequalities around the trajectory that stands, step by step; their multipliers; the values of one step.
    rows: Vec<ConstraintRow<NX, NU>>,
    multipliers: Vec<f64>,
    row_values: Vec<f64>,
    /// `u_0 … u_{N−1}` and `x_0 … x_N` that stand.
    controls: Vec<[f64; NU]>,
    states: Vec<[f64; NX]>,
    /// The same, of the step under trial.
    trial_controls: Vec<[f64; NU]>,
    trial_states: Vec<[f64; NX]>,
}

impl<D: DiscreteDynamics<NX, NU>, const NX: usize, const NU: usize> Sqp<D, NX, NU> {
    /// Sets a problem without inequalities up; the first guess is the middle of the input box.
    ///
    /// `typical_state` relative to a reference of zero fixes the scaling of the QP once and for all: give one with
    /// errors of the size that will occur.
    ///
    /// # Errors
    /// Unusable settings, see [`SqpSettings::validate`].
    pub fn new(
        dynamics: D,
        settings: SqpSettings<NX, NU>,
        typical_state: &[f64; NX],
    ) -> Result<Self, SqpSetupError> {
        Self::with_constraints(dynamics, settings, NoConstraints, 1.0, typical_state)
    }
}

impl<D, C, const NX: usize, const NU: usize> Sqp<D, NX, NU, C>
where
    D: DiscreteDynamics<NX, NU>,
    C: StageConstraints<NX, NU>,
{
    /// Sets the problem up with inequalities; the first guess is the middle of the input box.
    ///
    /// `violation_weight` is `ρ`, cost per unit of a violated row. `typical_state` as for [`Self::new`]; the
    /// inequalities, too, should be typical at construction.
    ///
    /// # Errors
    /// Unusable settings, see [`SqpSettings::validate`], or a weight that is not above zero.
    pub fn with_constraints(
        dynamics: D,
        settings: SqpSettings<NX, NU>,
        mut constraints: C,
        violation_weight: f64,
        typical_state: &[f64; NX],
    ) -> Result<Self, SqpSetupError> {
        settings.validate()?;
        require_positive("violation_weight", violation_weight)?;
        let middle = std::array::from_fn(|j| 0.5 * (settings.control_min[j] + settings.control_max[j]));
        let controls = vec![middle; settings.horizon_steps];
        let mut states = vec![*typical_state; settings.horizon_steps + 1];
        roll_out(&dynamics, typical_state, &controls, &mut states);
        let blank = Stage {
            jacobians: dynamics.linearise(typical_state, &middle),
            gradient: ([0.0; NU], [0.0; NX]),
            hessian: ([0.0; NU], [0.0; NX]),
            to_upper: [0.0; NU],
            to_lower: [0.0; NU],
        };
        let mut stages = vec![blank; settings.horizon_steps];
        let row_values = vec![0.0; constraints.rows_per_step()];
        let mut rows = vec![ConstraintRow::constant(0.0); row_values.len() * settings.horizon_steps];
        let multipliers = vec![0.0; rows.len()];
        linearise_constraints(&mut constraints, &states, &controls, &mut rows);
        let around = (states.as_slice(), controls.as_slice());
        expand(&dynamics, &settings, around, &[0.0; NX], (&rows, &multipliers), &mut stages);
        let sparsity = (dynamics.sparsity(), constraints.sparsity());
        let qp = TrajectoryQp::new(&stages, &rows, violation_weight, sparsity)?;
        let (trial_controls, trial_states) = (controls.clone(), states.clone());
        Ok(Self {
            dynamics,
            settings,
            constraints,
            violation_weight,
            qp,
            stages,
            rows,
            multipliers,
            row_values,
            controls,
            states,
            trial_controls,
            trial_states,
        })
    }

    /// The inequalities, to be moved before the next solve.
    pub fn constraints_mut(&mut self) -> &mut C {
        &mut self.constraints
    }

    /// Controls that stand: the guess before a solve, its result afterwards. One per step of the horizon.
    pub fn controls(&self) -> &[[f64; NU]] {
        &self.controls
    }

    /// States that the last solve predicts, the start first: one more than there are steps.
    pub fn states(&self) -> &[[f64; NX]] {
        &self.states
    }

    /// Settings given at construction.
    pub fn settings(&self) -> &SqpSettings<NX, NU> {
        &self.settings
    }

    /// The dynamics given at construction.
    pub fn dynamics(&self) -> &D {
        &self.dynamics
    }

    /// Replaces the guess by what `control(k, state_k)` does from `start`, brought into the input box.
    pub fn guess_by_policy(
        &mut self,
        start: &[f64; NX],
        mut control: impl FnMut(usize, &[f64; NX]) -> [f64; NU],
    ) {
        let mut state = *start;
        for (k, slot) in self.controls.iter_mut().enumerate() {
            *slot = into_box(&self.settings, control(k, &state));
            state = self.dynamics.next(&state, slot);
        }
    }

    /// As [`Self::guess_by_policy`], but keeps the present guess unless the new one costs less than
    /// `keep_below` times as much, violated inequalities included.
    ///
    /// Returns whether the guess was replaced.
    pub fn guess_by_cheaper_policy(
        &mut self,
        start: &[f64; NX],
        reference: &[f64; NX],
        keep_below: f64,
        mut control: impl FnMut(usize, &[f64; NX]) -> [f64; NU],
    ) -> bool {
        let mut state = *start;
        for (k, slot) in self.trial_controls.iter_mut().enumerate() {
            *slot = into_box(&self.settings, control(k, &state));
            state = self.dynamics.next(&state, slot);
        }
        roll_out(&self.dynamics, start, &self.trial_controls, &mut self.trial_states);
        let (new, violated) = self.measure_trial(reference);
        let new = new + self.violation_weight * violated.sum;
        roll_out(&self.dynamics, start, &self.controls, &mut self.states);
        let (present, violated) = self.measure(reference);
        let present = present + self.violation_weight * violated.sum;
        let replace = new < keep_below * present;
        if replace {
            self.controls.copy_from_slice(&self.trial_controls);
        }
        replace
    }

    /// Puts controls back that stood after an earlier solve from the same start; more or fewer than steps are ignored.
    pub fn restore(&mut self, controls: &[[f64; NU]]) {
        for (slot, control) in self.controls.iter_mut().zip(controls) {
            *slot = into_box(&self.settings, *control);
        }
        let start = self.states[0];
        roll_out(&self.dynamics, &start, &self.controls, &mut self.states);
    }

    /// Moves the guess `steps` into the future; the last control is held.
    ///
    /// Controls are constant within a step, so a fraction of a step mixes neighbours.
    pub fn shift_guess(&mut self, steps: f64) {
        if !(steps.is_finite() && steps > 0.0) {
            return;
        }
        let last = self.controls.len() - 1;
        let whole = (steps.min(last as f64 + 1.0)) as usize;
        let part = (steps - whole as f64).clamp(0.0, 1.0);
        for k in 0..=last {
            let (from, to) = (self.controls[(k + whole).min(last)], self.controls[(k + whole + 1).min(last)]);
            self.controls[k] = std::array::from_fn(|j| (1.0 - part) * from[j] + part * to[j]);
        }
    }

    /// Improves the controls for a start and a reference, both in the state's units.
    ///
    /// # Errors
    /// [`SqpError::NonFinite`]; the controls are then left as they were.
    pub fn solve(&mut self, start: &[f64; NX], reference: &[f64; NX]) -> Result<SqpReport, SqpError> {
        for (quantity, values) in [("the start state", start), ("the reference state", reference)] {
            if !values.iter().all(|value| value.is_finite()) {
                return Err(SqpError::NonFinite { quantity });
            }
        }
        roll_out(&self.dynamics, start, &self.controls, &mut self.states);
        let (guess_cost, violated) = self.measure(reference);
        if !guess_cost.is_finite() {
            return Err(SqpError::NonFinite { quantity: "the cost" });
        }
        if !violated.sum.is_finite() {
            return Err(SqpError::NonFinite { quantity: "an inequality" });
        }
        self.multipliers.fill(0.0);
        let mut report = SqpReport {
            status: SqpStatus::IterationLimit,
            iterations: 0,
            qp_iterations: 0,
            cost: guess_cost,
            guess_cost,
            violation: violated.sum,
            smallest_row: violated.smallest,
        };
        while report.iterations < self.settings.iteration_limit {
            report.iterations += 1;
            if let Some(status) = self.iterate(start, reference, &mut report) {
                report.status = status;
                break;
            }
        }
        Ok(report)
    }

    /// `J` and the inequalities of the trajectory that stands.
    fn measure(&mut self, reference: &[f64; NX]) -> (f64, Violation) {
        let (states, controls) = (&self.states, &self.controls);
        (
            cost(&self.settings.weights, states, controls, reference),
            violation(&mut self.constraints, states, controls, &mut self.row_values),
        )
    }

    /// The same of the trajectory under trial.
    fn measure_trial(&mut self, reference: &[f64; NX]) -> (f64, Violation) {
        let (states, controls) = (&self.trial_states, &self.trial_controls);
        (
            cost(&self.settings.weights, states, controls, reference),
            violation(&mut self.constraints, states, controls, &mut self.row_values),
        )
    }

    /// One QP and one line search. `None` to go on.
    fn iterate(
        &mut self,
        start: &[f64; NX],
        reference: &[f64; NX],
        report: &mut SqpReport,
    ) -> Option<SqpStatus> {
        let weight = self.violation_weight;
        linearise_constraints(&mut self.constraints, &self.states, &self.controls, &mut self.rows);
        let around = (self.states.as_slice(), self.controls.as_slice());
        let rows = (self.rows.as_slice(), self.multipliers.as_slice());
        expand(&self.dynamics, &self.settings, around, reference, rows, &mut self.stages);
        let answer = self.qp.solve(&self.stages, &self.rows, &mut self.multipliers);
        report.qp_iterations += answer.iterations;
        let steps = self.stages.len();
        let Some(change) = answer.change else {
            return Some(SqpStatus::QpFailed);
        };
        let promised_violation = predicted_violation(&self.rows, steps, change);
        let slope = 2.0 * directional_derivative(&self.stages, change)
            + weight * (promised_violation - report.violation);
        let largest = change
            .chunks_exact(NU + NX)
            .take(steps)
            .flat_map(|stage| &stage[..NU])
            .fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let merit = report.cost + weight * report.violation;
        if largest <= self.settings.step_tolerance || -slope <= RELATIVE_DECREASE * merit {
            return Some(SqpStatus::Converged);
        }
        let promised_merit = merit + slope + curvature(&self.stages, change);
        let mut length = 1.0;
        for _ in 0..=HALVING_LIMIT {
            for (k, trial) in self.trial_controls.iter_mut().enumerate() {
                let delta = &change[k * (NU + NX)..];
                let moved = std::array::from_fn(|j| self.controls[k][j] + length * delta[j]);
                // The QP keeps the box up to its tolerance; the robot must not see the rest.
                *trial = into_box(&self.settings, moved);
            }
            roll_out(&self.dynamics, start, &self.trial_controls, &mut self.trial_states);
            let trial_cost =
                cost(&self.settings.weights, &self.trial_states, &self.trial_controls, reference);
            let (states, controls) = (&self.trial_states, &self.trial_controls);
            let violated = violation(&mut self.constraints, states, controls, &mut self.row_values);
            let trial_merit = trial_cost + weight * violated.sum;
            if trial_merit <= merit + SUFFICIENT_DECREASE * length * slope {
                std::mem::swap(&mut self.controls, &mut self.trial_controls);
                std::mem::swap(&mut self.states, &mut self.trial_states);
                report.cost = trial_cost;
                report.violation = violated.sum;
                report.smallest_row = violated.smallest;
                let as_promised = (trial_merit - promised_merit).abs() <= MODEL_ERROR * trial_merit;
                return (length == 1.0 && as_promised).then_some(SqpStatus::Converged);
            }
            length *= 0.5;
        }
        Some(SqpStatus::NoDescent)
    }
}

fn into_box<const NX: usize, const NU: usize>(
    settings: &SqpSettings<NX, NU>,
    control: [f64; NU],
) -> [f64; NU] {
    std::array::from_fn(|j| control[j].clamp(settings.control_min[j], settings.control_max[j]))
}
