//! One block of states through the barrier condition: its hinge loss and parameter gradient.
//!
//! With `h = ℓ - r_Θ` and the worst admissible inputs at the current gradient, the condition is
//! `C = ∇h·ζ + α·h = (∇ℓ·ζ + α·ℓ) - (ṙ + α·r)`, where `ṙ` is the rate of the network's output along `ζ`. By the envelope
//! theorem the inputs may be held while differentiating. So one more way forward carries the rates, and the way back
//! runs through both: with `a` a pre-activation, `x = sin a` and bars for derivatives of the loss,
//! `ā = x̄·cos a - x̄̇·sin a·ȧ` and `ā̇ = x̄̇·cos a`.
//!
//! Not here: which states (`condition`).

// As in `sine`: vector code must melt into the function that enabled the instruction set.
#![allow(clippy::inline_always)]

use crate::block::{inputs, put_inputs};
use crate::features::{encode, input_rate, state_gradient};
use crate::kernel::{dense_tile, vectors};
use crate::network::{LAYERS, OUTPUTS};
use crate::packed::{Packed, TILE};
use crate::panel::{BLOCK_PANELS, Lanes, PANEL, at_mut, groups};
use crate::pass::{
    ACTIVATION_ROWS, Carry, SLOPE_ROWS, Share, Workspace, activation_row, backward, by_input, forward,
    parameter_gradient, slope_row, softplus,
};
use crate::residual_grid::failure_function;
use crate::worst_case::WorstCase;
use bytemuck::{cast_slice, cast_slice_mut};
use pulp::{Simd, WithSimd};
use settings::Encoding;

/// Panels of values; as many more hold the rates.
const VALUE_PANELS: usize = BLOCK_PANELS / 2;
/// States in one block.
pub(crate) const CONDITION_BLOCK: usize = VALUE_PANELS * PANEL;

/// What the condition is and how its violation counts.
#[derive(Clone, Copy)]
pub(crate) struct ConditionLoss<'a> {
    /// The game whose worst case counts.
    pub(crate) game: &'a dyn WorstCase,
    /// `R` of the failure function, m.
    pub(crate) failure_radius_m: f64,
    /// α, 1/s.
    pub(crate) alpha_per_s: f32,
    /// What `C` is asked to reach, m/s.
    pub(crate) margin_mps: f32,
    /// Where the loss turns from quadratic to linear, m/s.
    pub(crate) knee_mps: f32,
    /// Factor on every sample.
    pub(crate) scale: f32,
}

/// Loss and parameter gradient of one block, into its [`Share`].
pub(crate) struct BlockCondition<'a> {
    pub(crate) packed: &'a Packed,
    pub(crate) encoding: Encoding,
    /// [`CONDITION_BLOCK`] states.
    pub(crate) states: &'a [[f32; 4]],
    pub(crate) loss: ConditionLoss<'a>,
    pub(crate) workspace: &'a mut Workspace,
    pub(crate) share: &'a mut Share,
}

impl WithSimd for BlockCondition<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<V: Simd>(self, simd: V) {
        let Self { packed, encoding, states, loss, workspace, share } = self;
        share.loss = 0.0;
        let (a, a_rates) = workspace.activations.split_at_mut(groups(ACTIVATION_ROWS) * VALUE_PANELS);
        let (s, s_rates) = workspace.slopes.split_at_mut(groups(SLOPE_ROWS) * VALUE_PANELS);
        for (panel, states) in states.chunks_exact(PANEL).enumerate() {
            let (activations, slopes) = (panel * groups(ACTIVATION_ROWS), panel * groups(SLOPE_ROWS));
            let a = &mut a[activations..][..groups(ACTIVATION_ROWS)];
            let a_rates = &mut a_rates[activations..][..groups(ACTIVATION_ROWS)];
            let s = &mut s[slopes..][..groups(SLOPE_ROWS)];
            let s_rates = &mut s_rates[slopes..][..groups(SLOPE_ROWS)];
            let spare = &mut workspace.spare;

            for (i, state) in states.iter().enumerate() {
                put_inputs(a, i, &encode(encoding, state));
            }
            forward::<V>(simd, packed, Carry::Values, cast_slice_mut(a), cast_slice_mut(s));
            spare.copy_from_slice(s);
            for i in 0..PANEL {
                let z = at_mut(spare, SLOPE_ROWS - 1, i);
                *z = softplus(*z).1;
            }
            backward::<V>(simd, packed, cast_slice_mut(spare));
            let mut gradient = [Lanes::ZERO; groups(TILE)];
            by_input::<V>(simd, packed, cast_slice(spare), cast_slice_mut(&mut gradient));

            let mut base = [0.0; PANEL];
            for (i, state) in states.iter().enumerate() {
                let x = inputs(a, i);
                let slope = state_gradient(encoding, &x, &inputs(&gradient, i));
                let (flow, constant) = loss.worst_flow(state, &slope);
                put_inputs(a_rates, i, &input_rate(encoding, &x, &flow));
                base[i] = constant;
            }
            forward::<V>(
                simd,
                packed,
                Carry::Rates(cast_slice(s)),
                cast_slice_mut(a_rates),
                cast_slice_mut(s_rates),
            );
            share.loss += output_slopes(&loss, &base, s, s_rates);
            backward_through_rates::<V>(
                simd,
                packed,
                cast_slice(a),
                cast_slice_mut(s),
                cast_slice_mut(s_rates),
            );
        }
        parameter_gradient(simd, packed, workspace, VALUE_PANELS, &mut share.gradient);
    }
}

