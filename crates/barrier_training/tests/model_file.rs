//! From a solve to a model file and back, and the trained network as the filter evaluates it.

// Helpers of tests may unwrap like the tests themselves.
#![allow(clippy::unwrap_used)]

use barrier::{DynamicsKind, InputEncoding, Kernel, Model, NetworkBatch, ResidualNetwork};
use barrier_training::{
    Judge, ResidualGrid, TrainSettingsError, Trained, Values, barrier_condition, evaluate, fit_error, game,
    network_of, train_settings,
};
use dynamics::{InputBox, UnicyclePair};
use reachability::{ValueFunction, solve_settings};
use settings::{Encoding, SampleSettings, Settings, SlackSettings, TargetSource, TrainingSettings};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::OnceLock;

use std::f64::consts::PI;

const RADIUS_M: f64 = 0.7;

fn pair() -> UnicyclePair {
    UnicyclePair {
        control: InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap(),
        disturbance: InputBox::new([-0.35], [0.35]).unwrap(),
    }
}

/// The shipped settings on a grid far coarser than any in use, and a short fit.
fn settings(encoding: Encoding) -> Settings {
    let text = include_str!("../../../config/ground_robot_paper.toml");
    let mut settings = Settings::parse(text, Path::new("test.toml"), Path::new("")).unwrap();
    let offline = settings.offline.as_mut().unwrap();
    (offline.grid.min, offline.grid.max) = ([-4.0, -4.0, -PI, 0.0], [4.0, 4.0, PI, 1.5]);
    offline.grid.count = [14, 14, 10, 4];
    offline.solver.accuracy = settings::Accuracy::Low;
    offline.solver.max_horizon_s = 1.0;
    offline.solver.unsafe_share_tolerance = 0.0;
    offline.training = TrainingSettings {
        epochs: 4,
        batch_size: 512,
        learning_rate: 8e-3,
        final_learning_rate: 1e-4,
        margin_m: 0.0,
        encoding,
        samples: SampleSettings { count: 1 << 14, ..SampleSettings::default() },
        ..offline.training.clone()
    };
    settings
}

fn solve(settings: &Settings) -> ValueFunction {
    solve_settings(settings, &mut |_| ControlFlow::Continue(())).unwrap()
}

fn fit(settings: &Settings, values: Values<'_>) -> Result<Trained, TrainSettingsError> {
    train_settings(settings, values, None, &mut |_| ControlFlow::Continue(()))
}

/// Solved and trained once for all tests of this file.
fn trained() -> &'static (ValueFunction, ResidualGrid, Trained) {
    static TRAINED: OnceLock<(ValueFunction, ResidualGrid, Trained)> = OnceLock::new();
    TRAINED.get_or_init(|| {
        let settings = settings(Encoding::HeadingCosSin);
        let value = solve(&settings);
        let target = ResidualGrid::try_from(&value).unwrap();
        let trained = fit(&settings, Values { solved: Some(&value), truth: None }).unwrap();
        (value, target, trained)
    })
}

#[test]
fn the_file_carries_the_weights_and_all_they_depend_on() {
    let (value, target, trained) = trained();
    let read = Model::from_bytes(&trained.model.to_bytes().unwrap()).unwrap();
    let metadata = read.metadata();
    assert_eq!(metadata.dynamics, DynamicsKind::UnicyclePair);
    assert_eq!(metadata.encoding, InputEncoding::HeadingCosSin);
    assert_eq!((metadata.control, metadata.failure_radius_m), (pair().control, RADIUS_M));
    assert_eq!(metadata.disturbance.max, [0.35]);
    assert_eq!((metadata.grid.count, metadata.grid.periodic), ([14, 14, 10, 4], [false, false, true, false]));
    assert_eq!(metadata.value_sha256, value.metadata().value_sha256);
    assert_eq!(metadata.solver["horizon_s"], 1.0);
    assert_eq!(metadata.training.details["settings"]["learning_rate"], 8e-3);
    assert_eq!(metadata.training.details["settings"]["samples"]["count"], 1 << 14);
    let fit = fit_error(&Judge::of_grid(target), &network_of(&read));
    assert_eq!(fit, trained.report.fit);
    assert_eq!(metadata.training.error_mean_m, fit.outside.mean_m);
    assert!(fit.seam_max_m < 1e-6, "cosine and sine leave no seam: {} m", fit.seam_max_m);
}

#[test]
fn the_raw_heading_leaves_a_seam_and_the_report_says_how_large() {
    let settings = settings(Encoding::Raw);
    let raw = fit(&settings, Values { solved: Some(&trained().0), truth: None }).unwrap();
    assert!(raw.report.fit.seam_max_m > 1e-4, "{} m", raw.report.fit.seam_max_m);
}

