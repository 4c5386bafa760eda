//! One panel of samples forward and backward through the network, and the parameter gradient of a block.
//!
//! Not here: losses (`block`, `condition_block`).

// As in `sine`: vector code must melt into the function that enabled the instruction set.
#![allow(clippy::inline_always)]

use crate::kernel::{Rows, dense_tile, outer_tile, row_sums, vectors};
use crate::network::{LAYERS, MOST_INPUTS, OUTPUTS};
use crate::packed::{Packed, TILE};
use crate::panel::{BLOCK_PANELS, Lanes, groups};
use pulp::Simd;

/// Rows kept for the inputs: whole tiles of the parameter gradient. What an encoding leaves free stays 0.
const INPUT_ROWS: usize = 8;
const _: () = assert!(MOST_INPUTS <= INPUT_ROWS);

/// Rows of the inputs of `layer` among the stored activations.
const fn rows(layer: usize) -> usize {
    if layer == 0 { INPUT_ROWS } else { OUTPUTS[layer - 1] }
}
/// First row of the inputs of `layer` among the stored activations.
pub(crate) const fn activation_row(layer: usize) -> usize {
    let (mut sum, mut i) = (0, 0);
    while i < layer {
        sum += rows(i);
        i += 1;
    }
    sum
}
/// First row of the outputs of `layer` among the stored slopes.
pub(crate) const fn slope_row(layer: usize) -> usize {
    activation_row(layer + 1) - INPUT_ROWS
}
/// Rows of the stored activations of one panel.
pub(crate) const ACTIVATION_ROWS: usize = activation_row(LAYERS);
/// Rows of the stored slopes of one panel; the last belongs to the last layer.
pub(crate) const SLOPE_ROWS: usize = slope_row(LAYERS);

/// Scratch of one thread. Allocated once, reused; what it holds between two calls does not matter, but for the free rows of
/// the inputs, which stay 0.
#[derive(Debug, Clone)]
pub(crate) struct Workspace {
    /// Inputs of every layer.
    pub(crate) activations: Vec<Lanes>,
    /// Cosines on the way forward; derivative of the loss by each pre-activation after the way back.
    pub(crate) slopes: Vec<Lanes>,
    /// Slopes of one panel, for a way back that must leave the cosines.
    pub(crate) spare: Vec<Lanes>,
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
    pub(crate) fn new(parameters: usize) -> Self {
        Self { gradient: vec![0.0; parameters], loss: 0.0 }
    }
}

impl Workspace {
    /// Room for one block.
    pub(crate) fn new() -> Self {
        Self {
            activations: vec![Lanes::ZERO; groups(ACTIVATION_ROWS) * BLOCK_PANELS],
            slopes: vec![Lanes::ZERO; groups(SLOPE_ROWS) * BLOCK_PANELS],
            spare: vec![Lanes::ZERO; groups(SLOPE_ROWS)],
        }
    }
}

/// `softplus(x) = ln(1 + eˣ)` and its derivative, without overflow.
pub(crate) fn softplus(x: f32) -> (f32, f32) {
    let e = libm::expf(-x.abs());
    let slope = if x >= 0.0 { 1.0 / (1.0 + e) } else { e / (1.0 + e) };
    (x.max(0.0) + libm::log1pf(e), slope)
}

/// What a way forward carries: values, or their rates along a direction of the input.
#[derive(Clone, Copy)]
pub(crate) enum Carry<'a, V: Simd> {
    /// Activations; the slopes become cosines.
    Values,
    /// Rates of the activations; the slopes become rates of the pre-activations. Holds the cosines of the values.
    Rates(&'a [V::f32s]),
}