impl ConditionLoss<'_> {
    /// The relative motion `ζ` under the worst admissible inputs at `∇h = ∇ℓ - slope`, and `∇ℓ·ζ + α·ℓ`.
    fn worst_flow(&self, state: &[f32; 4], slope: &[f32; 4]) -> ([f32; 4], f32) {
        let z = state.map(f64::from);
        let failure = failure_function(&z, self.failure_radius_m);
        let distance = (failure + self.failure_radius_m).max(1e-6);
        let by_failure = [z[0] / distance, z[1] / distance];
        let mut gradient = slope.map(|s| -f64::from(s));
        gradient[0] += by_failure[0];
        gradient[1] += by_failure[1];
        let flow = self.game.flow(&z, &gradient);
        let rate = by_failure[0] * flow[0] + by_failure[1] * flow[1];
        (flow.map(|f| f as f32), (rate + f64::from(self.alpha_per_s) * failure) as f32)
    }

    /// Loss and its derivative by `C`.
    fn of(&self, condition: f32) -> (f32, f32) {
        let short = self.margin_mps - condition;
        if short <= 0.0 {
            (0.0, 0.0)
        } else if short < self.knee_mps {
            (0.5 * short * short * self.scale, -short * self.scale)
        } else {
            (self.knee_mps * (short - 0.5 * self.knee_mps) * self.scale, -self.knee_mps * self.scale)
        }
    }
}

/// Replaces the last pre-activations and their rates by the derivatives of the loss; returns the panel's part of it.
fn output_slopes(
    loss: &ConditionLoss<'_>,
    base: &[f32; PANEL],
    s: &mut [Lanes],
    s_rates: &mut [Lanes],
) -> f64 {
    let mut sum = 0.0;
    for i in 0..PANEL {
        let (value, rate) = (at_mut(s, SLOPE_ROWS - 1, i), at_mut(s_rates, SLOPE_ROWS - 1, i));
        let (residual, slope) = softplus(*value);
        let (part, by_condition) = loss.of(base[i] - slope * *rate - loss.alpha_per_s * residual);
        sum += f64::from(part);
        let (by_residual, by_rate) = (-loss.alpha_per_s * by_condition, -by_condition);
        *value = slope * (by_residual + by_rate * (1.0 - slope) * *rate);
        *rate = by_rate * slope;
    }
    sum
}

/// Turns the cosines and the rates of the pre-activations of one panel into derivatives of the loss by both.
#[inline(always)]
fn backward_through_rates<V: Simd>(
    simd: V,
    packed: &Packed,
    activations: &[V::f32s],
    slopes: &mut [V::f32s],
    rates: &mut [V::f32s],
) {
    let row = vectors::<V>();
    for layer in (1..LAYERS).rev() {
        let (input, output) = (packed.shape.input(layer), OUTPUTS[layer]);
        let (lower, upper) = slopes.split_at_mut(slope_row(layer) * row);
        let (lower_rates, upper_rates) = rates.split_at_mut(slope_row(layer) * row);
        let own = slope_row(layer - 1) * row;
        let (lower, lower_rates) = (&mut lower[own..], &mut lower_rates[own..]);
        let (upper, upper_rates) = (&upper[..output * row], &upper_rates[..output * row]);
        let sines = &activations[activation_row(layer) * row..][..input * row];
        let weights = &packed.backward[packed.shape.offset(layer)..][..input * output];
        for first in (0..input).step_by(TILE) {
            for pair in 0..row / 2 {
                let tile = &weights[first * output..(first + TILE) * output];
                let by_sine = dense_tile::<V, TILE>(simd, tile, &[0.0; TILE], upper, pair);
                let by_rate = dense_tile::<V, TILE>(simd, tile, &[0.0; TILE], upper_rates, pair);
                for j in 0..TILE {
                    for i in 0..2 {
                        let at = (first + j) * row + 2 * pair + i;
                        let (cosine, rate) = (lower[at], lower_rates[at]);
                        let turned = simd.mul_f32s(simd.mul_f32s(by_rate[j][i], sines[at]), rate);
                        lower[at] = simd.sub_f32s(simd.mul_f32s(by_sine[j][i], cosine), turned);
                        lower_rates[at] = simd.mul_f32s(by_rate[j][i], cosine);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
