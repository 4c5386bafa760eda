//! The models in `models/` against stored samples of the value functions they were fitted to, evaluated as the filter does.

// Helpers of tests may unwrap like the tests themselves.
#![allow(clippy::unwrap_used)]

use barrier::{Kernel, Model, RelativeBarrier, RelativeObstacle, RelativeSample};
use dynamics::InputBox;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use reachability::closed_form::DoubleIntegratorValue;
use serde::Deserialize;
use serde_json::{Value, json, to_value};
use settings::{Settings, TargetSource, TrainingSettings};
use std::path::{Path, PathBuf};

/// Models fitted to the true game, of which samples are stored, and those that learned from a stricter one.
const FAITHFUL: &str = "ground_robot_paper";
const CAUTIOUS: &str = "ground_robot";

/// Bounds on the absolute error of the faithful model against the reference, m. Measured: mean 8 and p99 47 mm everywhere, 15 and
/// 70 mm near the zero level. At the nodes the same model is within 5.4 and 13.6 mm, 5 mm of it the margin: the rest is the
/// reference's linear interpolation, which cuts corners that the network rounds.
const EVEN_MEAN_M: f64 = 0.012;
const EVEN_P99_M: f64 = 0.06;
const NEAR_MEAN_M: f64 = 0.02;
const NEAR_P99_M: f64 = 0.09;
/// Bound on the mean distance of its gradients. Measured: 0.073.
const GRADIENT_MEAN: f64 = 0.1;

/// Samples of the solved value function; the file names the commands that made it.
#[derive(Deserialize)]
struct Reference {
    value_sha256: String,
    even: Vec<Sample>,
    near_zero_level: Vec<Sample>,
}

#[derive(Deserialize)]
struct Sample {
    z: [f64; 4],
    value: f64,
    gradient: [f64; 4],
}

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

/// Names of the shipped models, which are also those of their configurations.
const SHIPPED: [&str; 6] =
    ["ground_robot", "ground_robot_paper", "quadrotor", "quadrotor_paper", "static_obstacles", "cyclist"];

fn model(name: &str) -> Model {
    Model::load(&repository(&format!("models/{name}.safetensors"))).unwrap()
}

fn reference(name: &str) -> Reference {
    let file = repository(&format!("tests/data/value_reference_{name}.json"));
    serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap()
}

fn evaluate(model: &Model, states: impl Iterator<Item = [f64; 4]>) -> Vec<RelativeSample> {
    let radius_m = model.metadata().failure_radius_m;
    let obstacles: Vec<_> = states.map(|z| RelativeObstacle { z, radius_m }).collect();
    let mut samples = vec![RelativeSample::default(); obstacles.len()];
    RelativeBarrier::new(model, Kernel::detect()).unwrap().evaluate(&obstacles, &mut samples);
    samples
}

/// Pairs outside the failure set.
fn outside<'a>(model: &Model, samples: &'a [Sample]) -> Vec<(&'a Sample, RelativeSample)> {
    let fitted = evaluate(model, samples.iter().map(|s| s.z));
    samples.iter().zip(fitted).filter(|(_, fitted)| fitted.sdf > 0.0).collect()
}

fn mean_and_p99(mut errors: Vec<f64>) -> (f64, f64) {
    errors.sort_by(f64::total_cmp);
    (errors.iter().sum::<f64>() / errors.len() as f64, errors[(errors.len() - 1) * 99 / 100])
}

#[test]
fn reference_and_model_stem_from_the_same_solve() {
    assert_eq!(reference(FAITHFUL).value_sha256, model(FAITHFUL).metadata().value_sha256);
}

#[test]
fn value_is_close_to_the_reference_everywhere() {
    let (model, reference) = (model(FAITHFUL), reference(FAITHFUL));
    let pairs = outside(&model, &reference.even);
    let (mean, p99) = mean_and_p99(pairs.iter().map(|(s, h)| (h.h_bar - s.value).abs()).collect());
    assert!(mean < EVEN_MEAN_M && p99 < EVEN_P99_M, "mean {mean} m, p99 {p99} m");
}

#[test]
fn value_near_the_zero_level_is_close_and_errs_to_the_safe_side() {
    let (model, reference) = (model(FAITHFUL), reference(FAITHFUL));
    let pairs = outside(&model, &reference.near_zero_level);
    let (mean, p99) = mean_and_p99(pairs.iter().map(|(s, h)| (h.h_bar - s.value).abs()).collect());
    assert!(mean < NEAR_MEAN_M && p99 < NEAR_P99_M, "mean {mean} m, p99 {p99} m");
}

#[test]
fn models_of_grids_err_to_the_safe_side() {
    for name in [FAITHFUL, CAUTIOUS] {
        let (model, reference) = (model(name), reference(name));
        let pairs = outside(&model, &reference.near_zero_level);
        let bias = pairs.iter().map(|(s, h)| h.h_bar - s.value).sum::<f64>() / pairs.len() as f64;
        assert!(bias < 0.0, "{name}: {bias} m");
        let unsafe_states = pairs.iter().filter(|(s, _)| s.value < 0.0);
        let called_safe = unsafe_states.clone().filter(|(_, h)| h.h_bar >= 0.0).count();
        let all = unsafe_states.count();
        assert!(called_safe * 100 <= all, "{name}: {called_safe} of {all} unsafe states are called safe");
    }
}

