//! Every class of contact from a situation built to give it: a crowd that closes in, a person who rushes, a robot wider than it
//! believes. `appeared_inside` and `not_filtered` have theirs in `runs`.
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use std::f64::consts::TAU;

use evaluation::{Robot, Row, Scenario, Variant, run};
use serde_json::{Value, json};

/// The radius that settings and models believe the robot to have, m.
const BELIEVED_RADIUS_M: f64 = 0.35;

/// A robot at the origin that wants to go 6 m ahead, among `people`.
fn scenario(people: &[Value], robot_radius_m: f64) -> Scenario {
    let scenario = json!({
        "name": "built",
        "start": { "position_m": [0.0, 0.0], "heading_rad": 0.0 },
        "goal_m": [6.0, 0.0],
        "goal_tolerance_m": 0.3,
        "time_limit_s": 15.0,
        "robot_radius_m": robot_radius_m,
        "arena": { "x_m": [-16.0, 16.0], "y_m": [-16.0, 16.0] },
        "people": people,
    });
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scenarios.json");
    let text = json!({ "format": "cncbf-scenarios/1", "scenarios": [scenario] }).to_string();
    std::fs::write(&file, text).unwrap();
    Scenario::from_file(&file).unwrap().remove(0)
}

/// Somebody who is at `place_m(t)` (m, t in s) until `until_s`.
fn person(id: u64, until_s: f64, place_m: impl Fn(f64) -> [f64; 2]) -> Value {
    let times_s: Vec<f64> =
        (0..1_000).map(|k| f64::from(k) * 0.05).take_while(|time_s| *time_s <= until_s).collect();
    let positions_m: Vec<[f64; 2]> = times_s.iter().map(|time_s| place_m(*time_s)).collect();
    json!({
        "id": id,
        "radius_m": 0.35,
        "motion": { "track": { "times_s": times_s, "positions_m": positions_m } },
    })
}

/// Twelve people in a ring around the start, each on a straight way through it at constant speed.
fn ring(radius_m: f64, speed_mps: f64) -> Scenario {
    let people: Vec<Value> = (0..12)
        .map(|k| {
            let (sin, cos) = (TAU * f64::from(k) / 12.0).sin_cos();
            let away_m = move |t: f64| radius_m - speed_mps * t;
            person(k as u64 + 1, 12.0, move |t| [away_m(t) * cos, away_m(t) * sin])
        })
        .collect();
    scenario(&people, BELIEVED_RADIUS_M)
}

fn row(robot: Robot, method: &str, scenario: &Scenario) -> Row {
    let variant = Variant::named(robot, method, &[]).unwrap();
    run(scenario, &variant, "build", &|| false).unwrap().unwrap()
}

/// Runs `scenario`, in which there has to be contact at both radii for the same reason, and returns that.
fn cause(robot: Robot, method: &str, scenario: &Scenario) -> String {
    let row = row(robot, method, scenario);
    assert!(row.collision && row.collision_smaller && row.cause == row.cause_smaller, "{row:?}");
    row.cause
}

#[test]
fn a_crowd_that_closes_in_has_boxed_the_robot_in() {
    for (robot, method, speed_mps) in [
        (Robot::Quadrotor, "cn_cbf", 1.2),
        (Robot::Quadrotor, "c3bf", 1.2),
        (Robot::Ground, "cn_cbf", 0.8),
        (Robot::Ground, "dcbf_mpc", 0.8),
    ] {
        assert_eq!(cause(robot, method, &ring(4.0, speed_mps)), "boxed_in", "{method}");
    }
}

#[test]
fn a_crowd_that_leaves_nothing_for_one_person_alone_has_not() {
    // So near and fast that the ground robot could not even evade a single one of them.
    let row = row(Robot::Ground, "cn_cbf", &ring(3.0, 1.2));
    assert_eq!((row.cause.as_str(), row.bounds_exceeded_share), ("filter_fault", 0.0), "{row:?}");
}

#[test]
fn one_person_boxes_nobody_in() {
    // Head-on the planners give up for a while and graze, although this one person could have been avoided.
    let walker = person(1, 12.0, |t| [8.0 - 1.4 * t, 0.0]);
    let head_on = scenario(&[walker], BELIEVED_RADIUS_M);
    for method in ["vo_mpc", "rntc_mpc"] {
        let row = row(Robot::Ground, method, &head_on);
        assert!(row.collision && row.slack_cycles > 10 && row.max_slack > 1e-3, "{row:?}");
        assert_eq!(row.cause, "filter_fault", "{method}");
    }
}

#[test]
fn who_rushes_into_the_robot_left_the_bounds() {
    // Stands beside the way, then runs across it at twice the speed that the model knows.
    let rushing = person(1, 2.8, |t| [3.0, 1.2 - 3.0 * (t - 1.8).max(0.0)]);
    let crossing = scenario(&[rushing], BELIEVED_RADIUS_M);
    assert_eq!(cause(Robot::Quadrotor, "cn_cbf", &crossing), "bounds_exceeded");
}

#[test]
fn who_left_the_bounds_long_before_is_not_to_blame() {
    // Turns by a right angle when it is 8 m away, then walks straight on for seconds.
    let walker = person(1, 12.0, |t| if t < 0.5 { [8.0, 0.8 - t] } else { [8.5 - t, 0.3] });
    let row = row(Robot::Quadrotor, "cn_cbf", &scenario(&[walker], 0.5));
    assert!(row.bounds_exceeded_share > 0.0 && row.contact_s.unwrap() > 2.0, "{row:?}");
    assert_eq!((row.cause.as_str(), row.cause_smaller.as_str()), ("filter_fault", "filter_fault"));
}

#[test]
fn a_robot_wider_than_it_believes_is_its_own_fault() {
    let walker = person(1, 12.0, |t| [8.0 - t, 0.3]);
    for (robot, method) in
        [(Robot::Quadrotor, "cn_cbf"), (Robot::Quadrotor, "c3bf"), (Robot::Ground, "cn_cbf")]
    {
        let wide = scenario(std::slice::from_ref(&walker), 0.5);
        assert_eq!(cause(robot, method, &wide), "filter_fault", "{method}");
        let believed = scenario(std::slice::from_ref(&walker), BELIEVED_RADIUS_M);
        assert_eq!(row(robot, method, &believed).cause_smaller, "", "{method} avoids the same person");
    }
}
