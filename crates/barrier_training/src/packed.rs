//! Weights rearranged for the kernels: tiles of output rows whose weights lie in the order of use.
//!
//! Repacking is a copy of 2 x 4,837 values per optimiser step, small beside the step.

use crate::network::{LAYERS, PARAMETERS, WIDTHS, offset};

/// Output rows per tile of the dense kernel: six rows by two vectors fill the registers of AVX2.
pub(crate) const TILE: usize = 6;

/// Both orders of one set of parameters.
#[derive(Debug, Clone)]
pub(crate) struct Packed {
    /// Per layer: tiles of [`TILE`] outputs (one output on the last layer), input index by input index.
    pub(crate) forward: Vec<f32>,
    /// Per layer: the transposed weights in the same way, tiles of inputs. Layer 0 has tiles of four.
    pub(crate) backward: Vec<f32>,
    /// The flat parameters themselves, for the biases.
    pub(crate) parameters: Vec<f32>,
}

impl Packed {
    /// Room for one network.
    pub(crate) fn new() -> Self {
        Self {
            forward: vec![0.0; PARAMETERS],
            backward: vec![0.0; PARAMETERS],
            parameters: vec![0.0; PARAMETERS],
        }
    }

    /// Takes over `parameters` (flat layout of [`crate::network`]).
    pub(crate) fn fill(&mut self, parameters: &[f32]) {
        self.parameters.copy_from_slice(parameters);
        for layer in 0..LAYERS {
            let (input, output) = (WIDTHS[layer], WIDTHS[layer + 1]);
            let weights = &parameters[offset(layer)..];
            pack(&mut self.forward[offset(layer)..], output, input, |row, k| weights[row * input + k]);
            pack(&mut self.backward[offset(layer)..], input, output, |row, k| weights[k * input + row]);
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
