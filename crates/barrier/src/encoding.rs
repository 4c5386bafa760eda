//! How a relative state becomes the network's inputs. Not here: the arithmetic (`network_pass`), which takes the
//! same step on many lanes and back by the chain rule.

use serde::{Deserialize, Serialize};

use crate::metadata::DynamicsKind;

/// Neurons of the layers behind the inputs; the last is the residual.
pub const LAYER_WIDTHS: [usize; 7] = [48, 48, 24, 24, 12, 12, 1];

/// The inputs that a residual network takes, as functions of the relative state `z`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InputEncoding {
    /// `[z₁, z₂, z₃, z₄]`, as in the paper: 4,837 parameters. An angle among them leaves a seam at ±π.
    Raw,
    /// `[z₁, z₂, cos z₃, sin z₃, z₄]`: 4,885 parameters, periodic in the relative heading `z₃`.
    HeadingCosSin,
    /// `[z₁, z₂]`: 4,741 parameters. For obstacles that stand still, whose other components do not matter.
    Position,
}

impl InputEncoding {
    /// Every encoding.
    pub const ALL: [Self; 3] = [Self::Raw, Self::HeadingCosSin, Self::Position];

    /// Returns the number of inputs.
    pub const fn input_count(self) -> usize {
        match self {
            Self::Raw => 4,
            Self::HeadingCosSin => 5,
            Self::Position => 2,
        }
    }

    /// Returns the sizes of all layers, inputs first.
    pub const fn layer_sizes(self) -> [usize; 8] {
        let [a, b, c, d, e, f, g] = LAYER_WIDTHS;
        [self.input_count(), a, b, c, d, e, f, g]
    }

    /// Returns the number of parameters, weights and biases together.
    pub fn parameter_count(self) -> usize {
        self.layer_sizes().windows(2).map(|sizes| (sizes[0] + 1) * sizes[1]).sum()
    }

    /// Returns the inputs for `z` (m, rad, m/s as the pair in `dynamics` states): the definition, for training and
    /// judges. Entries from [`InputEncoding::input_count`] on are zero. The kernels use sines of their own, which
    /// agree with these to 5e-7.
    pub fn encode(self, z: &[f64; 4]) -> [f64; 5] {
        match self {
            Self::Raw => [z[0], z[1], z[2], z[3], 0.0],
            Self::HeadingCosSin => [z[0], z[1], z[2].cos(), z[2].sin(), z[3]],
            Self::Position => [z[0], z[1], 0.0, 0.0, 0.0],
        }
    }

    /// Returns whether the inputs hold everything the dynamics' value function depends on, and no angle that is none.
    pub const fn suits(self, dynamics: DynamicsKind) -> bool {
        match (self, dynamics) {
            (Self::Raw, _)
            | (Self::HeadingCosSin, DynamicsKind::UnicyclePair)
            | (Self::Position, DynamicsKind::UnicycleStaticPair) => true,
            (Self::HeadingCosSin, DynamicsKind::DoubleIntegratorPair | DynamicsKind::UnicycleStaticPair)
            | (Self::Position, DynamicsKind::UnicyclePair | DynamicsKind::DoubleIntegratorPair) => false,
        }
    }
}

impl std::fmt::Display for InputEncoding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Raw => "raw",
            Self::HeadingCosSin => "heading_cos_sin",
            Self::Position => "position",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_raw_network_has_the_parameters_of_the_paper() {
        assert_eq!(InputEncoding::ALL.map(InputEncoding::parameter_count), [4_837, 4_885, 4_741]);
    }

    #[test]
    fn the_name_shown_is_the_name_stored() {
        for encoding in InputEncoding::ALL {
            assert_eq!(serde_json::to_value(encoding).unwrap(), encoding.to_string());
        }
    }

    #[test]
    fn the_heading_s_inputs_do_not_know_full_turns() {
        let turn = 2.0 * std::f64::consts::PI;
        let [a, b] = [1.0, 1.0 + turn].map(|z3| InputEncoding::HeadingCosSin.encode(&[3.0, -1.0, z3, 0.7]));
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15));
    }
}
