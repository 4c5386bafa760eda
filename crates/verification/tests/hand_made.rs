//! Models whose verdict follows by hand: what holds must be called so, what is broken must show.

#![allow(clippy::unwrap_used)] // helpers of a test may panic

mod common;

use std::ops::ControlFlow;

use barrier::{Kernel, Model, ModelMetadata};
use common::{go_on, quadrotor, robot_that_can_stop, robot_that_cannot_stop, scenario};
use verification::{
    ClosedForm, ConditionSettings, DisturbancePolicy, NominalPolicy, Subject, TrueValue, ValueErrorSettings,
    Verification, VerificationError, VerificationPlan, certify_by_rollouts, check_structure,
    measure_condition, measure_value_error, verify,
};

fn subject(model: &Model) -> Subject<'_> {
    Subject::new(model, Kernel::detect()).unwrap()
}

fn condition(alpha_per_s: f64) -> ConditionSettings {
    ConditionSettings { alpha_per_s, states: 200_000, search_steps: 200, seed: 1 }
}

#[test]
fn the_failure_set_is_never_called_safe() {
    for model in [quadrotor(0.0), robot_that_can_stop()] {
        let record = check_structure(&subject(&model), 50_000, 1, &mut go_on).unwrap();
        assert!(record.holds, "{record:?}");
        assert_eq!(
            (record.states, record.above_failure_function, record.failure_called_safe),
            (50_000, 0, 0)
        );
        assert!((24_000..30_000).contains(&record.states_in_failure), "{}", record.states_in_failure);
    }
    // softplus(0) = ln 2 wherever it is asked.
    let record = check_structure(&subject(&quadrotor(0.0)), 1000, 1, &mut go_on).unwrap();
    assert!((record.residual_bound_m - 2.0_f64.ln()).abs() < 1e-12 && record.sine_argument_bound_rad == 0.0);
    assert!((record.residual_min_m - 2.0_f64.ln()).abs() < 1e-6, "{}", record.residual_min_m);
}

#[test]
fn a_robot_that_can_stop_meets_the_condition_everywhere() {
    // C = max_v (−v cos ψ) + α ℓ ≥ α ℓ ≥ 0, zero on the boundary ahead.
    let record = measure_condition(&subject(&robot_that_can_stop()), &condition(4.0), &mut go_on).unwrap();
    assert_eq!((record.violated_safe.count, record.violated_band_above.count), (0, 0));
    assert!(record.worst_mps >= 0.0 && record.worst_mps < 1e-3, "{}", record.worst_mps);
    assert_eq!((record.epsilon_mps, record.inflation_m), (0.0, 0.0));
    assert!(record.inflation_covers);
    assert_eq!(record.violation_free_inflation_m, Some(0.0));
}

#[test]
fn a_robot_that_cannot_stop_violates_it_by_its_least_speed() {
    // Straight ahead C = −0.25 + 4 h, lowest on the boundary: the search must get there.
    let record = measure_condition(&subject(&robot_that_cannot_stop()), &condition(4.0), &mut go_on).unwrap();
    assert!((record.worst_mps + 0.25).abs() < 1e-4, "{}", record.worst_mps);
    assert!(record.worst_mps <= record.worst_sampled_mps);
    assert!(record.worst_state[0] > 0.69 && record.worst_state[1].abs() < 0.05, "{:?}", record.worst_state);
    assert!((record.inflation_m - 0.25 / 4.0).abs() < 1e-4);
    // h < 0 still means C falls further, so 6 cm cover nothing; no inflation helps a robot that rams.
    assert!(!record.inflation_covers);
    assert_eq!(record.violation_free_inflation_m, None);
    // C < 0 where cos ψ > 16 h. At h = 0.025 m that is ψ below acos 0.4, 0.369 of the circle; the mean of acos(16 h)/π over
    // 0 ≤ h < 0.05 m, weighted with the radius 0.7 + h, is 0.3623 by quadrature.
    let share = &record.violated_band_above;
    assert!(share.low <= 0.3623 && 0.3623 <= share.high, "{share:?}");
}

