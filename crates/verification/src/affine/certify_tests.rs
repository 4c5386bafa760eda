//! The search against networks whose truth is known, its budget, and what a checkpoint gives back.

use std::ops::ControlFlow;
use std::path::Path;

use barrier::{DynamicsKind, InputEncoding, Kernel, Model};

use super::super::test_models::{RADIUS_M, constant_model, metadata, random_model};
use super::{AffineError, AffineProgress, AffineRecord, AffineSettings, certify};
use crate::affine::{Outcome, StateBox};

const ALPHA_PER_S: f64 = 4.0;

/// `r` is 2e-9 everywhere, so `h̄ = ℓ`: among things that stand still `C` is lowest where one lies straight ahead at the
/// edge of the disc, and is then minus the lowest speed, 0.25 m/s.
fn blind_among_still_things() -> (Model, StateBox) {
    let model =
        constant_model(metadata(DynamicsKind::UnicycleStaticPair, InputEncoding::Position, 1.0), -20.0);
    (model, StateBox { min: [-1.5, -1.5, 0.0, 0.0], max: [1.5, 1.5, 0.0, 0.0] })
}

fn go_on(_: &AffineProgress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn run(model: &Model, settings: &AffineSettings) -> AffineRecord {
    certify(model, Kernel::Portable, settings, None, &mut go_on).unwrap()
}

fn assert_complete(record: &AffineRecord) {
    let shares = [record.outside_share, record.proven_share, record.weaker_share, record.undecided_share];
    assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{shares:?}");
}

#[test]
fn a_true_statement_is_proven() {
    let (model, region) = blind_among_still_things();
    let record = run(&model, &AffineSettings::new(region, ALPHA_PER_S, 0.3));
    assert_eq!(record.outcome, Outcome::Proven);
    assert_eq!(record.proven_epsilon_mps, Some(0.3));
    assert_eq!(record.radius_inflation_m, Some(0.3 / ALPHA_PER_S));
    assert_complete(&record);
    // Cells across the edge of the disc count as proven, for what of them lies in the set.
    let disc = std::f64::consts::PI * RADIUS_M * RADIUS_M / 9.0;
    assert!(record.outside_share < disc && record.outside_share > 0.5 * disc, "{}", record.outside_share);
}

#[test]
fn a_false_statement_is_refuted_and_the_smallest_true_one_found() {
    let (model, region) = blind_among_still_things();
    let record = run(&model, &AffineSettings::new(region, ALPHA_PER_S, 0.2));
    assert_eq!(record.outcome, Outcome::Refuted);
    let worst = record.worst.unwrap();
    assert!((-0.25..-0.2).contains(&worst.condition_mps) && worst.barrier_m > 0.0, "{worst:?}");
    assert!(worst.z[0] > 0.0, "ahead, where driving on brings it nearer: {worst:?}");
    let proven = record.proven_epsilon_mps.unwrap();
    assert!((0.25..=0.05 - worst.condition_mps).contains(&proven), "{proven}");
    assert_complete(&record);
}

#[test]
fn the_closing_speed_of_a_blind_double_integrator_is_found() {
    let model = constant_model(metadata(DynamicsKind::DoubleIntegratorPair, InputEncoding::Raw, 1.0), -20.0);
    let region = StateBox { min: [-1.0; 4], max: [1.0; 4] };
    let mut settings = AffineSettings::new(region, ALPHA_PER_S, 0.1);
    settings.gap_mps = 0.2;
    let record = run(&model, &settings);
    let proven = record.proven_epsilon_mps.unwrap();
    assert!(proven >= 2.0_f64.sqrt() && proven < 2.0_f64.sqrt() + 0.2, "{proven}");
    assert!(record.worst.unwrap().condition_mps > -2.0_f64.sqrt());
}

#[test]
fn too_small_a_budget_leaves_it_open_and_says_so() {
    let (model, region) = blind_among_still_things();
    let mut settings = AffineSettings::new(region, ALPHA_PER_S, 0.3);
    settings.boxes = 20;
    let record = run(&model, &settings);
    assert_eq!((record.outcome, record.boxes), (Outcome::Undecided, 20));
    assert!(record.undecided_share > 0.1, "{}", record.undecided_share);
    assert!(record.proven_epsilon_mps.is_none_or(|proven| proven > 0.3));
    assert!(record.to_string().starts_with("undecided"), "{record}");
    assert_complete(&record);
}

fn moving() -> (Model, AffineSettings) {
    let model = random_model(metadata(DynamicsKind::UnicyclePair, InputEncoding::HeadingCosSin, 1.0), 9, 1.2);
    let region = StateBox { min: [0.7, -0.5, -0.6, 0.1], max: [1.5, 0.6, 0.5, 0.8] };
    (model, AffineSettings::new(region, ALPHA_PER_S, 0.05))
}

/// Stops after `waves` waves and keeps the search at `path`.
fn run_some(model: &Model, settings: &AffineSettings, path: &Path, waves: usize) -> AffineRecord {
    let mut seen = 0;
    let mut on_progress = |_: &AffineProgress| {
        seen += 1;
        if seen == waves { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    certify(model, Kernel::Portable, settings, Some(path), &mut on_progress).unwrap()
}

#[test]
fn a_search_cut_in_three_ends_as_one_in_one_go() {
    let (model, settings) = moving();
    let whole = run(&model, &settings);
    assert!(whole.boxes > 200, "{}: too easy to test anything", whole.boxes);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("search.safetensors");
    let first = run_some(&model, &settings, &path, 4);
    let second = run_some(&model, &settings, &path, 3);
    assert!(first.boxes < second.boxes && second.boxes < whole.boxes);
    assert!(first.undecided_share > 0.0);
    let last = certify(&model, Kernel::Portable, &settings, Some(&path), &mut go_on).unwrap();
    assert_eq!(last, whole);
    let again = certify(&model, Kernel::Portable, &settings, Some(&path), &mut go_on).unwrap();
    assert_eq!(again, whole, "a finished search has nothing left to do");
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let (model, settings) = moving();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&model, &settings))
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn a_checkpoint_of_another_question_is_refused() {
    let (model, settings) = moving();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("search.safetensors");
    run_some(&model, &settings, &path, 3);
    let refused = |model: &Model, settings: &AffineSettings| match certify(
        model,
        Kernel::Portable,
        settings,
        Some(&path),
        &mut go_on,
    )
    .unwrap_err()
    {
        AffineError::AnotherQuestion { what, .. } => what,
        other => panic!("{other}"),
    };
    assert_eq!(refused(&model, &AffineSettings { alpha_per_s: 3.0, ..settings }), "alpha_per_s");
    assert_eq!(refused(&model, &AffineSettings { epsilon_mps: 0.06, ..settings }), "epsilon_mps");
    let mut region = settings.region;
    region.max[1] += 1e-12;
    assert_eq!(refused(&model, &AffineSettings { region, ..settings }), "region");
    let mut metadata = model.metadata().clone();
    metadata.failure_radius_m += 0.01;
    let other = Model::new(model.weights().clone(), metadata).unwrap();
    assert_eq!(refused(&other, &settings), "model");
}

#[test]
fn a_damaged_checkpoint_is_refused() {
    let (model, settings) = moving();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("search.safetensors");
    run_some(&model, &settings, &path, 5);
    let bytes = std::fs::read(&path).unwrap();
    let mut other_cell = bytes.clone();
    *other_cell.last_mut().unwrap() ^= 0xff;
    for damaged in [&bytes[..bytes.len() - 9], &b"no checkpoint"[..], &other_cell] {
        std::fs::write(&path, damaged).unwrap();
        let error = certify(&model, Kernel::Portable, &settings, Some(&path), &mut go_on).unwrap_err();
        assert!(matches!(error, AffineError::NoCheckpoint { .. }), "{error}");
    }
}

#[test]
fn unusable_settings_are_refused_before_any_work() {
    let (model, settings) = moving();
    let error = |settings| certify(&model, Kernel::Portable, &settings, None, &mut go_on).unwrap_err();
    let with = |change: &dyn Fn(&mut AffineSettings)| {
        let mut settings = settings;
        change(&mut settings);
        error(settings)
    };
    assert!(matches!(with(&|s| s.region.min[2] = 0.51), AffineError::Region { axis: 2, .. }));
    assert!(matches!(with(&|s| s.region.max[0] = 6.5), AffineError::OutsideDomain { axis: 0, .. }));
    assert!(matches!(with(&|s| s.alpha_per_s = 0.0), AffineError::NotPositive { name: "alpha_per_s", .. }));
    assert!(matches!(with(&|s| s.epsilon_mps = f64::NAN), AffineError::NotPositive { .. }));
}
