//! Weights rearranged for the kernels: tiles of output rows whose weights lie in the order of use.
//!
//! Repacking is a copy of twice the parameters per optimiser step, small beside the step.

use crate::network::{LAYERS, MOST_INPUTS, OUTPUTS, Shape};

/// Output rows per tile of the dense kernel: six rows by two vectors fill the registers of AVX2.
pub(crate) const TILE: usize = 6;
const _: () = assert!(MOST_INPUTS <= TILE, "the derivatives by the inputs are one tile");

/// Both orders of one set of parameters.
#[derive(Debug, Clone)]
pub(crate) struct Packed {
    /// Where the parameters lie.
    pub(crate) shape: Shape,
    /// Per layer: tiles of [`TILE`] outputs (one output on the last layer), input index by input index.
    pub(crate) forward: Vec<f32>,
    /// Per layer from the second: the transposed weights in the same way, tiles of inputs.
    pub(crate) backward: Vec<f32>,
    /// The transposed weights of the first layer as one tile, filled up with zeros.
    pub(crate) by_input: Vec<f32>,
    /// The flat parameters themselves, for the biases.
    pub(crate) parameters: Vec<f32>,
}

impl Packed {
    /// Room for one network.
    pub(crate) fn new(shape: Shape) -> Self {
        let room = || vec![0.0; shape.parameters()];
        let by_input = vec![0.0; TILE * OUTPUTS[0]];
        Self { shape, forward: room(), backward: room(), by_input, parameters: room() }
    }

    /// Takes over `parameters` (flat layout of [`Shape`]).
    pub(crate) fn fill(&mut self, parameters: &[f32]) {
        self.parameters.copy_from_slice(parameters);
        let shape = self.shape;
        for layer in 0..LAYERS {
            let (input, output, offset) = (shape.input(layer), shape.output(layer), shape.offset(layer));
            let weights = &parameters[offset..];
            pack(&mut self.forward[offset..], output, input, |row, k| weights[row * input + k]);
            if layer == 0 {
                let weight = |row, k| if row < input { weights[k * input + row] } else { 0.0 };
                pack(&mut self.by_input, TILE, output, weight);
            } else {
                pack(&mut self.backward[offset..], input, output, |row, k| weights[k * input + row]);
            }
        }
    }
}

/// Rows per tile of a product with `rows` output rows.
pub(crate) const fn tile_rows(rows: usize) -> usize {
    if rows.is_multiple_of(TILE) { TILE } else { rows }
}

fn pack(into: &mut [f32], rows: usize, columns: usize, weight: impl Fn(usize, usize) -> f32) {
    let tile = tile_rows(rows);
    let mut slots = into.iter_mut();
    for first in (0..rows).step_by(tile) {
        for k in 0..columns {
            for row in first..first + tile {
                if let Some(slot) = slots.next() {
                    *slot = weight(row, k);
                }
            }
        }
    }
}
