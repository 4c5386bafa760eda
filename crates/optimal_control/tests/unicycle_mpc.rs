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

/// A pose given relative to `frame`, in the axes in which `frame` is given.
fn moved(frame: &[f64; 3], &[x, y, heading]: &[f64; 3]) -> [f64; 3] {
    let (sin, cos) = frame[2].sin_cos();
    [frame[0] + cos * x - sin * y, frame[1] + sin * x + cos * y, frame[2] + heading]
}

/// Counts of this test, as measured: 120 of 120 within 1e-3 of the least cost that IPOPT found from nine starts,
/// none below it by more, 119 of 120 with its first control (the other turns the opposite way at the same cost).
/// IPOPT's goal is the origin; with equal weights on x and y the optimum does not depend on where the goal is.
#[test]
fn a_converged_plan_costs_no_more_than_ipopts_wherever_the_goal_is() {
    let text = include_str!("../../../tests/data/mpc_casadi_reference.json");
    let document: serde_json::Value = serde_json::from_str(text).unwrap();
    let problems = document["problems"].as_array().unwrap();
    assert_eq!(problems.len(), 120);
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    for goal in [[0.0; 3], [4.0, -7.0, 2.2], [-1.0, 0.5, -1.4], [30.0, 20.0, -3.1]] {
        let (mut matched, mut same_first) = (0, 0);
        for problem in problems {
            let start = moved(&goal, &std::array::from_fn(|i| number(&problem["start"][i])));
            let mut mpc = with_iterations(100);
            let report = mpc.plan(&start, &goal, 0.0).unwrap();
            assert_eq!(report.status, SqpStatus::Converged, "{start:?} to {goal:?}");
            let best = number(&problem["best_cost"]);
            // IPOPT searched from nine starts: a cost far below its best would mean another problem was solved.
            let undercut = report.cost <= best * (1.0 - 1e-3);
            assert!(!undercut, "{start:?} to {goal:?}: {} undercuts {best}", report.cost);
            matched += usize::from(report.cost <= best * (1.0 + 1e-3));
            let first = mpc.controls()[0];
            let expected = &problem["best_first_control"];
            same_first += usize::from((0..2).all(|j| (first[j] - number(&expected[j])).abs() < 1e-3));
        }
        assert_eq!(matched, problems.len(), "{goal:?}");
        assert!(same_first >= 119, "{goal:?}: {same_first}");
    }
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

/// A robot that obeys at once, seen with its heading in `[-pi, pi)`.
struct Robot {
    pose: [f64; 3],
}

impl Robot {
    fn measured(&self) -> [f64; 3] {
        let [x, y, heading] = self.pose;
        [x, y, (heading + PI).rem_euclid(TAU) - PI]
    }

    fn distance_m(&self, goal: &[f64; 3]) -> f64 {
        (self.pose[0] - goal[0]).hypot(self.pose[1] - goal[1])
    }

    /// Holds a control for one period, integrated in ten steps.
    fn drive(&mut self, [speed, yaw_rate]: [f64; 2]) {
        let step_s = PERIOD_S / 10.0;
        for _ in 0..10 {
            let heading = self.pose[2];
            self.pose[0] += step_s * speed * heading.cos();
            self.pose[1] += step_s * speed * heading.sin();
            self.pose[2] += step_s * yaw_rate;
        }
    }
}

/// Drives until the goal is within `tolerance_m`. Returns the time, s, and how often the yaw rate changed sides.
fn drive(start: [f64; 3], goal: [f64; 3], tolerance_m: f64, limit_s: f64) -> Option<(f64, u32)> {
    let mut mpc = with_iterations(3);
    let mut robot = Robot { pose: start };
    let (mut time_s, mut previous_yaw_rate, mut reversals) = (0.0, 0.0, 0);
    while time_s < limit_s {
        if robot.distance_m(&goal) < tolerance_m {
            return Some((time_s, reversals));
        }
        mpc.plan(&robot.measured(), &goal, PERIOD_S).unwrap();
        let [speed, yaw_rate] = mpc.controls()[0];
        reversals += u32::from(yaw_rate * previous_yaw_rate < -0.1);
        previous_yaw_rate = yaw_rate;
        robot.drive([speed, yaw_rate]);
        time_s += PERIOD_S;
    }
    None
}

/// Half a turn takes 3.9 s at least, in which the robot gets farther away; 4.9 s is the longest that 1,728
/// undisturbed drives (1 to 30 m, 24 bearings, 8 goal headings) took beyond the time of the straight way.
const TURN_ALLOWANCE_S: f64 = 5.5;

/// For three seconds another command than the planned one is driven, as when a safety filter steps in; the
/// controller knows nothing of it and is to be on its way afterwards, wherever that left the robot.
#[test]
fn goals_of_any_heading_are_reached_even_after_the_robot_was_pushed_off_its_plan() {
    let deflections = [None, Some([1.0, 0.8]), Some([0.25, -0.8]), Some([1.0, 0.0]), Some([0.6, -0.4])];
    for (k, distance) in [1.0, 1.7, 2.5, 4.0, 6.0, 8.0, 11.5, 15.0, 21.0, 30.0].into_iter().enumerate() {
        for (m, deflection) in deflections.into_iter().enumerate() {
            // Steps that share no factor with the counts, so that bearings, headings and deflections mix.
            let mixed = (5 * k + m) as f64;
            let (bearing, goal_heading) = (mixed * 2.4, mixed * 1.7 - 0.4);
            let start = [-3.0, 8.0, mixed * 0.9];
            let goal =
                [start[0] + distance * bearing.cos(), start[1] + distance * bearing.sin(), goal_heading];
            let mut mpc = with_iterations(3);
            let mut robot = Robot { pose: start };
            let mut deadline_s = distance + TURN_ALLOWANCE_S;
            let mut time_s = 0.0;
            while robot.distance_m(&goal) > 0.3 {
                assert!(
                    time_s < deadline_s,
                    "from {start:?} to {goal:?}, {deflection:?}: at {:?}",
                    robot.pose
                );
                mpc.plan(&robot.measured(), &goal, PERIOD_S).unwrap();
                match deflection {
                    Some(control) if (0.5..3.5).contains(&time_s) => {
                        robot.drive(control);
                        deadline_s = time_s + robot.distance_m(&goal) + TURN_ALLOWANCE_S;
                    }
                    Some(_) | None => robot.drive(mpc.controls()[0]),
                }
                time_s += PERIOD_S;
            }
        }
    }
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
