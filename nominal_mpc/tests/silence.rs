//! When no command is given: one defect per test.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::{MS, controller, goal, ground_robot, inputs, state};
use messages::Reason;
use nominal_mpc::{Inputs, NominalController, NominalSetupError, Silence};

const NOW_NS: u64 = 1_000 * MS;

#[test]
fn without_a_robot_state() {
    let goal = goal(5.0, 0.0);
    let inputs = Inputs { goal: Some(&goal), ..Inputs::default() };
    assert_eq!(controller(&ground_robot()).step(&inputs, NOW_NS), Err(Silence::NoRobotState));
}

#[test]
fn without_a_goal() {
    let state = state([0.0; 3], NOW_NS);
    let inputs = Inputs { robot_state: Some(&state), ..Inputs::default() };
    assert_eq!(controller(&ground_robot()).step(&inputs, NOW_NS), Err(Silence::NoGoal));
}

#[test]
fn with_a_state_that_is_older_than_the_limit_and_not_before() {
    let mut controller = controller(&ground_robot());
    let (state, goal) = (state([0.0; 3], NOW_NS), goal(5.0, 0.0));
    assert!(controller.step(&inputs(&state, &goal), NOW_NS + 100 * MS).is_ok());
    assert_eq!(controller.step(&inputs(&state, &goal), NOW_NS + 100 * MS + 1), Err(Silence::StaleRobotState));
}

#[test]
fn with_a_state_from_the_future() {
    let (state, goal) = (state([0.0; 3], NOW_NS + 101 * MS), goal(5.0, 0.0));
    assert_eq!(
        controller(&ground_robot()).step(&inputs(&state, &goal), NOW_NS),
        Err(Silence::FutureRobotState)
    );
}

#[test]
fn with_a_state_that_is_not_finite() {
    for spoil in 0..6 {
        let (mut state, goal) = (state([0.0; 3], NOW_NS), goal(5.0, 0.0));
        let [x, y] = &mut state.position_in_odom_m;
        let [forward, left] = &mut state.velocity_in_base_mps;
        *[x, y, forward, left, &mut state.heading_rad, &mut state.yaw_rate_radps][spoil] = f64::NAN;
        assert_eq!(
            controller(&ground_robot()).step(&inputs(&state, &goal), NOW_NS),
            Err(Silence::NonFiniteRobotState)
        );
    }
}

#[test]
fn with_a_goal_that_is_not_finite() {
    let (state, goal) = (state([0.0; 3], NOW_NS), goal(f64::INFINITY, 0.0));
    let silence = controller(&ground_robot()).step(&inputs(&state, &goal), NOW_NS).unwrap_err();
    assert_eq!(silence, Silence::NonFiniteGoal);
    assert_eq!(silence.reason(), Reason::MalformedInput);
}

/// A robot state that no QP can be solved from: finite, but its gradient is not representable.
const BEYOND_ANY_QP: [f64; 3] = [1e140, 0.0, 0.0];

fn after_a_plan(settings: &settings::Settings) -> (NominalController, messages::Goal) {
    let mut controller = controller(settings);
    let goal = goal(6.0, 4.0);
    let first = controller.step(&inputs(&state([0.0; 3], NOW_NS), &goal), NOW_NS).unwrap();
    assert!(first.effort > 0);
    (controller, goal)
}

#[test]
fn after_more_failed_solves_in_a_row_than_may_be_bridged() {
    let settings = ground_robot();
    assert_eq!(settings.nominal.mpc.max_bridged_failures, 2);
    let (mut controller, goal) = after_a_plan(&settings);
    let mut fail_at = |time_ns| controller.step(&inputs(&state(BEYOND_ANY_QP, time_ns), &goal), time_ns);
    for cycle in 1..=2 {
        let bridged = fail_at(NOW_NS + cycle * 50 * MS).unwrap();
        assert_eq!(bridged.effort, 0);
        // The old plan still turns left towards its goal.
        assert!((bridged.control[1] - 0.8).abs() < 1e-3, "{bridged:?}");
    }
    for cycle in 3..=6 {
        assert_eq!(fail_at(NOW_NS + cycle * 50 * MS), Err(Silence::SolverFailed));
    }
    let later = NOW_NS + 500 * MS;
    let recovered = controller.step(&inputs(&state([0.0; 3], later), &goal), later).unwrap();
    assert!(recovered.effort > 0);
}

#[test]
fn a_bridged_command_is_the_old_plans_at_the_time_asked_for() {
    let (mut controller, goal) = after_a_plan(&ground_robot());
    // The goal is 0.59 rad to the left: within a second the plan has turned there and drives straight on.
    let later = NOW_NS + 1_500 * MS;
    let bridged = controller.step(&inputs(&state(BEYOND_ANY_QP, later), &goal), later).unwrap();
    assert_eq!(bridged.effort, 0);
    assert!(bridged.control[1].abs() < 0.1, "{bridged:?}");
}

#[test]
fn at_once_when_the_first_solve_fails() {
    let (state, goal) = (state(BEYOND_ANY_QP, NOW_NS), goal(6.0, 4.0));
    assert_eq!(controller(&ground_robot()).step(&inputs(&state, &goal), NOW_NS), Err(Silence::SolverFailed));
}

#[test]
fn at_once_when_the_cost_overflows() {
    let (mut controller, goal) = after_a_plan(&ground_robot());
    let state = state([1e300, 0.0, 0.0], NOW_NS + 50 * MS);
    assert_eq!(controller.step(&inputs(&state, &goal), NOW_NS + 50 * MS), Err(Silence::SolverFailed));
}

#[test]
fn weights_that_make_no_controller_are_refused_at_start() {
    let mut settings = common::quadrotor();
    settings.nominal.lqr.state_weight = [0.0, 4.0, 1.0, 1.0];
    let error = NominalController::new(&settings).err().unwrap();
    assert!(matches!(error, NominalSetupError::Lqr(_)), "{error}");
    assert!(error.to_string().contains("nominal.lqr"), "{error}");
}
