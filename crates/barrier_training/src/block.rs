//! One block of samples through the network: forward, loss, backward, parameter gradient; and values with input
//! gradients for verification.
//!
//! A block is what one task computes between two reductions. Not here: which samples, and what is done with the
//! gradient.

// As in `sine`: vector code must melt into the function that enabled the instruction set.
#![allow(clippy::inline_always)]

use crate::kernel::{Rows, dense_tile, outer_tile, row_sums, vectors};
use crate::network::{LAYERS, PARAMETERS, WIDTHS, bias_offset, offset};
use crate::packed::{Packed, TILE};
use crate::panel::{BLOCK, BLOCK_PANELS, Lanes, PANEL, at, at_mut, groups};
use bytemuck::cast_slice_mut;
use pulp::{Simd, WithSimd};

/// Rows of one sample panel: relative state (4), target residual, weight of an over-estimated value.
pub(crate) const SAMPLE_ROWS: usize = 6;
/// Lane groups of one block of samples.
pub(crate) const SAMPLE_BLOCK: usize = groups(SAMPLE_ROWS) * BLOCK_PANELS;
/// Row of the target residual, m.
pub(crate) const TARGET_ROW: usize = 4;
/// Row of the factor on the loss where the residual is under-estimated (the value over-estimated).
pub(crate) const OVERESTIMATE_ROW: usize = 5;

/// First row of the inputs of `layer` among the stored activations.
const fn activation_row(layer: usize) -> usize {
    let (mut sum, mut i) = (0, 0);
    while i < layer {
        sum += WIDTHS[i];
        i += 1;
    }
    sum
}
/// First row of the outputs of `layer` among the stored slopes.
const fn slope_row(layer: usize) -> usize {
    activation_row(layer + 1) - WIDTHS[0]
}
const ACTIVATION_ROWS: usize = activation_row(LAYERS);
const SLOPE_ROWS: usize = slope_row(LAYERS);

/// Loss over one prediction: `δ²·(sqrt(1 + (e/δ)²) - 1)`, quadratic for errors well below `huber_m` and linear above.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Loss {
    /// δ, m.
    pub(crate) huber_m: f32,
    /// Factor on every sample: one over the batch size.
    pub(crate) scale: f32,
}

/// Scratch of one thread. Allocated once, reused; what it holds between two calls does not matter.
#[derive(Debug, Clone)]
pub(crate) struct Workspace {
    /// Inputs of every layer.
    activations: Vec<Lanes>,
    /// Cosines on the way forward; derivative of the loss by each pre-activation after the way back.
    slopes: Vec<Lanes>,
}

/// What one block contributes to a step.
#[derive(Debug, Clone)]
pub(crate) struct Share {
    /// Gradient of the block's part of the loss, flat layout.
    pub(crate) gradient: Vec<f32>,
    /// The block's part of the loss.
    pub(crate) loss: f64,
}

impl Share {
    /// Nothing yet.
    pub(crate) fn new() -> Self {
        Self { gradient: vec![0.0; PARAMETERS], loss: 0.0 }
    }
}

impl Workspace {
    /// Room for one block.
    pub(crate) fn new() -> Self {
        Self {
            activations: vec![Lanes::ZERO; groups(ACTIVATION_ROWS) * BLOCK_PANELS],
            slopes: vec![Lanes::ZERO; groups(SLOPE_ROWS) * BLOCK_PANELS],
        }
    }
}

/// `softplus(x) = ln(1 + eˣ)` and its derivative, without overflow.
fn softplus(x: f32) -> (f32, f32) {
    let e = libm::expf(-x.abs());
    let slope = if x >= 0.0 { 1.0 / (1.0 + e) } else { e / (1.0 + e) };
    (x.max(0.0) + libm::log1pf(e), slope)
}

/// Fills activations and cosines of one panel, and the last pre-activation into the last slope row.
#[inline(always)]
fn forward<V: Simd>(simd: V, packed: &Packed, activations: &mut [V::f32s], slopes: &mut [V::f32s]) {
    let row = vectors::<V>();
    for layer in 0..LAYERS {
        let (input, output) = (WIDTHS[layer], WIDTHS[layer + 1]);
        let (below, above) = activations.split_at_mut((activation_row(layer) + input) * row);
        let below = &below[activation_row(layer) * row..];
        let slopes = &mut slopes[slope_row(layer) * row..][..output * row];
        let biases = &packed.parameters[bias_offset(layer)..][..output];
        let weights = &packed.forward[offset(layer)..][..input * output];
        if layer + 1 == LAYERS {
            for pair in 0..row / 2 {
                let z = dense_tile::<V, 1>(simd, weights, &[biases[0]], below, pair);
                slopes[2 * pair] = z[0][0];
                slopes[2 * pair + 1] = z[0][1];
            }
            continue;
        }
        let above = &mut above[..output * row];
        for first in (0..output).step_by(TILE) {
            let mut start = [0.0; TILE];
            start.copy_from_slice(&biases[first..first + TILE]);
            for pair in 0..row / 2 {
                let tile = &weights[first * input..(first + TILE) * input];
                let z = dense_tile::<V, TILE>(simd, tile, &start, below, pair);
                for j in 0..TILE {
                    for i in 0..2 {
                        let (sine, cosine) = crate::sine::sin_cos(simd, z[j][i]);
                        above[(first + j) * row + 2 * pair + i] = sine;
                        slopes[(first + j) * row + 2 * pair + i] = cosine;
                    }
                }
            }
        }
    }
}