#[test]
fn gradient_is_close_to_the_reference() {
    let distance = |a: &[f64; 4], b: &[f64; 4]| (0..4).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
    let (model, reference) = (model(FAITHFUL), reference(FAITHFUL));
    let pairs = outside(&model, &reference.even);
    let (mean, _) = mean_and_p99(pairs.iter().map(|(s, h)| distance(&s.gradient, &h.gradient)).collect());
    assert!(mean < GRADIENT_MEAN, "{mean}");
}

/// Against the exact value at random states: the faithful model's error, and on which side of zero the other errs.
#[test]
fn quadrotors_meet_the_closed_form() {
    let mut rng = Pcg64::seed_from_u64(43);
    let states: Vec<[f64; 4]> = (0..200_000)
        .map(|_| [4.0, 4.0, 3.5, 3.5].map(|half| rng.random_range(-half..half)))
        .filter(|z: &[f64; 4]| z[0].hypot(z[1]) > 0.7)
        .collect();
    let (control, disturbance) = (InputBox::new([-2.0; 2], [2.0; 2]), InputBox::new([-1.0; 2], [1.0; 2]));
    let truth = DoubleIntegratorValue::new(&control.unwrap(), &disturbance.unwrap(), 0.7).unwrap();
    let values: Vec<f64> = states.iter().map(|z| truth.value_m(z)).collect();

    let fitted = evaluate(&model("quadrotor_paper"), states.iter().copied());
    let errors = fitted.iter().zip(&values).map(|(h, value)| (h.h_bar - value).abs()).collect();
    let (mean, p99) = mean_and_p99(errors);
    assert!(mean < 0.004 && p99 < 0.03, "mean {mean} m, p99 {p99} m");

    let cautious = evaluate(&model("quadrotor"), states.iter().copied());
    let (mut shell, mut called_safe, mut safe, mut called_unsafe) = (0, 0, 0, 0);
    for (h, &value) in cautious.iter().zip(&values) {
        if value < 0.0 {
            shell += 1;
            called_safe += usize::from(h.h_bar >= 0.0);
        } else {
            safe += 1;
            called_unsafe += usize::from(h.h_bar < 0.0);
        }
    }
    assert!(called_safe * 500 <= shell, "{called_safe} of {shell} unsafe states are called safe");
    assert!(called_unsafe * 100 <= safe, "{called_unsafe} of {safe} safe states are called unsafe");
}

#[test]
fn every_model_carries_its_verification() {
    for name in SHIPPED {
        let model = model(name);
        let found = &model.metadata().verification;
        assert_eq!(found["structural"]["holds"], json!(true), "{name}");
        assert_eq!(found["scenario"]["settings"]["rollouts"], json!(138_149), "{name}");
        assert!(found["value_error"]["shell_called_safe"]["of"].as_u64().unwrap() > 5_000, "{name}");
        assert!(found.contains_key("condition"), "{name}");
    }
}

#[test]
fn value_never_exceeds_the_failure_function() {
    for name in SHIPPED {
        let mut rng = Pcg64::seed_from_u64(41);
        let states = (0..100_000).map(|_| {
            let mut within = |half: f64| rng.random_range(-half..half);
            [within(8.0), within(8.0), within(4.0), within(3.0)]
        });
        assert!(evaluate(&model(name), states).iter().all(|sample| sample.h_bar <= sample.sdf), "{name}");
    }
}

#[test]
fn the_configurations_name_what_the_models_were_made_with() {
    SHIPPED.into_iter().for_each(check_configuration);
}

fn check_configuration(name: &str) {
    let model = model(name);
    let metadata = model.metadata();
    let settings = Settings::load(&repository(&format!("config/{name}.toml"))).unwrap();
    assert_eq!(metadata.failure_radius_m, settings.failure_radius_m());
    assert_eq!(metadata.control.min, settings.robot.control_min);
    assert_eq!(metadata.control.max, settings.robot.control_max);
    assert_eq!(metadata.disturbance.min, settings.obstacle.disturbance_min);
    assert_eq!(metadata.disturbance.max, settings.obstacle.disturbance_max);
    let offline = settings.offline.unwrap();
    let grid = &offline.grid;
    let expected =
        json!({ "min": grid.min, "max": grid.max, "count": grid.count, "periodic": grid.periodic });
    assert_eq!(to_value(metadata.grid).unwrap(), expected);
    let solver = to_value(reachability::SolverSettings::from(&offline.solver)).unwrap();
    for (name, expected) in solver.as_object().unwrap() {
        match offline.training.target {
            TargetSource::Grid => assert_eq!(&metadata.solver[name], expected, "solver setting `{name}`"),
            TargetSource::ClosedForm => assert!(metadata.solver.is_empty(), "nothing was solved"),
        }
    }
    assert_eq!(training_of(&metadata.training.details), offline.training);
}

/// The settings a model was trained with.
fn training_of(details: &std::collections::BTreeMap<String, Value>) -> TrainingSettings {
    serde_json::from_value(details["settings"].clone()).unwrap()
}
