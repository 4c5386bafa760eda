//! Sequential quadratic programming along trajectories that always obey the dynamics.
//!
//! Each iteration linearises around the current trajectory, lets the QP choose a change of the controls, and rolls
//! the changed controls out through the true dynamics. So every iterate is feasible, the cost itself decides how
//! far to go, and whatever stops the search leaves usable controls behind.

use crate::dynamics::DiscreteDynamics;
use crate::sqp_settings::{QuadraticWeights, SqpSettings, SqpSetupError};
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

/// Box-constrained optimal control with quadratic cost around one reference state.
///
/// Minimises `J(u) = Σ_{k<N} (x_k−r)ᵀQ(x_k−r) + u_kᵀR u_k + (x_N−r)ᵀQ_N(x_N−r)` subject to
/// `x_{k+1} = f(x_k, u_k)` and `u_min ≤ u_k ≤ u_max`, from the controls left by the previous call.
///
/// Clarabel allocates while it solves; nothing else here does after construction.
pub struct Sqp<D, const NX: usize, const NU: usize> {
    dynamics: D,
    settings: SqpSettings<NX, NU>,
    qp: TrajectoryQp<NX, NU>,
    stages: Vec<Stage<NX, NU>>,
    /// `u_0 … u_{N−1}` and `x_0 … x_N` that stand.
    controls: Vec<[f64; NU]>,
    states: Vec<[f64; NX]>,
    /// The same, of the step under trial.
    trial_controls: Vec<[f64; NU]>,
    trial_states: Vec<[f64; NX]>,
}

