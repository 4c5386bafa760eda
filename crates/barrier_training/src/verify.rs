//! Measures a fit: errors of the value against known values, misjudged states, the seam, the barrier condition.
//!
//! Not here: bounds over the states between those looked at (crate `verification`).

use crate::block::BlockEvaluation;
use crate::judge::Judge;
use crate::network::{FittedNetwork, Shape};
use crate::packed::Packed;
use crate::panel::BLOCK;
use crate::pass::Workspace;
use crate::report::{ConditionReport, ErrorSummary, FitError};
use crate::residual_grid::failure_function;
use crate::worst_case::WorstCase;
use pulp::Arch;
use rayon::prelude::*;

/// Band about the zero level in which errors are summarised apart, m.
const NEAR_ZERO_M: f64 = 0.2;
/// Half-width of the band about the zero level in which the barrier condition is counted apart, m.
const BOUNDARY_M: f64 = 0.05;

/// Residual `r_Θ` and `∂r_Θ/∂z` at each of `states`.
pub fn evaluate(network: &FittedNetwork, states: &[[f32; 4]]) -> Vec<(f32, [f32; 4])> {
    let encoding = network.encoding;
    let mut packed = Packed::new(Shape::of(encoding));
    packed.fill(&network.parameters);
    let arch = Arch::new();
    let mut out = vec![(0.0, [0.0; 4]); states.len()];
    let chunks = states.par_chunks(BLOCK).zip(out.par_chunks_mut(BLOCK));
    chunks.for_each_init(Workspace::new, |workspace, (states, out)| {
        arch.dispatch(BlockEvaluation { packed: &packed, encoding, states, out, workspace });
    });
    out
}

/// Errors of the network against the values of `judge`, outside the failure set.
pub fn fit_error(judge: &Judge, network: &FittedNetwork) -> FitError {
    let states: Vec<[f32; 4]> = judge.states.iter().map(|z| z.map(|c| c as f32)).collect();
    let fitted = evaluate(network, &states);
    let (mut outside, mut near_zero) = (Vec::new(), Vec::new());
    let (mut unsafe_states, mut safe_states, mut false_safe, mut false_unsafe) =
        (0_usize, 0_usize, 0_usize, 0_usize);
    let mut worst = 0.0_f64;
    for ((state, &value), &(residual, _)) in judge.states.iter().zip(&judge.value_m).zip(&fitted) {
        let failure = failure_function(state, judge.failure_radius_m);
        if failure <= 0.0 {
            continue;
        }
        let fit = failure - f64::from(residual);
        outside.push(fit - value);
        if value.abs() < NEAR_ZERO_M {
            near_zero.push(fit - value);
        }
        if value < 0.0 {
            unsafe_states += 1;
            if fit >= 0.0 {
                false_safe += 1;
                worst = worst.min(value);
            }
        } else {
            safe_states += 1;
            false_unsafe += usize::from(fit < 0.0);
        }
    }
    let (seam_mean_m, seam_max_m) = seam(judge, network);
    FitError {
        outside: summary(outside),
        near_zero: summary(near_zero),
        false_safe_share: share(false_safe, unsafe_states),
        false_safe_worst_m: worst,
        false_unsafe_share: share(false_unsafe, safe_states),
        seam_mean_m,
        seam_max_m,
    }
}

/// `∇h·ζ + α·h` at `z` for `h = ℓ - r` with residual `residual` m and `∂r/∂z = slope`, under the worst admissible inputs of
/// `game`, m/s.
pub(crate) fn condition_at(
    z: &[f64; 4],
    residual: f32,
    slope: &[f32; 4],
    failure_radius_m: f64,
    game: &dyn WorstCase,
    alpha_per_s: f64,
) -> f64 {
    let failure = failure_function(z, failure_radius_m);
    let distance = (failure + failure_radius_m).max(1e-6);
    let mut gradient = slope.map(|s| -f64::from(s));
    gradient[0] += z[0] / distance;
    gradient[1] += z[1] / distance;
    let flow = game.flow(z, &gradient);
    let rate: f64 = (0..4).map(|k| gradient[k] * flow[k]).sum();
    rate + alpha_per_s * (failure - f64::from(residual))
}