/// Fills activations and slopes of one panel, and the last pre-activation (or its rate) into the last slope row.
#[inline(always)]
pub(crate) fn forward<V: Simd>(
    simd: V,
    packed: &Packed,
    carry: Carry<'_, V>,
    activations: &mut [V::f32s],
    slopes: &mut [V::f32s],
) {
    let row = vectors::<V>();
    for layer in 0..LAYERS {
        let (input, output) = (packed.shape.input(layer), OUTPUTS[layer]);
        let (below, above) = activations.split_at_mut(activation_row(layer + 1) * row);
        let below = &below[activation_row(layer) * row..][..input * row];
        let biases = &packed.parameters[packed.shape.bias_offset(layer)..][..output];
        let weights = &packed.forward[packed.shape.offset(layer)..][..input * output];
        let own = slope_row(layer) * row;
        if layer + 1 == LAYERS {
            let start = if let Carry::Values = carry { biases[0] } else { 0.0 };
            for pair in 0..row / 2 {
                let z = dense_tile::<V, 1>(simd, weights, &[start], below, pair);
                slopes[own + 2 * pair] = z[0][0];
                slopes[own + 2 * pair + 1] = z[0][1];
            }
            continue;
        }
        let above = &mut above[..output * row];
        for first in (0..output).step_by(TILE) {
            let mut start = [0.0; TILE];
            if let Carry::Values = carry {
                start.copy_from_slice(&biases[first..first + TILE]);
            }
            for pair in 0..row / 2 {
                let tile = &weights[first * input..(first + TILE) * input];
                let z = dense_tile::<V, TILE>(simd, tile, &start, below, pair);
                for j in 0..TILE {
                    for i in 0..2 {
                        let at = (first + j) * row + 2 * pair + i;
                        let (up, slope) = match carry {
                            Carry::Values => crate::sine::sin_cos(simd, z[j][i]),
                            Carry::Rates(cosines) => (simd.mul_f32s(z[j][i], cosines[own + at]), z[j][i]),
                        };
                        above[at] = up;
                        slopes[own + at] = slope;
                    }
                }
            }
        }
    }
}

/// Turns the cosines of one panel into derivatives by each pre-activation, from the last row downwards.
#[inline(always)]
pub(crate) fn backward<V: Simd>(simd: V, packed: &Packed, slopes: &mut [V::f32s]) {
    let row = vectors::<V>();
    for layer in (1..LAYERS).rev() {
        let (input, output) = (packed.shape.input(layer), OUTPUTS[layer]);
        let (lower, upper) = slopes.split_at_mut(slope_row(layer) * row);
        let lower = &mut lower[slope_row(layer - 1) * row..];
        let upper = &upper[..output * row];
        let weights = &packed.backward[packed.shape.offset(layer)..][..input * output];
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

/// Derivatives by the inputs (rows of `into`, [`TILE`] of them) from those by the first pre-activations.
#[inline(always)]
pub(crate) fn by_input<V: Simd>(simd: V, packed: &Packed, slopes: &[V::f32s], into: &mut [V::f32s]) {
    let row = vectors::<V>();
    for pair in 0..row / 2 {
        let first = &slopes[..OUTPUTS[0] * row];
        let sum = dense_tile::<V, TILE>(simd, &packed.by_input, &[0.0; TILE], first, pair);
        for j in 0..TILE {
            into[j * row + 2 * pair] = sum[j][0];
            into[j * row + 2 * pair + 1] = sum[j][1];
        }
    }
}

/// Gradient of all parameters from a block's activations and slopes. The biases follow from the first `bias_panels`
/// panels alone: the rates of a direction carry no bias.
#[inline(always)]
pub(crate) fn parameter_gradient<V: Simd>(
    simd: V,
    packed: &Packed,
    workspace: &Workspace,
    bias_panels: usize,
    gradient: &mut [f32],
) {
    for layer in 0..LAYERS - 1 {
        layer_gradient::<V, 3>(simd, packed, layer, workspace, bias_panels, gradient);
    }
    layer_gradient::<V, 1>(simd, packed, LAYERS - 1, workspace, bias_panels, gradient);
}

/// The same for one layer, in tiles of `J` rows by 4.
#[inline(always)]
fn layer_gradient<V: Simd, const J: usize>(
    simd: V,
    packed: &Packed,
    layer: usize,
    workspace: &Workspace,
    bias_panels: usize,
    gradient: &mut [f32],
) {
    let (input, output) = (packed.shape.input(layer), OUTPUTS[layer]);
    let (offset, bias_offset) = (packed.shape.offset(layer), packed.shape.bias_offset(layer));
    for j in (0..output).step_by(J) {
        let left = Rows { data: &workspace.slopes, height: SLOPE_ROWS, first: slope_row(layer) + j };
        for k in (0..input).step_by(4) {
            let first = activation_row(layer) + k;
            let right = Rows { data: &workspace.activations, height: ACTIVATION_ROWS, first };
            let tile = outer_tile::<V, J, 4>(simd, left, right);
            for (row, values) in tile.iter().enumerate() {
                let columns = (input - k).min(4);
                gradient[offset + (j + row) * input + k..][..columns].copy_from_slice(&values[..columns]);
            }
        }
        let data = &workspace.slopes[..groups(SLOPE_ROWS) * bias_panels];
        gradient[bias_offset + j..][..J].copy_from_slice(&row_sums::<V, J>(simd, Rows { data, ..left }));
    }
}
