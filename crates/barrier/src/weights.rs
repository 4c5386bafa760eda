//! The parameters of the residual network as plain numbers. Not here: files (`model_file`), evaluation
//! (`network`).

/// Neurons per layer: four relative states in, one residual out.
pub const LAYER_SIZES: [usize; 8] = [4, 48, 48, 24, 24, 12, 12, 1];

/// Number of parameters, weights and biases together.
pub const PARAMETER_COUNT: usize = 4_837;

/// One affine layer `y = W a + b`.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerWeights {
    /// `W`, row-major, one row per output.
    pub weight: Vec<f32>,
    /// `b`, one per output.
    pub bias: Vec<f32>,
}

/// Parameters `Θ` of the residual network, checked: seven layers of [`LAYER_SIZES`], all finite.
#[derive(Debug, Clone, PartialEq)]
pub struct NetworkWeights {
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
         {found_biases}; the sizes are 4-48-48-24-24-12-12-1"
    )]
    LayerSize {
        /// Index of the layer.
        layer: usize,
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
    /// Checks and takes the seven layers, input side first.
    ///
    /// # Errors
    /// * [`WeightsError::LayerCount`], [`WeightsError::LayerSize`] for another architecture.
    /// * [`WeightsError::NonFinite`] for a NaN or an infinity.
    pub fn new(layers: Vec<LayerWeights>) -> Result<Self, WeightsError> {
        if layers.len() != LAYER_SIZES.len() - 1 {
            return Err(WeightsError::LayerCount { found: layers.len() });
        }
        for (layer, (given, sizes)) in layers.iter().zip(LAYER_SIZES.windows(2)).enumerate() {
            let (weights, biases) = (sizes[0] * sizes[1], sizes[1]);
            let (found_weights, found_biases) = (given.weight.len(), given.bias.len());
            if (found_weights, found_biases) != (weights, biases) {
                return Err(WeightsError::LayerSize { layer, weights, biases, found_weights, found_biases });
            }
            if !given.weight.iter().chain(&given.bias).all(|parameter| parameter.is_finite()) {
                return Err(WeightsError::NonFinite { layer });
            }
        }
        Ok(Self { layers })
    }

    /// Returns the seven layers, input side first.
    pub fn layers(&self) -> &[LayerWeights] {
        &self.layers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn zero_layers() -> Vec<LayerWeights> {
        LAYER_SIZES
            .windows(2)
            .map(|s| LayerWeights { weight: vec![0.0; s[0] * s[1]], bias: vec![0.0; s[1]] })
            .collect()
    }

    #[test]
    fn the_sizes_give_the_parameter_count_of_the_paper() {
        let count: usize = zero_layers().iter().map(|l| l.weight.len() + l.bias.len()).sum();
        assert_eq!(count, PARAMETER_COUNT);
        assert!(NetworkWeights::new(zero_layers()).is_ok());
    }

    #[test]
    fn one_layer_too_few_is_refused() {
        let mut layers = zero_layers();
        layers.pop();
        assert_eq!(NetworkWeights::new(layers), Err(WeightsError::LayerCount { found: 6 }));
    }

    #[test]
    fn one_weight_too_many_is_refused() {
        let mut layers = zero_layers();
        layers[3].weight.push(0.0);
        assert!(matches!(NetworkWeights::new(layers), Err(WeightsError::LayerSize { layer: 3, .. })));
    }

    #[test]
    fn a_nan_bias_is_refused() {
        let mut layers = zero_layers();
        layers[5].bias[2] = f32::NAN;
        assert_eq!(NetworkWeights::new(layers), Err(WeightsError::NonFinite { layer: 5 }));
    }
}
