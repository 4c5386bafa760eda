//! What the tests of this crate share: hand-made models whose verdicts are known.
#![allow(dead_code, clippy::unwrap_used)] // each test file uses a part, and helpers of tests may panic

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::ops::ControlFlow;

use barrier::{
    Bounds, DynamicsKind, FORMAT_VERSION, GridRecord, InputEncoding, LayerWeights, Model, ModelMetadata,
    NetworkWeights, TrainingRecord,
};
use dynamics::InputBox;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use verification::{DisturbancePolicy, NominalPolicy, Progress, ScenarioSettings};

/// Goes on, whatever was done.
pub(crate) fn go_on(_: &Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// A network whose residual is `softplus(bias)` everywhere.
pub(crate) fn constant_residual(encoding: InputEncoding, bias: f32) -> NetworkWeights {
    let sizes = encoding.layer_sizes();
    let layers = sizes.windows(2).enumerate().map(|(index, sizes)| LayerWeights {
        weight: vec![0.0; sizes[0] * sizes[1]],
        bias: vec![if index == 6 { bias } else { 0.0 }; sizes[1]],
    });
    NetworkWeights::new(encoding, layers.collect()).unwrap()
}

/// A network of random parameters with gradients as large as a trained one's.
pub(crate) fn random_residual(encoding: InputEncoding, seed: u64) -> NetworkWeights {
    let mut rng = Pcg64::seed_from_u64(seed);
    let sizes = encoding.layer_sizes();
    let layers = sizes.windows(2).map(|sizes| {
        let bound = 3.0 / (sizes[0] as f32).sqrt();
        let mut numbers = |count: usize| (0..count).map(|_| rng.random_range(-bound..bound)).collect();
        LayerWeights { weight: numbers(sizes[0] * sizes[1]), bias: numbers(sizes[1]) }
    });
    NetworkWeights::new(encoding, layers.collect()).unwrap()
}

/// The residual is zero but for e⁻⁶⁰: `h = ℓ`.
pub(crate) const NO_RESIDUAL: f32 = -60.0;

/// Metadata of a hand-made model.
pub(crate) fn metadata(dynamics: DynamicsKind) -> ModelMetadata {
    let unicycle = (InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap(), [4.0, 4.0, PI, 1.5], [-PI, 0.0], true);
    let (control, max, low, periodic) = match dynamics {
        DynamicsKind::UnicyclePair | DynamicsKind::UnicycleStaticPair => unicycle,
        DynamicsKind::DoubleIntegratorPair => {
            (InputBox::new([-2.0; 2], [2.0; 2]).unwrap(), [4.0, 4.0, 3.5, 3.5], [-3.5, -3.5], false)
        }
    };
    let disturbance = match dynamics {
        DynamicsKind::UnicyclePair => Bounds { min: vec![-0.35], max: vec![0.35] },
        DynamicsKind::UnicycleStaticPair => Bounds { min: vec![], max: vec![] },
        DynamicsKind::DoubleIntegratorPair => Bounds { min: vec![-1.0; 2], max: vec![1.0; 2] },
    };
    ModelMetadata {
        format_version: FORMAT_VERSION,
        dynamics,
        encoding: InputEncoding::Raw,
        control,
        disturbance,
        failure_radius_m: 0.7,
        grid: GridRecord {
            min: [-4.0, -4.0, low[0], low[1]],
            max,
            count: [80, 80, 20, 20],
            periodic: [false, false, periodic, false],
        },
        solver: BTreeMap::new(),
        training: TrainingRecord::default(),
        verification: BTreeMap::new(),
        value_sha256: String::new(),
        hash: String::new(),
    }
}

/// A robot that can stop, among things at rest, judging by distance alone: safe, and provably so.
pub(crate) fn robot_that_can_stop() -> Model {
    let metadata = ModelMetadata {
        encoding: InputEncoding::Position,
        control: InputBox::new([0.0, -0.8], [1.0, 0.8]).unwrap(),
        ..metadata(DynamicsKind::UnicycleStaticPair)
    };
    Model::new(constant_residual(InputEncoding::Position, NO_RESIDUAL), metadata).unwrap()
}

/// The same robot without a brake: distance alone is no barrier for it.
pub(crate) fn robot_that_cannot_stop() -> Model {
    let metadata =
        ModelMetadata { encoding: InputEncoding::Position, ..metadata(DynamicsKind::UnicycleStaticPair) };
    Model::new(constant_residual(InputEncoding::Position, NO_RESIDUAL), metadata).unwrap()
}

/// Double integrators with `h = ℓ − softplus(bias)`.
pub(crate) fn quadrotor(bias: f32) -> Model {
    Model::new(constant_residual(InputEncoding::Raw, bias), metadata(DynamicsKind::DoubleIntegratorPair))
        .unwrap()
}

/// The weights the paper's authors published, where a copy lies beside the checkout.
pub(crate) fn published_quadrotor() -> Option<Model> {
    let path =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/anchors/quadrotor_published_v1.safetensors");
    let bytes = std::fs::read(path).ok()?;
    Some(Model::from_published(&bytes, metadata(DynamicsKind::DoubleIntegratorPair)).unwrap())
}

/// A short loop of the filter's usual kind.
pub(crate) fn scenario(rollouts: usize) -> ScenarioSettings {
    ScenarioSettings {
        rollouts,
        horizon_s: 5.0,
        period_s: 0.004,
        alpha_per_s: 4.0,
        slack_weight: 1e6,
        beta: 1e-6,
        tolerance_m: 1e-3,
        nominal: NominalPolicy::TowardObstacle,
        disturbance: DisturbancePolicy::LowersBarrier,
        levels_m: vec![0.0, 0.2],
        seed: 3,
    }
}
