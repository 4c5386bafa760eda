//! Models for the tests of this folder, and a plain scalar evaluation of the condition as their judge.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use barrier::{
    Bounds, DynamicsKind, FORMAT_VERSION, GridRecord, InputEncoding, LayerWeights, Model, ModelMetadata,
    NetworkWeights, TrainingRecord,
};
use dynamics::{DoubleIntegratorPair, InputBox, RelativeDynamics, UnicyclePair, UnicycleStaticPair};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Failure radius of every test model, m.
pub(crate) const RADIUS_M: f64 = 0.7;

/// Metadata with the paper's boxes for a pair; the disturbance box is `scale` times as wide.
pub(crate) fn metadata(dynamics: DynamicsKind, encoding: InputEncoding, scale: f64) -> ModelMetadata {
    let walking = ([0.25, -0.8], [1.0, 0.8]);
    let (control, disturbance, most) = match dynamics {
        DynamicsKind::UnicyclePair => (walking, vec![0.35 * scale], [6.0, 6.0, PI, 1.5]),
        DynamicsKind::UnicycleStaticPair => (walking, vec![], [6.0, 6.0, 1.0, 1.0]),
        DynamicsKind::DoubleIntegratorPair => {
            (([-2.0, -2.0], [2.0, 2.0]), vec![scale; 2], [4.0, 4.0, 3.5, 3.5])
        }
    };
    ModelMetadata {
        format_version: FORMAT_VERSION,
        dynamics,
        encoding,
        control: InputBox::new(control.0, control.1).unwrap(),
        disturbance: Bounds { min: disturbance.iter().map(|d| -d).collect(), max: disturbance },
        failure_radius_m: RADIUS_M,
        grid: GridRecord {
            min: [-most[0], -most[1], -most[2], if most[3] == 1.5 { 0.0 } else { -most[3] }],
            max: most,
            count: [10; 4],
            periodic: [false, false, dynamics == DynamicsKind::UnicyclePair, false],
        },
        solver: BTreeMap::new(),
        training: TrainingRecord::default(),
        verification: BTreeMap::new(),
        value_sha256: String::new(),
        hash: String::new(),
    }
}

/// Weights uniform in `± gain/√inputs`.
pub(crate) fn random_model(metadata: ModelMetadata, seed: u64, gain: f32) -> Model {
    let mut rng = Pcg64::seed_from_u64(seed);
    let layers = metadata.encoding.layer_sizes();
    let layers = layers
        .windows(2)
        .map(|sizes| {
            let bound = gain / (sizes[0] as f32).sqrt();
            let mut numbers = |count: usize| (0..count).map(|_| rng.random_range(-bound..bound)).collect();
            LayerWeights { weight: numbers(sizes[0] * sizes[1]), bias: numbers(sizes[1]) }
        })
        .collect();
    Model::new(NetworkWeights::new(metadata.encoding, layers).unwrap(), metadata).unwrap()
}

/// All weights zero, the output bias as given: `r = softplus(bias)` everywhere.
pub(crate) fn constant_model(metadata: ModelMetadata, output_bias: f32) -> Model {
    let layers = metadata.encoding.layer_sizes();
    let mut layers: Vec<LayerWeights> = layers
        .windows(2)
        .map(|s| LayerWeights { weight: vec![0.0; s[0] * s[1]], bias: vec![0.0; s[1]] })
        .collect();
    layers[6].bias[0] = output_bias;
    Model::new(NetworkWeights::new(metadata.encoding, layers).unwrap(), metadata).unwrap()
}

/// Value and gradient of `h̄` at a state, in plain `f64`, layer by layer.
pub(crate) struct Judge {
    pub(crate) barrier_m: f64,
    pub(crate) gradient: [f64; 4],
}

impl Judge {
    /// Evaluates forward with all four derivatives beside the value.
    pub(crate) fn new(model: &Model, z: &[f64; 4]) -> Self {
        let encoding = model.weights().encoding();
        let mut value: Vec<f64> = encoding.encode(z)[..encoding.input_count()].to_vec();
        let (sin, cos) = z[2].sin_cos();
        let unit = |i: usize| core::array::from_fn::<f64, 4, _>(|k| if k == i { 1.0 } else { 0.0 });
        let mut by_z: Vec<[f64; 4]> = match encoding {
            InputEncoding::Raw => (0..4).map(unit).collect(),
            InputEncoding::HeadingCosSin => {
                vec![unit(0), unit(1), [0.0, 0.0, -sin, 0.0], [0.0, 0.0, cos, 0.0], unit(3)]
            }
            InputEncoding::Position => vec![unit(0), unit(1)],
        };
        let layers = model.weights().layers();
        for (index, layer) in layers.iter().enumerate() {
            let inputs = value.len();
            let row = |r: usize| layer.weight[r * inputs..][..inputs].iter().map(|w| f64::from(*w));
            let sums: Vec<f64> = (0..layer.bias.len())
                .map(|r| row(r).zip(&value).map(|(w, a)| w * a).sum::<f64>() + f64::from(layer.bias[r]))
                .collect();
            let slopes: Vec<[f64; 4]> = (0..sums.len())
                .map(|r| core::array::from_fn(|k| row(r).zip(&by_z).map(|(w, d)| w * d[k]).sum()))
                .collect();
            let last = index + 1 == layers.len();
            value = sums
                .iter()
                .map(|y| if last { y.max(0.0) + (-y.abs()).exp().ln_1p() } else { y.sin() })
                .collect();
            by_z = sums
                .iter()
                .zip(slopes)
                .map(|(y, d)| d.map(|d| d * if last { 1.0 / (1.0 + (-y).exp()) } else { y.cos() }))
                .collect();
        }
        let distance = z[0].hypot(z[1]);
        let by_failure = [z[0] / distance, z[1] / distance, 0.0, 0.0];
        Self {
            barrier_m: distance - model.metadata().failure_radius_m - value[0],
            gradient: core::array::from_fn(|k| by_failure[k] - by_z[0][k]),
        }
    }

    /// `C(z)` by the Hamiltonian of `dynamics`.
    pub(crate) fn condition(&self, model: &Model, z: &[f64; 4], alpha_per_s: f64) -> f64 {
        let metadata = model.metadata();
        let (control, bounds) = (metadata.control, &metadata.disturbance);
        let hamiltonian = match metadata.dynamics {
            DynamicsKind::UnicyclePair => {
                let disturbance = InputBox::new([bounds.min[0]], [bounds.max[0]]).unwrap();
                UnicyclePair { control, disturbance }.hamiltonian(z, &self.gradient)
            }
            DynamicsKind::DoubleIntegratorPair => {
                let ends = |of: &[f64]| [of[0], of[1]];
                let disturbance = InputBox::new(ends(&bounds.min), ends(&bounds.max)).unwrap();
                DoubleIntegratorPair { control, disturbance }.hamiltonian(z, &self.gradient)
            }
            DynamicsKind::UnicycleStaticPair => UnicycleStaticPair { control }.hamiltonian(z, &self.gradient),
        };
        hamiltonian + alpha_per_s * self.barrier_m
    }
}
