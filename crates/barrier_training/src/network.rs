//! Shape, parameter layout and initial values of the residual network of the paper's experiments.
//!
//! Layers 4-48-48-24-24-12-12-1, `sin` on the hidden ones, `softplus` on the last, raw relative state as input: 4,837
//! parameters. Parameters are one flat vector, layer by layer, weights (`[out][in]`) before biases. Not here: the
//! network as the filter evaluates it (crate `barrier`).

use rand::RngExt;
use rand_pcg::Pcg64;

/// Neurons per layer, the input first.
pub const WIDTHS: [usize; 8] = [4, 48, 48, 24, 24, 12, 12, 1];
/// Layers with parameters.
pub const LAYERS: usize = WIDTHS.len() - 1;
/// Number of parameters.
pub const PARAMETERS: usize = offset(LAYERS);

/// Index of the first weight of `layer` in the flat vector.
pub const fn offset(layer: usize) -> usize {
    let (mut sum, mut i) = (0, 0);
    while i < layer {
        sum += WIDTHS[i] * WIDTHS[i + 1] + WIDTHS[i + 1];
        i += 1;
    }
    sum
}

/// Index of the first bias of `layer` in the flat vector.
pub const fn bias_offset(layer: usize) -> usize {
    offset(layer) + WIDTHS[layer] * WIDTHS[layer + 1]
}

/// Seeded start: uniform in `±sqrt(6 / in)` on the hidden layers, which keeps the variance of a chain of sines, with
/// the first layer scaled by `first_layer_gain` (radians per unit of the state); biases of the hidden layers uniform
/// in `±π`, so that the sines start at all phases; the last bias such that the residual starts at
/// `mean_residual_m` > 0.
pub(crate) fn initial(rng: &mut Pcg64, first_layer_gain: f32, mean_residual_m: f32) -> Vec<f32> {
    let mut parameters = vec![0.0_f32; PARAMETERS];
    for layer in 0..LAYERS {
        let (input, output) = (WIDTHS[layer], WIDTHS[layer + 1]);
        let (first, hidden) = (layer == 0, layer + 1 < LAYERS);
        let half_width = libm::sqrtf(6.0 / input as f32) * if first { first_layer_gain } else { 1.0 };
        for weight in &mut parameters[offset(layer)..bias_offset(layer)] {
            *weight = rng.random_range(-half_width..half_width);
        }
        for bias in &mut parameters[bias_offset(layer)..bias_offset(layer) + output] {
            *bias = if hidden {
                rng.random_range(-core::f32::consts::PI..core::f32::consts::PI)
            } else {
                libm::logf(libm::expm1f(mean_residual_m.max(1e-3)))
            };
        }
    }
    parameters
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn has_the_papers_parameter_count() {
        assert_eq!(PARAMETERS, 4_837);
        assert_eq!(bias_offset(LAYERS - 1) + 1, PARAMETERS);
    }
}
