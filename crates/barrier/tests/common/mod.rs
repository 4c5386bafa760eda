//! What the tests of this crate share: random models, a ground robot, and a scalar `f64` network as judge.
#![allow(dead_code)] // each test file uses a part

use std::collections::BTreeMap;
use std::f64::consts::PI;

use barrier::{
    BarrierObstacle, Bounds, DynamicsKind, FORMAT_VERSION, GridRecord, InputEncoding, LayerWeights, Model,
    ModelMetadata, NetworkWeights, TrainingRecord,
};
use dynamics::{DoubleIntegratorPair, InputBox, RobotObstaclePair, UnicyclePair};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Seeded numbers, the same on every machine.
pub(crate) fn rng(seed: u64) -> Pcg64 {
    Pcg64::seed_from_u64(seed)
}

/// Weights uniform in `± scale/√inputs`; scale 3 gives gradients as large as a trained model's.
pub(crate) fn random_weights(seed: u64, scale: f32) -> NetworkWeights {
    random_encoded_weights(InputEncoding::Raw, seed, scale)
}

/// As [`random_weights`], for inputs of `encoding`.
pub(crate) fn random_encoded_weights(encoding: InputEncoding, seed: u64, scale: f32) -> NetworkWeights {
    let mut rng = rng(seed);
    let layers = encoding
        .layer_sizes()
        .windows(2)
        .map(|sizes| {
            let bound = scale / (sizes[0] as f32).sqrt();
            let mut numbers = |count: usize| (0..count).map(|_| rng.random_range(-bound..bound)).collect();
            LayerWeights { weight: numbers(sizes[0] * sizes[1]), bias: numbers(sizes[1]) }
        })
        .collect();
    NetworkWeights::new(encoding, layers).unwrap()
}

/// The ground robot of the paper, trained on ±6 m.
pub(crate) fn ground_robot_metadata() -> ModelMetadata {
    let pair = unicycle_pair();
    ModelMetadata {
        format_version: FORMAT_VERSION,
        dynamics: DynamicsKind::UnicyclePair,
        encoding: InputEncoding::Raw,
        control: pair.control,
        disturbance: Bounds::from(&pair.disturbance),
        failure_radius_m: 0.7,
        grid: GridRecord {
            min: [-6.0, -6.0, -PI, 0.0],
            max: [6.0, 6.0, PI, 1.5],
            count: [80, 80, 20, 10],
            periodic: [false, false, true, false],
        },
        solver: BTreeMap::from([("cfl".to_owned(), 0.75.into())]),
        training: no_training(),
        verification: BTreeMap::new(),
        value_sha256: String::new(),
        hash: String::new(),
    }
}

/// The quadrotor of the paper, trained on ±4 m and ±3.5 m/s.
pub(crate) fn quadrotor_metadata() -> ModelMetadata {
    let pair = double_integrator_pair();
    ModelMetadata {
        dynamics: DynamicsKind::DoubleIntegratorPair,
        control: pair.control,
        disturbance: Bounds::from(&pair.disturbance),
        grid: GridRecord {
            min: [-4.0, -4.0, -3.5, -3.5],
            max: [4.0, 4.0, 3.5, 3.5],
            count: [80, 80, 20, 20],
            periodic: [false; 4],
        },
        ..ground_robot_metadata()
    }
}

/// What a model for a faster and wilder obstacle states: up to 5 m/s, over ±14 m.
pub(crate) fn cyclist_metadata() -> ModelMetadata {
    let mut metadata = ground_robot_metadata();
    (metadata.grid.min[0], metadata.grid.min[1]) = (-14.0, -14.0);
    (metadata.grid.max[0], metadata.grid.max[1], metadata.grid.max[3]) = (14.0, 14.0, 5.0);
    metadata.disturbance = Bounds { min: vec![-0.8], max: vec![0.8] };
    metadata
}

/// What a model for obstacles that stand still states.
pub(crate) fn static_metadata() -> ModelMetadata {
    let mut metadata = ground_robot_metadata();
    metadata.dynamics = DynamicsKind::UnicycleStaticPair;
    metadata.encoding = InputEncoding::Position;
    metadata.disturbance = Bounds { min: vec![], max: vec![] };
    metadata.grid.min[2..].fill(-1.0);
    metadata.grid.max[2..].fill(1.0);
    metadata.grid.periodic = [false; 4];
    metadata
}

