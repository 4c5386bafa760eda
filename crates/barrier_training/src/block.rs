//! One block of samples through the network: loss of the value and its parameter gradient; and values with input
//! gradients for verification.
//!
//! A block is what one task computes between two reductions. Not here: which samples, and what is done with the
//! gradient.

// As in `sine`: vector code must melt into the function that enabled the instruction set.
#![allow(clippy::inline_always)]

use crate::features::{encode, state_gradient};
use crate::network::MOST_INPUTS;
use crate::packed::{Packed, TILE};
use crate::panel::{BLOCK, BLOCK_PANELS, Lanes, PANEL, at, at_mut, groups};
use crate::pass::{
    ACTIVATION_ROWS, Carry, SLOPE_ROWS, Share, Workspace, backward, by_input, forward, parameter_gradient,
    softplus,
};
use bytemuck::{cast_slice, cast_slice_mut};
use pulp::{Simd, WithSimd};
use settings::Encoding;

/// Rows of one sample panel: inputs of the network, target residual, weights of an over- and an under-estimated value.
pub(crate) const SAMPLE_ROWS: usize = MOST_INPUTS + 3;
/// Lane groups of one block of samples.
pub(crate) const SAMPLE_BLOCK: usize = groups(SAMPLE_ROWS) * BLOCK_PANELS;
/// Row of the target residual, m.
pub(crate) const TARGET_ROW: usize = MOST_INPUTS;
/// Row of the factor on the loss where the residual is under-estimated (the value over-estimated).
pub(crate) const OVERESTIMATE_ROW: usize = MOST_INPUTS + 1;
/// Row of the factor on the loss where the residual is over-estimated (the value under-estimated).
pub(crate) const UNDERESTIMATE_ROW: usize = MOST_INPUTS + 2;

/// Loss over one prediction: `δ²·(sqrt(1 + (e/δ)²) - 1)`, quadratic for errors well below `huber_m` and linear above.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Loss {
    /// δ, m.
    pub(crate) huber_m: f32,
    /// Factor on every sample: one over the batch size.
    pub(crate) scale: f32,
}

/// Loss and parameter gradient of one block, into its [`Share`].
pub(crate) struct BlockGradient<'a> {
    pub(crate) packed: &'a Packed,
    /// [`SAMPLE_BLOCK`] groups: [`BLOCK_PANELS`] panels of [`SAMPLE_ROWS`] rows.
    pub(crate) samples: &'a [Lanes],
    pub(crate) loss: Loss,
    pub(crate) workspace: &'a mut Workspace,
    pub(crate) share: &'a mut Share,
}

impl WithSimd for BlockGradient<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<V: Simd>(self, simd: V) {
        let Self { packed, samples, loss, workspace, share } = self;
        share.loss = 0.0;
        let panels = workspace.activations.chunks_exact_mut(groups(ACTIVATION_ROWS));
        let panels = panels.zip(workspace.slopes.chunks_exact_mut(groups(SLOPE_ROWS)));
        for ((a, s), samples) in panels.zip(samples.chunks_exact(groups(SAMPLE_ROWS))) {
            a[..groups(MOST_INPUTS)].copy_from_slice(&samples[..groups(MOST_INPUTS)]);
            forward::<V>(simd, packed, Carry::Values, cast_slice_mut(a), cast_slice_mut(s));
            share.loss += output_slopes(loss, samples, s);
            backward(simd, packed, cast_slice_mut(s));
        }
        parameter_gradient(simd, packed, workspace, BLOCK_PANELS, &mut share.gradient);
    }
}

/// Replaces the last pre-activation by the derivative of the loss; returns the panel's part of the loss.
fn output_slopes(loss: Loss, samples: &[Lanes], slopes: &mut [Lanes]) -> f64 {
    let mut sum = 0.0;
    for i in 0..PANEL {
        let z = at_mut(slopes, SLOPE_ROWS - 1, i);
        let (residual, slope) = softplus(*z);
        let error = residual - at(samples, TARGET_ROW, i);
        let weight = at(samples, if error < 0.0 { OVERESTIMATE_ROW } else { UNDERESTIMATE_ROW }, i);
        let ratio = error / loss.huber_m;
        let root = (1.0 + ratio * ratio).sqrt();
        *z = weight * error / root * slope * loss.scale;
        // (root - 1) without the cancellation.
        sum += f64::from(weight * error * error / (root + 1.0) * loss.scale);
    }
    sum
}

/// Residual and its gradient by the relative state for up to [`BLOCK`] states.
pub(crate) struct BlockEvaluation<'a> {
    pub(crate) packed: &'a Packed,
    pub(crate) encoding: Encoding,
    pub(crate) states: &'a [[f32; 4]],
    /// `[r, ∂r/∂z]` per state.
    pub(crate) out: &'a mut [(f32, [f32; 4])],
    pub(crate) workspace: &'a mut Workspace,
}

impl WithSimd for BlockEvaluation<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<V: Simd>(self, simd: V) {
        debug_assert!(self.states.len() <= BLOCK);
        let a = &mut self.workspace.activations[..groups(ACTIVATION_ROWS)];
        let s = &mut self.workspace.slopes[..groups(SLOPE_ROWS)];
        for (states, out) in self.states.chunks(PANEL).zip(self.out.chunks_mut(PANEL)) {
            for (i, state) in states.iter().enumerate() {
                put_inputs(a, i, &encode(self.encoding, state));
            }
            forward::<V>(simd, self.packed, Carry::Values, cast_slice_mut(a), cast_slice_mut(s));
            for (i, out) in out.iter_mut().enumerate() {
                let z = at_mut(s, SLOPE_ROWS - 1, i);
                (out.0, *z) = softplus(*z);
            }
            backward::<V>(simd, self.packed, cast_slice_mut(s));
            let mut gradient = [Lanes::ZERO; groups(TILE)];
            by_input::<V>(simd, self.packed, cast_slice(s), cast_slice_mut(&mut gradient));
            for (i, out) in out.iter_mut().enumerate() {
                out.1 = state_gradient(self.encoding, &inputs(a, i), &inputs(&gradient, i));
            }
        }
    }
}

/// Writes the inputs of one sample.
pub(crate) fn put_inputs(panel: &mut [Lanes], sample: usize, inputs: &[f32; MOST_INPUTS]) {
    for (row, &input) in inputs.iter().enumerate() {
        *at_mut(panel, row, sample) = input;
    }
}

/// The first rows of one sample, one per input.
pub(crate) fn inputs(panel: &[Lanes], sample: usize) -> [f32; MOST_INPUTS] {
    core::array::from_fn(|row| at(panel, row, sample))
}

#[cfg(test)]
mod tests;