/// How well `h = ℓ - r_Θ` meets `max_u min_d ∇h·ζ + α·h ≥ 0` under the inputs of `game`, at those of `states` outside the
/// failure set.
pub fn barrier_condition(
    states: &[[f64; 4]],
    network: &FittedNetwork,
    failure_radius_m: f64,
    game: &dyn WorstCase,
    alpha_per_s: f64,
) -> ConditionReport {
    let inputs: Vec<[f32; 4]> = states.iter().map(|z| z.map(|c| c as f32)).collect();
    let fitted = evaluate(network, &inputs);
    // Counted: all, safe, safe and near, near on either side; of each the states and the violations.
    let mut counts = [[0_usize; 2]; 3];
    let mut worst = f64::INFINITY;
    for (z, (residual, slope)) in inputs.iter().zip(&fitted) {
        let z = z.map(f64::from);
        let failure = failure_function(&z, failure_radius_m);
        let h = failure - f64::from(*residual);
        if failure <= 0.0 || h < -BOUNDARY_M {
            continue;
        }
        let condition = condition_at(&z, *residual, slope, failure_radius_m, game, alpha_per_s);
        let member = [h >= 0.0, (0.0..BOUNDARY_M).contains(&h), h < BOUNDARY_M];
        for (count, member) in counts.iter_mut().zip(member) {
            count[0] += usize::from(member);
            count[1] += usize::from(member && condition < 0.0);
        }
        if h >= 0.0 {
            worst = worst.min(condition);
        }
    }
    let shares = counts.map(|[all, violated]| share(violated, all));
    ConditionReport {
        alpha_per_s,
        states: counts[0][0],
        violated_share: shares[0],
        violated_near_zero_share: shares[1],
        violated_band_share: shares[2],
        worst_mps: worst,
    }
}

/// Mean and largest `|r(.., max, ..) - r(.., min, ..)|` along the periodic axes, outside the failure set.
fn seam(judge: &Judge, network: &FittedNetwork) -> (f64, f64) {
    let mut ends: [Vec<[f32; 4]>; 2] = [Vec::new(), Vec::new()];
    for state in &judge.states {
        if failure_function(state, judge.failure_radius_m) <= 0.0 {
            continue;
        }
        for (k, axis) in judge.axes.iter().enumerate() {
            // A grid has the same state at each of its nodes along the axis: one of them is enough.
            let again = judge.on_grid && state[k] != axis.min;
            if axis.periodic && !again {
                let (mut lower, mut upper) = (*state, *state);
                (lower[k], upper[k]) = (axis.min, axis.max);
                ends[0].push(lower.map(|c| c as f32));
                ends[1].push(upper.map(|c| c as f32));
            }
        }
    }
    let (lower, upper) = (evaluate(network, &ends[0]), evaluate(network, &ends[1]));
    let jumps = lower.iter().zip(&upper).map(|(a, b)| f64::from((a.0 - b.0).abs()));
    let (sum, max) = jumps.fold((0.0, 0.0_f64), |(sum, max), jump| (sum + jump, max.max(jump)));
    (sum / lower.len().max(1) as f64, max)
}

fn summary(errors: Vec<f64>) -> ErrorSummary {
    let states = errors.len();
    let bias_m = errors.iter().sum::<f64>() / states.max(1) as f64;
    let mut size: Vec<f64> = errors.into_iter().map(f64::abs).collect();
    size.sort_by(f64::total_cmp);
    let quantile = |q: f64| size.get(((states.max(1) - 1) as f64 * q) as usize).copied().unwrap_or(0.0);
    ErrorSummary {
        states,
        bias_m,
        mean_m: size.iter().sum::<f64>() / states.max(1) as f64,
        p99_m: quantile(0.99),
        max_m: quantile(1.0),
    }
}

fn share(part: usize, whole: usize) -> f64 {
    part as f64 / whole.max(1) as f64
}
