//! Cost, constraints and dynamics along one trajectory, and their expansion to a QP. Not here: how far to go along what
//! the QP answers (`sqp`).

use crate::constraints::{ConstraintRow, StageConstraints, StepPoint};
use crate::dynamics::DiscreteDynamics;
use crate::sqp_settings::{QuadraticWeights, SqpSettings};
use crate::trajectory_qp::Stage;

/// `x_0 = start`, `x_{k+1} = f(x_k, u_k)`.
pub(crate) fn roll_out<D: DiscreteDynamics<NX, NU>, const NX: usize, const NU: usize>(
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
pub(crate) fn cost<const NX: usize, const NU: usize>(
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

fn point<const NX: usize, const NU: usize>(
    step: usize,
    states: &[[f64; NX]],
    controls: &[[f64; NU]],
) -> StepPoint<NX, NU> {
    StepPoint { step, state: states[step], control: controls[step], next: states[step + 1] }
}

/// How a trajectory stands to its inequalities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Violation {
    /// `Σ max(0, −g)`.
    pub(crate) sum: f64,
    /// `min g`; infinite without inequalities.
    pub(crate) smallest: f64,
}

/// Evaluates every inequality. `scratch` holds one step's values.
pub(crate) fn violation<C: StageConstraints<NX, NU>, const NX: usize, const NU: usize>(
    constraints: &mut C,
    states: &[[f64; NX]],
    controls: &[[f64; NU]],
    scratch: &mut [f64],
) -> Violation {
    let mut violation = Violation { sum: 0.0, smallest: f64::INFINITY };
    if scratch.is_empty() {
        return violation;
    }
    for step in 0..controls.len() {
        constraints.values(&point(step, states, controls), scratch);
        for &value in scratch.iter() {
            violation.sum += (-value).max(0.0);
            violation.smallest = violation.smallest.min(value);
            if value.is_nan() {
                return Violation { sum: f64::NAN, smallest: f64::NAN };
            }
        }
    }
    violation
}

/// Linearises every inequality; `rows` lie step by step.
pub(crate) fn linearise_constraints<C: StageConstraints<NX, NU>, const NX: usize, const NU: usize>(
    constraints: &mut C,
    states: &[[f64; NX]],
    controls: &[[f64; NU]],
    rows: &mut [ConstraintRow<NX, NU>],
) {
    let per_step = rows.len() / controls.len();
    if per_step > 0 {
        for (step, rows) in rows.chunks_exact_mut(per_step).enumerate() {
            constraints.linearise(&point(step, states, controls), rows);
        }
    }
}

/// Expands cost, dynamics and bounds to the QP around a trajectory, last stage first.
///
/// `rows` are the linearised inequalities and `multipliers` what the last QP said of them: they bend the Lagrangian as
/// the cost does.
pub(crate) fn expand<D: DiscreteDynamics<NX, NU>, const NX: usize, const NU: usize>(
    dynamics: &D,
    settings: &SqpSettings<NX, NU>,
    (states, controls): (&[[f64; NX]], &[[f64; NU]]),
    reference: &[f64; NX],
    (rows, multipliers): (&[ConstraintRow<NX, NU>], &[f64]),
    stages: &mut [Stage<NX, NU>],
) {
    let weights = &settings.weights;
    let last = stages.len() - 1;
    let per_step = rows.len() / stages.len();
    // λ_{k+1} = (half the gradient of the Lagrangian) + A_{k+1}ᵀ λ_{k+2}; `curvature` belongs to the state it bends.
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
        for m in k * per_step..(k + 1) * per_step {
            for i in 0..NX {
                costate[i] -= multipliers[m] * rows[m].by_next[i];
                if k < last {
                    costate[i] -= multipliers[m + per_step] * rows[m + per_step].by_state[i];
                }
            }
        }
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
pub(crate) fn curvature<const NX: usize, const NU: usize>(stages: &[Stage<NX, NU>], change: &[f64]) -> f64 {
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
pub(crate) fn directional_derivative<const NX: usize, const NU: usize>(
    stages: &[Stage<NX, NU>],
    change: &[f64],
) -> f64 {
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

/// `Σ max(0, −g)` that the linearised inequalities predict after a change.
pub(crate) fn predicted_violation<const NX: usize, const NU: usize>(
    rows: &[ConstraintRow<NX, NU>],
    steps: usize,
    change: &[f64],
) -> f64 {
    let per_step = rows.len() / steps;
    let mut sum = 0.0;
    for (index, row) in rows.iter().enumerate() {
        let k = index / per_step;
        let own = &change[k * (NU + NX)..(k + 1) * (NU + NX)];
        let state = (k > 0).then(|| &change[(k - 1) * (NU + NX) + NU..k * (NU + NX)]);
        sum += (-row.after(state, &own[..NU], &own[NU..])).max(0.0);
    }
    sum
}
