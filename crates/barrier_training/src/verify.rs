//! Measures a fit against its grid: errors of the value, misjudged states, the seam, the barrier condition.
//!
//! Not here: bounds over the states between the nodes.

use crate::block::{BlockEvaluation, Workspace};
use crate::packed::Packed;
use crate::panel::BLOCK;
use crate::report::{ConditionReport, ErrorSummary, FitError};
use crate::residual_grid::{ResidualGrid, failure_function};
use dynamics::RelativeDynamics;
use pulp::Arch;
use rayon::prelude::*;

/// Band about the zero level in which errors are summarised apart, m.
const NEAR_ZERO_M: f64 = 0.2;
/// Band above the zero level in which the barrier condition is counted apart, m.
const BOUNDARY_M: f64 = 0.05;

/// Residual `r_Θ` and `∂r_Θ/∂z` at each of `states`, with `parameters` in the layout of [`crate::network`].
pub fn evaluate(parameters: &[f32], states: &[[f32; 4]]) -> Vec<(f32, [f32; 4])> {
    let mut packed = Packed::new();
    packed.fill(parameters);
    let arch = Arch::new();
    let mut out = vec![(0.0, [0.0; 4]); states.len()];
    let chunks = states.par_chunks(BLOCK).zip(out.par_chunks_mut(BLOCK));
    chunks.for_each_init(Workspace::new, |workspace, (states, out)| {
        arch.dispatch(BlockEvaluation { packed: &packed, states, out, workspace });
    });
    out
}

fn node_states(target: &ResidualGrid) -> Vec<[f32; 4]> {
    (0..target.node_count()).map(|index| target.state(index).map(|c| c as f32)).collect()
}

/// Errors of the network against `target` at its nodes.
pub fn fit_error(target: &ResidualGrid, parameters: &[f32]) -> FitError {
    let fitted = evaluate(parameters, &node_states(target));
    let (mut outside, mut near_zero) = (Vec::new(), Vec::new());
    let (mut unsafe_nodes, mut safe_nodes, mut false_safe, mut false_unsafe) =
        (0_usize, 0_usize, 0_usize, 0_usize);
    let mut worst = 0.0_f64;
    for (index, &(residual, _)) in fitted.iter().enumerate() {
        let failure = failure_function(&target.state(index), target.failure_radius_m());
        if failure <= 0.0 {
            continue;
        }
        let (value, fit) = (target.value_m(index), failure - f64::from(residual));
        outside.push(fit - value);
        if value.abs() < NEAR_ZERO_M {
            near_zero.push(fit - value);
        }
        if value < 0.0 {
            unsafe_nodes += 1;
            if fit >= 0.0 {
                false_safe += 1;
                worst = worst.min(value);
            }
        } else {
            safe_nodes += 1;
            false_unsafe += usize::from(fit < 0.0);
        }
    }
    let (seam_mean_m, seam_max_m) = seam(target, parameters);
    FitError {
        outside: summary(outside),
        near_zero: summary(near_zero),
        false_safe_share: share(false_safe, unsafe_nodes),
        false_safe_worst_m: worst,
        false_unsafe_share: share(false_unsafe, safe_nodes),
        seam_mean_m,
        seam_max_m,
    }
}

/// How well `V_Θ = ℓ - r_Θ` meets `max_u min_d ∇V_Θ·ż + α V_Θ ≥ 0` where `V_Θ ≥ 0` outside the failure set, with the
/// inputs and disturbances of `dynamics`.
pub fn barrier_condition<const NU: usize, const ND: usize>(
    target: &ResidualGrid,
    parameters: &[f32],
    dynamics: &impl RelativeDynamics<4, NU, ND>,
    alpha_per_s: f64,
) -> ConditionReport {
    let fitted = evaluate(parameters, &node_states(target));
    let (mut nodes, mut violated, mut boundary, mut violated_boundary) = (0_usize, 0_usize, 0_usize, 0_usize);
    let mut worst = f64::INFINITY;
    for (index, &(residual, slope)) in fitted.iter().enumerate() {
        let state = target.state(index);
        let failure = failure_function(&state, target.failure_radius_m());
        let value = failure - f64::from(residual);
        if value < 0.0 {
            continue;
        }
        let mut gradient = slope.map(|s| -f64::from(s));
        let distance = failure + target.failure_radius_m();
        gradient[0] += state[0] / distance;
        gradient[1] += state[1] / distance;
        let condition = dynamics.hamiltonian(&state, &gradient) + alpha_per_s * value;
        let near = value < BOUNDARY_M;
        nodes += 1;
        violated += usize::from(condition < 0.0);
        boundary += usize::from(near);
        violated_boundary += usize::from(near && condition < 0.0);
        worst = worst.min(condition);
    }
    ConditionReport {
        alpha_per_s,
        nodes,
        violated_share: share(violated, nodes),
        violated_near_zero_share: share(violated_boundary, boundary),
        worst_mps: worst,
    }
}

/// Mean and largest `|r(.., max, ..) - r(.., min, ..)|` over the nodes of the other axes, outside the failure set.
fn seam(target: &ResidualGrid, parameters: &[f32]) -> (f64, f64) {
    let mut ends: [Vec<[f32; 4]>; 2] = [Vec::new(), Vec::new()];
    for index in 0..target.node_count() {
        let state = target.state(index);
        if failure_function(&state, target.failure_radius_m()) <= 0.0 {
            continue;
        }
        for (k, axis) in target.axes().iter().enumerate() {
            if axis.periodic && state[k] == axis.min {
                let (mut lower, mut upper) = (state, state);
                (lower[k], upper[k]) = (axis.min, axis.max);
                ends[0].push(lower.map(|c| c as f32));
                ends[1].push(upper.map(|c| c as f32));
            }
        }
    }
    let (lower, upper) = (evaluate(parameters, &ends[0]), evaluate(parameters, &ends[1]));
    let jumps = lower.iter().zip(&upper).map(|(a, b)| f64::from((a.0 - b.0).abs()));
    let (sum, max) = jumps.fold((0.0, 0.0_f64), |(sum, max), jump| (sum + jump, max.max(jump)));
    (sum / lower.len().max(1) as f64, max)
}

fn summary(errors: Vec<f64>) -> ErrorSummary {
    let nodes = errors.len();
    let bias_m = errors.iter().sum::<f64>() / nodes.max(1) as f64;
    let mut size: Vec<f64> = errors.into_iter().map(f64::abs).collect();
    size.sort_by(f64::total_cmp);
    let quantile = |q: f64| size.get(((nodes.max(1) - 1) as f64 * q) as usize).copied().unwrap_or(0.0);
    ErrorSummary {
        nodes,
        bias_m,
        mean_m: size.iter().sum::<f64>() / nodes.max(1) as f64,
        p99_m: quantile(0.99),
        max_m: quantile(1.0),
    }
}

fn share(part: usize, whole: usize) -> f64 {
    part as f64 / whole.max(1) as f64
}
