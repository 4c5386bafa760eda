//! From a solve to a model file and back, and the trained network as the filter evaluates it.

// Helpers of tests may unwrap like the tests themselves.
#![allow(clippy::unwrap_used)]

use barrier::{DynamicsKind, Kernel, Model, NetworkBatch, ResidualNetwork};
use barrier_training::{
    ExportError, Recipe, ResidualGrid, TrainedModel, barrier_condition, evaluate, fit_error, parameters_of,
    to_model, train,
};
use dynamics::{InputBox, UnicyclePair};
use reachability::{
    Axis, Convergence, Dissipation, Grid, ProblemDescription, SolverSettings, TimeIntegrator, TubeForm,
    UpwindScheme, ValueFunction, disc_failure_function, solve,
};
use settings::TrainingSettings;
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::sync::OnceLock;

const RADIUS_M: f64 = 0.7;

fn pair() -> UnicyclePair {
    UnicyclePair {
        control: InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap(),
        disturbance: InputBox::new([-0.35], [0.35]).unwrap(),
    }
}

/// A value function far coarser than any in use.
fn coarse_value(dynamics: &str) -> ValueFunction {
    let grid = Grid::new([
        Axis::bounded(-4.0, 4.0, 14),
        Axis::bounded(-4.0, 4.0, 14),
        Axis::periodic(-PI, PI, 10),
        Axis::bounded(0.0, 1.5, 4),
    ])
    .unwrap();
    let settings = SolverSettings {
        upwind: UpwindScheme::FirstOrder,
        integrator: TimeIntegrator::Euler,
        dissipation: Dissipation::ReachableSpeed,
        tube: TubeForm::Variational,
        cfl: 0.75,
        max_horizon_s: 1.0,
        convergence: Convergence {
            check_interval_s: 0.5,
            unsafe_share_tolerance: 0.0,
            value_tolerance_m: None,
            boundary_layer: 0.0,
        },
    };
    let failure = disc_failure_function(RADIUS_M);
    let solution = solve(&pair(), &failure, &grid, &settings, &mut |_| ControlFlow::Continue(())).unwrap();
    let problem = ProblemDescription {
        dynamics: dynamics.to_owned(),
        control: (&pair().control).into(),
        disturbance: (&pair().disturbance).into(),
        failure_radius_m: RADIUS_M,
    };
    ValueFunction::new(solution, problem)
}

fn settings() -> TrainingSettings {
    TrainingSettings {
        seed: 8,
        epochs: 4,
        batch_size: 512,
        learning_rate: 8e-3,
        final_learning_rate: 1e-4,
        margin_m: 0.0,
    }
}

fn recipe() -> Recipe {
    Recipe { pool_samples: 1 << 14, ..Recipe::default() }
}

/// Solved and trained once for all tests of this file.
fn trained() -> &'static (ValueFunction, ResidualGrid, TrainedModel) {
    static TRAINED: OnceLock<(ValueFunction, ResidualGrid, TrainedModel)> = OnceLock::new();
    TRAINED.get_or_init(|| {
        let value = coarse_value("unicycle_pair");
        let target = ResidualGrid::try_from(&value).unwrap();
        let trained = train(&target, &settings(), &recipe(), &mut |_| ControlFlow::Continue(())).unwrap();
        (value, target, trained)
    })
}

#[test]
fn the_file_carries_the_weights_and_all_they_depend_on() {
    let (value, target, trained) = trained();
    let model = to_model(value, trained, &settings(), &recipe()).unwrap();
    let read = Model::from_bytes(&model.to_bytes().unwrap()).unwrap();
    assert_eq!(parameters_of(&read), trained.parameters);
    let metadata = read.metadata();
    assert_eq!(metadata.dynamics, DynamicsKind::UnicyclePair);
    assert_eq!((metadata.control, metadata.failure_radius_m), (pair().control, RADIUS_M));
    assert_eq!(metadata.disturbance.max, [0.35]);
    assert_eq!((metadata.grid.count, metadata.grid.periodic), ([14, 14, 10, 4], [false, false, true, false]));
    assert_eq!(metadata.value_sha256, value.metadata().value_sha256);
    assert_eq!(metadata.solver["horizon_s"], 1.0);
    assert_eq!(metadata.training.details["settings"]["learning_rate"], 8e-3);
    assert_eq!(metadata.training.details["recipe"]["pool_samples"], 1 << 14);
    assert_eq!(metadata.training.error_mean_m, fit_error(target, &parameters_of(&read)).outside.mean_m);
}

#[test]
fn the_filters_network_agrees_with_the_trained_one() {
    let (value, target, trained) = trained();
    let model = to_model(value, trained, &settings(), &recipe()).unwrap();
    let mut network = ResidualNetwork::new(model.weights(), Kernel::detect()).unwrap();
    let nodes = (0..target.node_count()).step_by(target.node_count() / 64).take(64);
    let states: Vec<[f32; 4]> = nodes.map(|node| target.state(node).map(|c| c as f32)).collect();
    let mut batch = NetworkBatch::new();
    batch.set_len(states.len());
    for (index, state) in states.iter().enumerate() {
        batch.set_state(index, state);
    }
    network.evaluate(&mut batch);
    for (index, (residual, gradient)) in evaluate(&trained.parameters, &states).into_iter().enumerate() {
        assert!((batch.residual(index) - residual).abs() < 1e-5);
        for k in 0..4 {
            assert!((batch.gradient(index)[k] - gradient[k]).abs() < 1e-4);
        }
    }
}

#[test]
fn the_barrier_condition_is_counted_where_the_fit_is_safe() {
    let (_, target, trained) = trained();
    let loose = barrier_condition(target, &trained.parameters, &pair(), 100.0);
    let tight = barrier_condition(target, &trained.parameters, &pair(), 0.0);
    let states: Vec<[f32; 4]> =
        (0..target.node_count()).map(|node| target.state(node).map(|c| c as f32)).collect();
    let fitted = evaluate(&trained.parameters, &states);
    let safe = fitted.iter().enumerate().filter(|(node, (residual, _))| {
        let z = target.state(*node);
        z[0].hypot(z[1]) - RADIUS_M - f64::from(*residual) >= 0.0
    });
    assert_eq!(loose.nodes, safe.count());
    assert!(loose.violated_share < tight.violated_share && loose.worst_mps > tight.worst_mps);
    // An obstacle that may turn without limit cannot make the condition easier to meet.
    let stronger = UnicyclePair { disturbance: InputBox::new([-2.0], [2.0]).unwrap(), ..pair() };
    let worse = barrier_condition(target, &trained.parameters, &stronger, 0.0);
    assert!(worse.violated_share > tight.violated_share && worse.worst_mps < tight.worst_mps);
}

#[test]
fn a_value_function_for_unknown_dynamics_is_refused() {
    let value = coarse_value("bicycle_pair");
    let refused = to_model(&value, &trained().2, &settings(), &recipe());
    assert!(matches!(refused, Err(ExportError::Dynamics { dynamics }) if dynamics == "bicycle_pair"));
}