/// Turns the cosines of one panel into derivatives by each pre-activation, from the last row downwards.
#[inline(always)]
fn backward<V: Simd>(simd: V, packed: &Packed, slopes: &mut [V::f32s]) {
    let row = vectors::<V>();
    for layer in (1..LAYERS).rev() {
        let (input, output) = (WIDTHS[layer], WIDTHS[layer + 1]);
        let (lower, upper) = slopes.split_at_mut(slope_row(layer) * row);
        let lower = &mut lower[slope_row(layer - 1) * row..];
        let upper = &upper[..output * row];
        let weights = &packed.backward[offset(layer)..][..input * output];
        for first in (0..input).step_by(TILE) {
            for pair in 0..row / 2 {
                let tile = &weights[first * output..(first + TILE) * output];
                let sum = dense_tile::<V, TILE>(simd, tile, &[0.0; TILE], upper, pair);
                for j in 0..TILE {
                    for i in 0..2 {
                        let slot = &mut lower[(first + j) * row + 2 * pair + i];
                        *slot = simd.mul_f32s(*slot, sum[j][i]);
                    }
                }
            }
        }
    }
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
        let Workspace { activations, slopes } = self.workspace;
        let Share { gradient, loss } = self.share;
        *loss = 0.0;
        let panels = activations.chunks_exact_mut(groups(ACTIVATION_ROWS));
        let panels = panels.zip(slopes.chunks_exact_mut(groups(SLOPE_ROWS)));
        for ((a, s), samples) in panels.zip(self.samples.chunks_exact(groups(SAMPLE_ROWS))) {
            a[..groups(WIDTHS[0])].copy_from_slice(&samples[..groups(WIDTHS[0])]);
            forward(simd, self.packed, cast_slice_mut(a), cast_slice_mut(s));
            *loss += output_slopes(self.loss, samples, s);
            backward(simd, self.packed, cast_slice_mut(s));
        }
        for layer in 0..LAYERS - 1 {
            parameter_gradient::<V, 3>(simd, layer, activations, slopes, gradient);
        }
        parameter_gradient::<V, 1>(simd, LAYERS - 1, activations, slopes, gradient);
    }
}

/// Replaces the last pre-activation by the derivative of the loss; returns the panel's part of the loss.
fn output_slopes(loss: Loss, samples: &[Lanes], slopes: &mut [Lanes]) -> f64 {
    let mut sum = 0.0;
    for i in 0..PANEL {
        let z = at_mut(slopes, SLOPE_ROWS - 1, i);
        let (residual, slope) = softplus(*z);
        let error = residual - at(samples, TARGET_ROW, i);
        let weight = if error < 0.0 { at(samples, OVERESTIMATE_ROW, i) } else { 1.0 };
        let ratio = error / loss.huber_m;
        let root = (1.0 + ratio * ratio).sqrt();
        *z = weight * error / root * slope * loss.scale;
        // (root - 1) without the cancellation.
        sum += f64::from(weight * error * error / (root + 1.0) * loss.scale);
    }
    sum
}

/// Gradient of one layer's weights and biases from the block's activations and slopes, in tiles of `J` rows by 4.
#[inline(always)]
fn parameter_gradient<V: Simd, const J: usize>(
    simd: V,
    layer: usize,
    activations: &[Lanes],
    slopes: &[Lanes],
    gradient: &mut [f32],
) {
    let (input, output) = (WIDTHS[layer], WIDTHS[layer + 1]);
    for j in (0..output).step_by(J) {
        let left = Rows { data: slopes, height: SLOPE_ROWS, first: slope_row(layer) + j };
        for k in (0..input).step_by(4) {
            let right = Rows { data: activations, height: ACTIVATION_ROWS, first: activation_row(layer) + k };
            let tile = outer_tile::<V, J, 4>(simd, left, right);
            for (row, values) in tile.iter().enumerate() {
                gradient[offset(layer) + (j + row) * input + k..][..4].copy_from_slice(values);
            }
        }
        gradient[bias_offset(layer) + j..][..J].copy_from_slice(&row_sums::<V, J>(simd, left));
    }
}

/// Residual and its gradient by the relative state for up to [`BLOCK`] states.
pub(crate) struct BlockEvaluation<'a> {
    pub(crate) packed: &'a Packed,
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
        let row = vectors::<V>();
        let a = &mut self.workspace.activations[..groups(ACTIVATION_ROWS)];
        let s = &mut self.workspace.slopes[..groups(SLOPE_ROWS)];
        for (states, out) in self.states.chunks(PANEL).zip(self.out.chunks_mut(PANEL)) {
            for (i, state) in states.iter().enumerate() {
                for (component, &value) in state.iter().enumerate() {
                    *at_mut(a, component, i) = value;
                }
            }
            forward(simd, self.packed, cast_slice_mut(a), cast_slice_mut(s));
            for (i, out) in out.iter_mut().enumerate() {
                let z = at_mut(s, SLOPE_ROWS - 1, i);
                (out.0, *z) = softplus(*z);
            }
            backward::<V>(simd, self.packed, cast_slice_mut(s));
            let mut input_gradient = [Lanes::ZERO; groups(WIDTHS[0])];
            let into: &mut [V::f32s] = cast_slice_mut(&mut input_gradient);
            let upper: &[V::f32s] = &cast_slice_mut::<Lanes, V::f32s>(s)[..WIDTHS[1] * row];
            for pair in 0..row / 2 {
                let weights = &self.packed.backward[..WIDTHS[0] * WIDTHS[1]];
                let sum = dense_tile::<V, 4>(simd, weights, &[0.0; 4], upper, pair);
                for j in 0..4 {
                    into[j * row + 2 * pair] = sum[j][0];
                    into[j * row + 2 * pair + 1] = sum[j][1];
                }
            }
            for (i, out) in out.iter_mut().enumerate() {
                out.1 = core::array::from_fn(|j| at(&input_gradient, j, i));
            }
        }
    }
}

#[cfg(test)]
mod tests;