fn no_training() -> TrainingRecord {
    TrainingRecord::default()
}

pub(crate) fn ground_robot_model(seed: u64) -> Model {
    Model::new(random_weights(seed, 3.0), ground_robot_metadata()).unwrap()
}

pub(crate) fn cyclist_model(seed: u64) -> Model {
    Model::new(random_weights(seed, 3.0), cyclist_metadata()).unwrap()
}

pub(crate) fn static_model(seed: u64) -> Model {
    Model::new(random_encoded_weights(InputEncoding::Position, seed, 3.0), static_metadata()).unwrap()
}

pub(crate) fn quadrotor_model(seed: u64) -> Model {
    Model::new(random_weights(seed, 3.0), quadrotor_metadata()).unwrap()
}

pub(crate) fn unicycle_pair() -> UnicyclePair {
    UnicyclePair {
        control: InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap(),
        disturbance: InputBox::new([-0.35], [0.35]).unwrap(),
    }
}

pub(crate) fn double_integrator_pair() -> DoubleIntegratorPair {
    DoubleIntegratorPair {
        control: InputBox::new([-2.0; 2], [2.0; 2]).unwrap(),
        disturbance: InputBox::new([-1.0; 2], [1.0; 2]).unwrap(),
    }
}

/// `count` people around the origin, within `reach_m`, whose state and rates stay in the unicycle's domain.
pub(crate) fn people(rng: &mut Pcg64, count: usize, reach_m: f64) -> Vec<BarrierObstacle> {
    let mut within = |bound: f64| rng.random_range(-bound..bound);
    (0..count)
        .map(|_| {
            let (heading, speed) = (within(3.0), 0.75 + within(0.7));
            BarrierObstacle {
                state: [within(reach_m), within(reach_m), heading, speed],
                rate: [speed * heading.cos(), speed * heading.sin(), within(0.35), within(0.5)],
                radius_m: 0.7 + within(0.2),
                model: 0,
            }
        })
        .collect()
}

/// The residual in `f64`, one multiplication after the other.
pub(crate) fn reference_residual(weights: &NetworkWeights, z: &[f64; 4]) -> f64 {
    let mut a = weights.encoding().encode(z)[..weights.encoding().input_count()].to_vec();
    for (index, layer) in weights.layers().iter().enumerate() {
        let y = layer.bias.iter().enumerate().map(|(output, &bias)| {
            let row = &layer.weight[output * a.len()..(output + 1) * a.len()];
            f64::from(bias) + row.iter().zip(&a).map(|(&w, a)| f64::from(w) * a).sum::<f64>()
        });
        a = if index == 6 { y.collect() } else { y.map(f64::sin).collect() };
    }
    a[0].max(0.0) + (-a[0].abs()).exp().ln_1p()
}

/// Central differences of `f`, accurate to about 1e-9 for smooth `f` of order one.
pub(crate) fn central_differences<const N: usize>(
    x: &[f64; N],
    mut f: impl FnMut(&[f64; N]) -> f64,
) -> [f64; N] {
    let step = 1e-5;
    std::array::from_fn(|k| {
        let mut at = |offset: f64| {
            let mut moved = *x;
            moved[k] += offset;
            f(&moved)
        };
        (at(step) - at(-step)) / (2.0 * step)
    })
}

/// The composite in `f64`, straight from eq. `eta` and `h_bar`, for obstacles inside the domain of the model each names.
pub(crate) fn reference_composite<const NX: usize, P: RobotObstaclePair<NX>>(
    weights: &[&NetworkWeights],
    beta_per_m: f64,
    pair: &P,
    x: &[f64; NX],
    obstacles: &[BarrierObstacle],
) -> f64 {
    let sum: f64 = obstacles
        .iter()
        .map(|obstacle| {
            let z = pair.relative_state(x, &obstacle.state);
            let h_bar =
                z[0].hypot(z[1]) - obstacle.radius_m - reference_residual(weights[obstacle.model], &z);
            (-beta_per_m * h_bar).exp()
        })
        .sum();
    -sum.ln() / beta_per_m
}