#[test]
fn a_faster_class_kappa_needs_more_of_the_robot_near_the_boundary_only() {
    let model = robot_that_cannot_stop();
    let (slow, fast) = (
        measure_condition(&subject(&model), &condition(1.0), &mut go_on).unwrap(),
        measure_condition(&subject(&model), &condition(8.0), &mut go_on).unwrap(),
    );
    assert!(slow.violated_safe.share > fast.violated_safe.share);
    assert!(slow.inflation_m > fast.inflation_m);
}

#[test]
fn a_robot_that_can_stop_never_touches() {
    for nominal in [NominalPolicy::TowardObstacle, NominalPolicy::LowersBarrier, NominalPolicy::Random] {
        let model = robot_that_can_stop();
        let settings = verification::ScenarioSettings { nominal, ..scenario(688) };
        let record = certify_by_rollouts(&subject(&model), &settings, &mut go_on).unwrap();
        assert_eq!((record.rows[0].rollouts, record.rows[0].failures), (688, 0), "{nominal:?}");
        assert!(record.closest.clearance_m > -1e-4, "{nominal:?}: {:?}", record.closest);
        assert!(record.highest_failing_start_m.is_none());
        assert!((record.rows[0].epsilon - (1.0 - 1e-6_f64.powf(1.0 / 688.0))).abs() < 1e-9);
        assert!(record.rows[1].rollouts < 688 && record.rows[1].epsilon > record.rows[0].epsilon);
    }
    // Driving at the obstacle really leads there: the closest pair stands before it.
    let model = robot_that_can_stop();
    let record = certify_by_rollouts(&subject(&model), &scenario(688), &mut go_on).unwrap();
    assert!(record.closest.clearance_m < 0.01, "{}", record.closest.clearance_m);
}

#[test]
fn a_robot_that_cannot_stop_is_caught_ramming() {
    let model = robot_that_cannot_stop();
    let record = certify_by_rollouts(&subject(&model), &scenario(688), &mut go_on).unwrap();
    let row = &record.rows[0];
    assert!(row.failures > 300 && row.epsilon > 0.4, "{row:?}");
    assert_eq!(record.depths[1].rollouts, row.failures);
    assert!(record.closest.clearance_m < -0.5, "it drives through the centre: {:?}", record.closest);
    assert!(record.highest_failing_start_m.is_some());
}

#[test]
fn distance_alone_is_no_barrier_for_double_integrators_and_shows_as_such() {
    let model = quadrotor(common::NO_RESIDUAL);
    let truth = ClosedForm::of(model.metadata()).unwrap();
    let settings = ValueErrorSettings { states: 20_000, shell_states: 100_000, seed: 1 };
    let record = measure_value_error(&subject(&model), &truth, &settings, &mut go_on).unwrap();
    // h = ℓ ≥ V: every shell state is called safe, none of the safe states unsafe.
    assert_eq!(record.shell_called_safe.share, 1.0);
    assert_eq!(record.safe_called_unsafe.count, 0);
    let error = &record.error;
    assert!(error.bias_m > 0.1 && (error.bias_m - error.mean_m).abs() < 1e-9, "{error:?}");
    assert!(record.shell_called_safe_worst_m < -0.6, "{}", record.shell_called_safe_worst_m);
    let z = record.shell_called_safe_worst_state.unwrap();
    assert_eq!(truth.value_m(&z), Some(record.shell_called_safe_worst_m));

    let rollouts = certify_by_rollouts(&subject(&model), &scenario(512), &mut go_on).unwrap();
    assert!(rollouts.rows[0].failures_in_box > 100, "{:?}", rollouts.rows[0]);
}

#[test]
fn nothing_called_safe_is_an_error_and_not_a_certificate() {
    let model = quadrotor(50.0);
    let refused = certify_by_rollouts(&subject(&model), &scenario(64), &mut go_on);
    assert!(matches!(refused, Err(VerificationError::NoSafeState { .. })));
    let refused = measure_condition(&subject(&model), &condition(4.0), &mut go_on);
    assert!(matches!(refused, Err(VerificationError::NoSafeState { .. })));
}

