//! Shape, parameter layout and initial values of the residual network of the paper's experiments.
//!
//! Layers `inputs`-48-48-24-24-12-12-1, `sin` on the hidden ones, `softplus` on the last. With the raw relative state as
//! input these are the paper's 4,837 parameters. Parameters are one flat vector, layer by layer, weights (`[out][in]`)
//! before biases. Not here: what the inputs are (`features`), the network as the filter evaluates it (crate `barrier`).

use rand::RngExt;
use rand_pcg::Pcg64;
use settings::Encoding;

/// Neurons behind each layer with parameters.
pub(crate) const OUTPUTS: [usize; 7] = [48, 48, 24, 24, 12, 12, 1];
/// Layers with parameters.
pub const LAYERS: usize = OUTPUTS.len();
/// Most inputs any encoding has.
pub(crate) const MOST_INPUTS: usize = 5;

/// The network for one encoding: where each layer's parameters lie in the flat vector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shape {
    inputs: usize,
}

impl Shape {
    /// The shape for `encoding`.
    pub const fn of(encoding: Encoding) -> Self {
        let inputs = match encoding {
            Encoding::Raw => 4,
            Encoding::HeadingCosSin => 5,
            Encoding::Position => 2,
        };
        Self { inputs }
    }

    /// Inputs of `layer`.
    pub const fn input(self, layer: usize) -> usize {
        if layer == 0 { self.inputs } else { OUTPUTS[layer - 1] }
    }

    /// Outputs of `layer`.
    pub const fn output(self, layer: usize) -> usize {
        OUTPUTS[layer]
    }

    /// Index of the first weight of `layer` in the flat vector; of `LAYERS`, the number of parameters.
    pub const fn offset(self, layer: usize) -> usize {
        let (mut sum, mut i) = (0, 0);
        while i < layer {
            sum += (self.input(i) + 1) * OUTPUTS[i];
            i += 1;
        }
        sum
    }

    /// Index of the first bias of `layer` in the flat vector.
    pub const fn bias_offset(self, layer: usize) -> usize {
        self.offset(layer) + self.input(layer) * OUTPUTS[layer]
    }

    /// Number of parameters.
    pub const fn parameters(self) -> usize {
        self.offset(LAYERS)
    }
}

/// Parameters and what they read.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedNetwork {
    /// What the network sees of the relative state.
    pub encoding: Encoding,
    /// Flat parameters, layout of [`Shape`].
    pub parameters: Vec<f32>,
}

/// Seeded start: uniform in `±sqrt(6 / in)` on the hidden layers, which keeps the variance of a chain of sines, with
/// the first layer scaled by `first_layer_gain` (radians per unit of the input); biases of the hidden layers uniform
/// in `±π`, so that the sines start at all phases; the last bias such that the residual starts at
/// `mean_residual_m` > 0.
pub(crate) fn initial(
    rng: &mut Pcg64,
    shape: Shape,
    first_layer_gain: f32,
    mean_residual_m: f32,
) -> Vec<f32> {
    let mut parameters = vec![0.0_f32; shape.parameters()];
    for layer in 0..LAYERS {
        let (first, hidden) = (layer == 0, layer + 1 < LAYERS);
        let half_width =
            libm::sqrtf(6.0 / shape.input(layer) as f32) * if first { first_layer_gain } else { 1.0 };
        for weight in &mut parameters[shape.offset(layer)..shape.bias_offset(layer)] {
            *weight = rng.random_range(-half_width..half_width);
        }
        for bias in &mut parameters[shape.bias_offset(layer)..][..shape.output(layer)] {
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
    fn has_the_papers_parameter_count_and_one_more_input_for_the_periodic_heading() {
        let counts =
            [Encoding::Raw, Encoding::HeadingCosSin, Encoding::Position].map(|e| Shape::of(e).parameters());
        assert_eq!(counts, [4_837, 4_885, 4_741]);
        let shape = Shape::of(Encoding::Raw);
        assert_eq!(shape.bias_offset(LAYERS - 1) + 1, shape.parameters());
    }
}
