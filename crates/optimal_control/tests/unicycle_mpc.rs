//! The unicycle MPC against IPOPT's stored optima, and in closed loop with the paper's bounds.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::f64::consts::{PI, TAU};

use optimal_control::{SqpStatus, UnicycleMpc, UnicycleMpcSettings};

/// Control period of the closed loops, s: half a prediction step, as in the paper.
const PERIOD_S: f64 = 0.05;

fn with_iterations(limit: u32) -> UnicycleMpc {
    let mut settings = UnicycleMpcSettings::paper();
    settings.sqp.iteration_limit = limit;
    UnicycleMpc::new(&settings).unwrap()
}

/// Counts of this test, as measured: 120 of 120 within 1e-3 of the least cost that IPOPT found from nine starts,
/// none below it by more, 119 of 120 with its first control (the other turns the opposite way at the same cost).
#[test]
fn a_converged_plan_costs_no_more_than_ipopts() {
    let text = include_str!("../../../tests/data/mpc_casadi_reference.json");
    let document: serde_json::Value = serde_json::from_str(text).unwrap();
    let problems = document["problems"].as_array().unwrap();
    assert_eq!(problems.len(), 120);
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let (mut matched, mut same_first) = (0, 0);
    for problem in problems {
        let start = std::array::from_fn(|i| number(&problem["start"][i]));
        let mut mpc = with_iterations(100);
        let report = mpc.plan(&start, &[0.0; 3], 0.0).unwrap();
        assert_eq!(report.status, SqpStatus::Converged, "{start:?}");
        let best = number(&problem["best_cost"]);
        // IPOPT searched from nine starts: a cost far below its best would mean another problem was solved.
        assert!(report.cost > best * (1.0 - 1e-3), "{start:?}: {} undercuts {best}", report.cost);
        matched += usize::from(report.cost <= best * (1.0 + 1e-3));
        let first = mpc.controls()[0];
        let expected = &problem["best_first_control"];
        same_first += usize::from((0..2).all(|j| (first[j] - number(&expected[j])).abs() < 1e-3));
    }
    assert_eq!(matched, problems.len());
    assert!(same_first >= 119, "{same_first}");
}

#[test]
fn every_control_of_a_plan_is_within_the_box() {
    let mut mpc = with_iterations(3);
    for k in 0..40 {
        let bearing = f64::from(k) * 0.4;
        mpc.plan(&[3.0 * bearing.cos(), 3.0 * bearing.sin(), bearing * 1.7], &[0.0; 3], PERIOD_S).unwrap();
        for [speed, yaw_rate] in mpc.controls() {
            assert!((0.25..=1.0).contains(speed) && (-0.8..=0.8).contains(yaw_rate));
        }
    }
}

/// Drives until the goal is within `tolerance_m`. Returns the time, s, and how often the yaw rate changed sides.
fn drive(start: [f64; 3], goal: [f64; 3], tolerance_m: f64, limit_s: f64) -> Option<(f64, u32)> {
    let mut mpc = with_iterations(3);
    let [mut x, mut y, mut heading] = start;
    let (mut time_s, mut previous_yaw_rate, mut reversals) = (0.0, 0.0, 0);
    while time_s < limit_s {
        if (x - goal[0]).hypot(y - goal[1]) < tolerance_m {
            return Some((time_s, reversals));
        }
        let measured = (heading + PI).rem_euclid(TAU) - PI;
        mpc.plan(&[x, y, measured], &goal, PERIOD_S).unwrap();
        let [speed, yaw_rate] = mpc.controls()[0];
        reversals += u32::from(yaw_rate * previous_yaw_rate < -0.1);
        previous_yaw_rate = yaw_rate;
        for _ in 0..10 {
            let step_s = PERIOD_S / 10.0;
            x += step_s * speed * heading.cos();
            y += step_s * speed * heading.sin();
            heading += step_s * yaw_rate;
        }
        time_s += PERIOD_S;
    }
    None
}

/// At 0.25 m/s and 0.8 rad/s the tightest circle has a radius of 0.31 m: a goal inside it can only be reached by
/// driving away first. Down to a tolerance of 0.2 m none of 200 starts orbited; at 0.1 m a fifth did.
#[test]
fn goals_all_around_are_reached_within_the_tolerance() {
    for k in 0..24 {
        let bearing = f64::from(k) * TAU / 24.0;
        let distance = 0.35 + 0.15 * f64::from(k);
        let goal = [distance * bearing.cos(), distance * bearing.sin(), 0.0];
        let reached = drive([0.0, 0.0, 0.3], goal, 0.3, distance + 8.0);
        assert!(reached.is_some_and(|(_, reversals)| reversals <= 1), "{goal:?}: {reached:?}");
    }
}

#[test]
fn a_far_goal_is_approached_at_full_speed_without_weaving() {
    let (time_s, reversals) = drive([0.0; 3], [13.0, 1.0, 0.0], 0.3, 20.0).unwrap();
    assert!(time_s < 13.5, "{time_s}");
    assert_eq!(reversals, 0);
}

#[test]
fn a_goal_exactly_behind_is_turned_to() {
    let (time_s, reversals) = drive([0.0; 3], [-6.0, 0.0, 0.0], 0.3, 15.0).unwrap();
    // Half a turn takes 3.9 s at least.
    assert!(time_s < 6.0 + 4.5, "{time_s}");
    assert_eq!(reversals, 0);
}

#[test]
fn a_heading_that_wraps_does_not_move_the_command() {
    let mut mpc = with_iterations(3);
    // Straight towards the goal, opposite to the heading wanted there: noise decides on the sign.
    let pose = |sign: f64| [1.5, 0.0, sign * (PI - 1e-3)];
    mpc.plan(&pose(1.0), &[0.0; 3], PERIOD_S).unwrap();
    mpc.plan(&pose(1.0), &[0.0; 3], 0.0).unwrap();
    let before = mpc.controls()[0];
    mpc.plan(&pose(-1.0), &[0.0; 3], 0.0).unwrap();
    let after = mpc.controls()[0];
    assert!((before[1] - after[1]).abs() < 0.05, "{before:?} {after:?}");
}

#[test]
fn a_pose_that_is_not_finite_is_refused_and_the_plan_kept() {
    let mut mpc = with_iterations(3);
    mpc.plan(&[1.0, 2.0, 0.0], &[0.0; 3], 0.0).unwrap();
    let plan = mpc.controls().to_vec();
    assert!(mpc.plan(&[f64::NAN, 0.0, 0.0], &[0.0; 3], 0.0).is_err());
    assert!(mpc.plan(&[0.0; 3], &[0.0, f64::INFINITY, 0.0], 0.0).is_err());
    assert!(mpc.plan(&[1e300, 0.0, 0.0], &[0.0; 3], 0.0).is_err());
    assert_eq!(plan, mpc.controls());
}