#[test]
fn settings_without_sense_are_refused_by_name() {
    let model = quadrotor(0.0);
    let mut settings = scenario(64);
    settings.beta = 1.0;
    let refused = certify_by_rollouts(&subject(&model), &settings, &mut go_on).unwrap_err();
    assert!(matches!(refused, VerificationError::Setting { field: "beta", .. }));
    let refused = measure_condition(&subject(&model), &condition(0.0), &mut go_on).unwrap_err();
    assert!(matches!(refused, VerificationError::Setting { field: "alpha_per_s", .. }));
}

#[test]
fn a_model_without_room_outside_its_failure_disc_is_refused() {
    let metadata = ModelMetadata { failure_radius_m: 6.0, ..quadrotor(0.0).metadata().clone() };
    let model = Model::new(quadrotor(0.0).weights().clone(), metadata).unwrap();
    assert!(matches!(Subject::new(&model, Kernel::detect()), Err(VerificationError::NothingOutside { .. })));
}

#[test]
fn the_truth_of_another_game_is_refused() {
    let stronger = ModelMetadata { failure_radius_m: 0.8, ..quadrotor(0.0).metadata().clone() };
    let truth = ClosedForm::of(&stronger).unwrap();
    let settings = ValueErrorSettings { states: 64, shell_states: 64, seed: 1 };
    let refused = measure_value_error(&subject(&quadrotor(0.0)), &truth, &settings, &mut go_on);
    assert!(matches!(refused, Err(VerificationError::AnotherGame { .. })));
    assert!(matches!(
        ClosedForm::of(robot_that_can_stop().metadata()),
        Err(VerificationError::NoClosedForm { .. })
    ));
}

fn small_plan() -> VerificationPlan {
    let mut plan = VerificationPlan::standard(4.0, 0.004, 1e6, 7);
    plan.structural_states = 20_000;
    plan.value_error = ValueErrorSettings { states: 10_000, shell_states: 20_000, seed: 7 };
    plan.condition.states = 50_000;
    plan.scenario = Some(scenario(200));
    plan
}

#[test]
fn the_same_seed_gives_the_same_record_with_any_number_of_threads() {
    let model = quadrotor(0.0);
    let truth = ClosedForm::of(model.metadata()).unwrap();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| verify(&subject(&model), Some(&truth), &small_plan(), &mut go_on)).unwrap()
    };
    let (one, three) = (with(1), with(3));
    assert_eq!(one, three);
    let mut plan = small_plan();
    plan.condition.seed += 1;
    let other = verify(&subject(&model), None, &plan, &mut go_on).unwrap();
    assert_ne!(one.condition, other.condition);
    assert!(other.value_error.is_none() && other.structural == one.structural);
}

#[test]
fn a_record_survives_the_models_metadata() {
    let model = quadrotor(0.0);
    let truth = ClosedForm::of(model.metadata()).unwrap();
    let verification = verify(&subject(&model), Some(&truth), &small_plan(), &mut go_on).unwrap();
    let sealed = model.with_verification(verification.to_metadata().unwrap()).unwrap();
    let read = Model::from_bytes(&sealed.to_bytes().unwrap()).unwrap();
    assert_eq!(Verification::from_metadata(&read.metadata().verification).unwrap(), verification);
    assert_eq!(
        Verification::from_metadata(&quadrotor(0.0).metadata().verification).unwrap(),
        Verification::default()
    );
    let text = verification.to_string();
    for part in ["(a) structure: holds", "(b) error", "(c) CBF condition", "(d) scenario"] {
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn a_verification_stops_when_asked() {
    let model = quadrotor(0.0);
    let mut calls = 0;
    let mut stop = |_: &verification::Progress| {
        calls += 1;
        ControlFlow::Break(())
    };
    let stopped = verify(&subject(&model), None, &small_plan(), &mut stop);
    assert_eq!(stopped, Err(VerificationError::Stopped));
    assert_eq!(calls, 1);
}

#[test]
fn an_obstacle_at_rest_is_no_worse_for_any_disturbance_policy() {
    let model = robot_that_cannot_stop();
    let [zero, worst] = [DisturbancePolicy::Zero, DisturbancePolicy::LowersBarrier].map(|disturbance| {
        let settings = verification::ScenarioSettings { disturbance, ..scenario(128) };
        certify_by_rollouts(&subject(&model), &settings, &mut go_on).unwrap()
    });
    assert_eq!(zero.rows, worst.rows);
}