impl<D: DiscreteDynamics<NX, NU>, const NX: usize, const NU: usize> Sqp<D, NX, NU> {
    /// Sets the problem up; the first guess is the middle of the input box.
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
        settings.validate()?;
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
        expand(&dynamics, &settings, &states, &controls, &[0.0; NX], &mut stages);
        let qp = TrajectoryQp::new(&stages, dynamics.sparsity())?;
        let (trial_controls, trial_states) = (controls.clone(), states.clone());
        Ok(Self { dynamics, settings, qp, stages, controls, states, trial_controls, trial_states })
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
    /// `keep_below` times as much.
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
        let weights = &self.settings.weights;
        roll_out(&self.dynamics, start, &self.trial_controls, &mut self.trial_states);
        let new = cost(weights, &self.trial_states, &self.trial_controls, reference);
        roll_out(&self.dynamics, start, &self.controls, &mut self.states);
        let present = cost(weights, &self.states, &self.controls, reference);
        let replace = new < keep_below * present;
        if replace {
            self.controls.copy_from_slice(&self.trial_controls);
        }
        replace
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
        let guess_cost = cost(&self.settings.weights, &self.states, &self.controls, reference);
        if !guess_cost.is_finite() {
            return Err(SqpError::NonFinite { quantity: "the cost" });
        }
        let mut report = SqpReport {
            status: SqpStatus::IterationLimit,
            iterations: 0,
            qp_iterations: 0,
            cost: guess_cost,
            guess_cost,
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

    /// One QP and one line search. `None` to go on.
    fn iterate(
        &mut self,
        start: &[f64; NX],
        reference: &[f64; NX],
        report: &mut SqpReport,
    ) -> Option<SqpStatus> {
        expand(&self.dynamics, &self.settings, &self.states, &self.controls, reference, &mut self.stages);
        let (change, qp_iterations) = self.qp.solve(&self.stages);
        report.qp_iterations += qp_iterations;
        let Some(change) = change else {
            return Some(SqpStatus::QpFailed);
        };
        let slope = 2.0 * directional_derivative(&self.stages, change);
        let largest = change
            .chunks_exact(NU + NX)
            .flat_map(|stage| &stage[..NU])
            .fold(0.0_f64, |largest, value| largest.max(value.abs()));
        if largest <= self.settings.step_tolerance || -slope <= RELATIVE_DECREASE * report.cost {
            return Some(SqpStatus::Converged);
        }
        let promised_cost = report.cost + slope + curvature(&self.stages, change);
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
            if trial_cost <= report.cost + SUFFICIENT_DECREASE * length * slope {
                std::mem::swap(&mut self.controls, &mut self.trial_controls);
                std::mem::swap(&mut self.states, &mut self.trial_states);
                report.cost = trial_cost;
                let as_promised = (trial_cost - promised_cost).abs() <= MODEL_ERROR * trial_cost;
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

/// `x_0 = start`, `x_{k+1} = f(x_k, u_k)`.
fn roll_out<D: DiscreteDynamics<NX, NU>, const NX: usize, const NU: usize>(
    dynamics: &D,
    start: &[f64; NX],
    controls: &[[f64; NU]],
    states: &mut [[f64; NX]],
) {
    states[0] = *start;
    for (k, control) in controls.iter().enumerate() {
        states[k + 1] = dynamics.next(&states[k], control);
    }
}

/// `J` of a trajectory.
fn cost<const NX: usize, const NU: usize>(
    weights: &QuadraticWeights<NX, NU>,
    states: &[[f64; NX]],
    controls: &[[f64; NU]],
    reference: &[f64; NX],
) -> f64 {
    let last = controls.len();
    let mut sum = 0.0;
    for (k, state) in states.iter().enumerate() {
        let weight = if k == last { &weights.terminal_state } else { &weights.stage_state };
        for i in 0..NX {
            sum += weight[i] * (state[i] - reference[i]).powi(2);
        }
    }
    for control in controls {
        for j in 0..NU {
            sum += weights.control[j] * control[j].powi(2);
        }
    }
    sum
}

/// Expands cost, dynamics and bounds to the QP around a trajectory, last stage first.
fn expand<D: DiscreteDynamics<NX, NU>, const NX: usize, const NU: usize>(
    dynamics: &D,
    settings: &SqpSettings<NX, NU>,
    states: &[[f64; NX]],
    controls: &[[f64; NU]],
    reference: &[f64; NX],
    stages: &mut [Stage<NX, NU>],
) {
    let weights = &settings.weights;
    let last = stages.len() - 1;
    // λ_{k+1} = (half the gradient of the cost) + A_{k+1}ᵀ λ_{k+2}; `curvature` belongs to the state it bends.
    let mut costate = [0.0; NX];
    let mut curvature = [0.0; NX];
    for k in (0..=last).rev() {
        let weight = if k == last { &weights.terminal_state } else { &weights.stage_state };
        let state_gradient: [f64; NX] =
            std::array::from_fn(|i| weight[i] * (states[k + 1][i] - reference[i]));
        let propagated: [f64; NX] = if k == last {
            [0.0; NX]
        } else {
            let by_state = &stages[k + 1].jacobians.by_state;
            std::array::from_fn(|i| (0..NX).map(|row| by_state[row][i] * costate[row]).sum())
        };
        costate = std::array::from_fn(|i| state_gradient[i] + propagated[i]);
        let control = &controls[k];
        stages[k] = Stage {
            jacobians: dynamics.linearise(&states[k], control),
            gradient: (std::array::from_fn(|j| weights.control[j] * control[j]), state_gradient),
            hessian: (weights.control, std::array::from_fn(|i| weight[i] + curvature[i])),
            to_upper: std::array::from_fn(|j| settings.control_max[j] - control[j]),
            to_lower: std::array::from_fn(|j| control[j] - settings.control_min[j]),
        };
        curvature = dynamics.curvature(&states[k], control, &costate);
    }
}

/// What a change along the linearised dynamics adds to the QP's cost beyond the slope.
fn curvature<const NX: usize, const NU: usize>(stages: &[Stage<NX, NU>], change: &[f64]) -> f64 {
    stages
        .iter()
        .zip(change.chunks_exact(NU + NX))
        .map(|(stage, delta)| {
            let control: f64 = (0..NU).map(|j| stage.hessian.0[j] * delta[j].powi(2)).sum();
            let state: f64 = (0..NX).map(|i| stage.hessian.1[i] * delta[NU + i].powi(2)).sum();
            control + state
        })
        .sum()
}

/// Half the derivative of the cost along a change that obeys the linearised dynamics.
fn directional_derivative<const NX: usize, const NU: usize>(stages: &[Stage<NX, NU>], change: &[f64]) -> f64 {
    stages
        .iter()
        .zip(change.chunks_exact(NU + NX))
        .map(|(stage, delta)| {
            let control: f64 = (0..NU).map(|j| stage.gradient.0[j] * delta[j]).sum();
            let state: f64 = (0..NX).map(|i| stage.gradient.1[i] * delta[NU + i]).sum();
            control + state
        })
        .sum()
}
