//! The parameters of the residual network as plain numbers. Not here: files (`model_file`), evaluation
//! (`network`).

use crate::encoding::{InputEncoding, LAYER_WIDTHS};

/// One affine layer `y = W a + b`.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerWeights {
    /// `W`, row-major, one row per output.
    pub weight: Vec<f32>,
    /// `b`, one per output.
    pub bias: Vec<f32>,
}

/// Parameters `Θ` of the residual network, checked: seven layers of [`InputEncoding::layer_sizes`], all finite.
#[derive(Debug, Clone, PartialEq)]
pub struct NetworkWeights {
    encoding: InputEncoding,
    layers: Vec<LayerWeights>,
}

/// Why numbers are no parameters of the residual network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum WeightsError {
    /// Another number of layers.
    #[error("the network has 7 layers, {found} were given; check the architecture of the training")]
    LayerCount {
        /// Layers given.
        found: usize,
    },
    /// A layer of another size.
    #[error(
        "layer {layer} needs {weights} weights and {biases} biases, found {found_weights} and \
         {found_biases}; inputs `{encoding}` make it {inputs}-48-48-24-24-12-12-1"
    )]
    LayerSize {
        /// Index of the layer.
        layer: usize,
        /// The inputs' encoding.
        encoding: InputEncoding,
        /// Number of inputs it has.
        inputs: usize,
        /// Weights needed.
        weights: usize,
        /// Biases needed.
        biases: usize,
        /// Weights given.
        found_weights: usize,
        /// Biases given.
        found_biases: usize,
    },
    /// A NaN or infinite parameter.
    #[error("layer {layer} holds a parameter that is not finite; the training diverged, run it again")]
    NonFinite {
        /// Index of the layer.
        layer: usize,
    },
}

impl NetworkWeights {
    /// Checks and takes the seven layers of a network on inputs of `encoding`, input side first.
    ///
    /// # Errors
    /// * [`WeightsError::LayerCount`], [`WeightsError::LayerSize`] for another architecture.
    /// * [`WeightsError::NonFinite`] for a NaN or an infinity.
    pub fn new(encoding: InputEncoding, layers: Vec<LayerWeights>) -> Result<Self, WeightsError> {
        if layers.len() != LAYER_WIDTHS.len() {
            return Err(WeightsError::LayerCount { found: layers.len() });
        }
        for (layer, (given, sizes)) in layers.iter().zip(encoding.layer_sizes().windows(2)).enumerate() {
            let (weights, biases) = (sizes[0] * sizes[1], sizes[1]);
            let (found_weights, found_biases) = (given.weight.len(), given.bias.len());
            if (found_weights, found_biases) != (weights, biases) {
                let inputs = encoding.input_count();
                return Err(WeightsError::LayerSize {
                    layer,
                    encoding,
                    inputs,
                    weights,
                    biases,
                    found_weights,
                    found_biases,
                });
            }
            if !given.weight.iter().chain(&given.bias).all(|parameter| parameter.is_finite()) {
                return Err(WeightsError::NonFinite { layer });
            }
        }
        Ok(Self { encoding, layers })
    }

    /// Returns how a relative state becomes the first layer's inputs.
    pub fn encoding(&self) -> InputEncoding {
        self.encoding
    }

    /// Returns the seven layers, input side first.
    pub fn layers(&self) -> &[LayerWeights] {
        &self.layers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use InputEncoding::Raw;

    fn zero_layers() -> Vec<LayerWeights> {
        Raw.layer_sizes()
            .windows(2)
            .map(|s| LayerWeights { weight: vec![0.0; s[0] * s[1]], bias: vec![0.0; s[1]] })
            .collect()
    }

    #[test]
    fn layers_fit_one_encoding_only() {
        assert!(NetworkWeights::new(Raw, zero_layers()).is_ok());
        for encoding in [InputEncoding::HeadingCosSin, InputEncoding::Position] {
            let refused = NetworkWeights::new(encoding, zero_layers());
            assert!(matches!(refused, Err(WeightsError::LayerSize { layer: 0, .. })), "{encoding}");
        }
    }

    #[test]
    fn one_layer_too_few_is_refused() {
        let mut layers = zero_layers();
        layers.pop();
        assert_eq!(NetworkWeights::new(Raw, layers), Err(WeightsError::LayerCount { found: 6 }));
    }

    #[test]
    fn one_weight_too_many_is_refused() {
        let mut layers = zero_layers();
        layers[3].weight.push(0.0);
        assert!(matches!(NetworkWeights::new(Raw, layers), Err(WeightsError::LayerSize { layer: 3, .. })));
    }

    #[test]
    fn a_nan_bias_is_refused() {
        let mut layers = zero_layers();
        layers[5].bias[2] = f32::NAN;
        assert_eq!(NetworkWeights::new(Raw, layers), Err(WeightsError::NonFinite { layer: 5 }));
    }
}
