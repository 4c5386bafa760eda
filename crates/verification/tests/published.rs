//! The published quadrotor weights against their closed form, judged by an independent numpy implementation.

mod common;

use barrier::Kernel;
use common::{go_on, published_quadrotor};
use serde::Deserialize;
use verification::{
    ClosedForm, ConditionSettings, Share, Subject, ValueErrorSettings, measure_condition, measure_value_error,
};

/// What `tests/judges/verification_reference.py` found.
#[derive(Deserialize)]
struct Reference {
    error: Errors,
    shell_called_safe: Count,
    safe_called_unsafe: Count,
    condition: Condition,
}

#[derive(Deserialize)]
struct Errors {
    bias_m: f64,
    mean_m: f64,
    p99_m: f64,
    near_zero_mean_m: f64,
}

#[derive(Deserialize)]
struct Count {
    count: usize,
    of: usize,
}

#[derive(Deserialize)]
struct Condition {
    alpha_per_s: f64,
    violated_safe: Count,
    violated_band_above: Count,
    violated_band: Count,
    worst_sampled_mps: f64,
    median_safe_mps: f64,
}

/// Whether two shares are one, up to five standard deviations of their difference.
fn agree(ours: &Share, theirs: &Count) {
    let judge = Share::new(theirs.count, theirs.of);
    let variance = |share: &Share| share.share * (1.0 - share.share) / share.of as f64;
    let deviation = (variance(ours) + variance(&judge)).sqrt();
    assert!((ours.share - judge.share).abs() < 5.0 * deviation, "{ours:?} against {judge:?}");
}

#[test]
fn the_published_weights_are_judged_as_by_numpy() {
    let Some(model) = published_quadrotor() else {
        println!("skipped: no published weights beside the checkout");
        return;
    };
    let text = include_str!("../../../tests/data/verification_reference.json");
    let reference: Reference = serde_json::from_str(text).unwrap();
    let subject = Subject::new(&model, Kernel::detect()).unwrap();

    let truth = ClosedForm::of(model.metadata()).unwrap();
    let settings = ValueErrorSettings { states: 100_000, shell_states: 300_000, seed: 11 };
    let ours = measure_value_error(&subject, &truth, &settings, &mut go_on).unwrap();
    // Standard deviations of 100,000 samples: mean 0.0001 m, p99 0.002 m, near-zero mean 0.0006 m; the truth's grids add 0.0001 m.
    let judge = &reference.error;
    assert!((ours.error.mean_m - judge.mean_m).abs() < 5e-4, "{:?}", ours.error);
    assert!((ours.error.bias_m - judge.bias_m).abs() < 5e-4, "{:?}", ours.error);
    assert!((ours.error.p99_m - judge.p99_m).abs() < 8e-3, "{:?}", ours.error);
    assert!((ours.near_zero.mean_m - judge.near_zero_mean_m).abs() < 4e-3, "{:?}", ours.near_zero);
    agree(&ours.shell_called_safe, &reference.shell_called_safe);
    agree(&ours.safe_called_unsafe, &reference.safe_called_unsafe);

    let judge = &reference.condition;
    let alpha_per_s = judge.alpha_per_s;
    let settings = ConditionSettings { alpha_per_s, states: 500_000, search_steps: 200, seed: 11 };
    let ours = measure_condition(&subject, &settings, &mut go_on).unwrap();
    agree(&ours.violated_safe, &judge.violated_safe);
    agree(&ours.violated_band_above, &judge.violated_band_above);
    agree(&ours.violated_band, &judge.violated_band);
    assert!((ours.quantiles_safe_mps[3] - judge.median_safe_mps).abs() < 0.05, "{ours:?}");
    // The search starts where sampling ends, and four times fewer samples must not hide what numpy saw.
    assert!(ours.worst_mps <= judge.worst_sampled_mps, "{} m/s", ours.worst_mps);
}