#[test]
fn the_filters_network_agrees_with_the_trained_one() {
    let (_, target, trained) = trained();
    let mut network = ResidualNetwork::new(trained.model.weights(), Kernel::detect()).unwrap();
    let nodes = (0..target.node_count()).step_by(target.node_count() / 64).take(64);
    let states: Vec<[f32; 4]> = nodes.map(|node| target.state(node).map(|c| c as f32)).collect();
    let mut batch = NetworkBatch::new();
    batch.set_len(states.len());
    for (index, state) in states.iter().enumerate() {
        batch.set_state(index, state);
    }
    network.evaluate(&mut batch);
    let fitted = evaluate(&network_of(&trained.model), &states);
    for (index, (residual, gradient)) in fitted.into_iter().enumerate() {
        assert!((batch.residual(index) - residual).abs() < 1e-5);
        for k in 0..4 {
            assert!((batch.gradient(index)[k] - gradient[k]).abs() < 1e-4);
        }
    }
}

#[test]
fn the_barrier_condition_is_counted_where_the_fit_is_safe() {
    let (_, target, trained) = trained();
    let (network, judge) = (network_of(&trained.model), Judge::of_grid(target));
    let condition =
        |pair: UnicyclePair, alpha| barrier_condition(&judge.states, &network, RADIUS_M, &*game(pair), alpha);
    let (loose, tight) = (condition(pair(), 100.0), condition(pair(), 0.0));
    let states: Vec<[f32; 4]> = judge.states.iter().map(|z| z.map(|c| c as f32)).collect();
    let fitted = evaluate(&network, &states);
    let safe = judge.states.iter().zip(&fitted).filter(|(z, (residual, _))| {
        let failure = z[0].hypot(z[1]) - RADIUS_M;
        failure > 0.0 && failure - f64::from(*residual) >= 0.0
    });
    assert_eq!(loose.states, safe.count());
    assert!(loose.violated_share < tight.violated_share && loose.worst_mps > tight.worst_mps);
    // An obstacle that may turn without limit cannot make the condition easier to meet.
    let stronger = UnicyclePair { disturbance: InputBox::new([-2.0], [2.0]).unwrap(), ..pair() };
    let worse = condition(stronger, 0.0);
    assert!(worse.violated_share > tight.violated_share && worse.worst_mps < tight.worst_mps);
}

#[test]
fn a_model_of_a_stricter_game_states_the_true_boxes_and_is_measured_against_the_true_value() {
    let mut strict = settings(Encoding::HeadingCosSin);
    let slack = SlackSettings { control_scale: 0.5, disturbance_scale: 2.0 };
    strict.offline.as_mut().unwrap().slack = Some(slack);
    let (truth, _, plain) = trained();
    let solved = solve(&strict);
    let model = fit(&strict, Values { solved: Some(&solved), truth: Some(truth) }).unwrap();
    let metadata = model.model.metadata();
    assert_eq!((metadata.control, &metadata.disturbance.max[..]), (pair().control, &[0.35][..]));
    let details = &metadata.training.details;
    assert_eq!(details["slack"]["control_scale"], 0.5);
    assert_eq!(details["solved_game"]["disturbance"]["max"][0], 0.7);
    assert_eq!(metadata.value_sha256, solved.metadata().value_sha256);
    let (bias, plain) = (model.report.fit.near_zero.bias_m, plain.report.fit.near_zero.bias_m);
    assert!(bias < plain - 0.05, "{bias} m against the true value, {plain} m without slack");

    let refused = fit(&strict, Values { solved: Some(truth), truth: None }).unwrap_err();
    assert!(matches!(refused, TrainSettingsError::OtherGame { which: "solved", .. }), "{refused}");
}

#[test]
fn a_closed_form_is_fitted_without_a_grid_and_only_for_double_integrators() {
    let text = include_str!("../../../config/quadrotor_paper.toml");
    let mut quadrotor = Settings::parse(text, Path::new("test.toml"), Path::new("")).unwrap();
    let training = &mut quadrotor.offline.as_mut().unwrap().training;
    (training.epochs, training.samples.count) = (1, 1 << 12);
    let model = fit(&quadrotor, Values::default()).unwrap().model;
    let metadata = model.metadata();
    assert_eq!((metadata.dynamics, metadata.value_sha256.as_str()), (DynamicsKind::DoubleIntegratorPair, ""));
    assert_eq!((metadata.grid.min[3], metadata.encoding), (-3.5, InputEncoding::Raw));

    let mut ground = settings(Encoding::Raw);
    assert!(matches!(fit(&ground, Values::default()), Err(TrainSettingsError::NoValue)));
    ground.offline.as_mut().unwrap().training.target = TargetSource::ClosedForm;
    assert!(matches!(fit(&ground, Values::default()), Err(TrainSettingsError::NoClosedForm)));
}
