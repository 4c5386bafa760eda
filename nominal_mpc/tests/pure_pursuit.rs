//! Pure pursuit: where it steers, what it is bounded by, that it arrives; and what `external` means.

mod common;

use std::f64::consts::PI;

use common::{MS, controller, goal, ground_robot, inputs, pursuer, quadrotor, state};
use messages::{ControlKind, Controller, Intent};
use nominal_mpc::{NominalController, NominalSetupError};
use settings::ControllerKind;

const START_NS: u64 = 1_000 * MS;

/// The first command from `pose` towards `(x_m, y_m)`.
fn control(pose: [f64; 3], x_m: f64, y_m: f64) -> [f64; 2] {
    let state = state(pose, START_NS);
    let command = controller(&pursuer()).step(&inputs(&state, &goal(x_m, y_m)), START_NS).expect("a command");
    assert_eq!((command.intent, command.controller), (Intent::Drive.code(), Controller::PurePursuit.code()));
    assert_eq!(command.control_kind, ControlKind::Unicycle.code());
    command.control
}

#[test]
fn the_circle_is_the_one_through_the_point_ahead() {
    // A point 1.5 m ahead at 0.1 rad to the left: curvature 2 sin 0.1 / 1.5.
    let [speed, yaw_rate] = control([0.0; 3], 10.0 * 0.1_f64.cos(), 10.0 * 0.1_f64.sin());
    assert!((speed - 1.0).abs() < 1e-12 && (yaw_rate - 2.0 * 0.1_f64.sin() / 1.5).abs() < 1e-12);
    // To the right it is the mirror image, also across the seam of the heading.
    let [speed, yaw_rate] = control([0.0, 0.0, -PI + 0.05], -10.0 * 0.05_f64.cos(), 10.0 * 0.05_f64.sin());
    assert!((speed - 1.0).abs() < 1e-12 && (yaw_rate + 2.0 * 0.1_f64.sin() / 1.5).abs() < 1e-12);
    assert_eq!(control([0.0; 3], 10.0, 0.0), [1.0, 0.0]);
}

#[test]
fn every_command_lies_in_the_robots_box_whatever_the_bearing() {
    let robot = ground_robot().robot;
    for step in 0..=200 {
        let bearing = -PI + 2.0 * PI * f64::from(step) / 200.0;
        for distance in [0.31, 0.5, 1.0, 30.0] {
            let control = control([0.0; 3], distance * bearing.cos(), distance * bearing.sin());
            for axis in 0..2 {
                let range = robot.control_min[axis]..=robot.control_max[axis];
                assert!(range.contains(&control[axis]), "bearing {bearing}: {control:?}");
            }
            assert!(
                bearing.abs() > 3.1 || bearing.abs() < 1e-9 || control[1] * bearing > 0.0,
                "turns away at {bearing}"
            );
        }
    }
}

#[test]
fn a_robot_that_obeys_arrives_and_is_asked_to_stop() {
    for (x_m, y_m) in [(12.0, 3.0), (-4.0, 1.0), (0.0, -2.0)] {
        let (mut controller, goal, mut pose) = (controller(&pursuer()), goal(x_m, y_m), [0.0; 3]);
        let stopped = (0..800).find(|cycle| {
            let now_ns = START_NS + cycle * 50 * MS;
            let state = state(pose, now_ns);
            let command = controller.step(&inputs(&state, &goal), now_ns).unwrap();
            let [speed, yaw_rate] = command.control;
            pose[2] += 0.05 * yaw_rate;
            pose[0] += 0.05 * speed * pose[2].cos();
            pose[1] += 0.05 * speed * pose[2].sin();
            command.intent == Intent::Stop.code()
        });
        assert!(stopped.is_some(), "goal {x_m}, {y_m} was not reached; the robot is at {pose:?}");
    }
}

#[test]
fn it_is_refused_where_it_does_not_fit_and_external_is_nobody() {
    let mut lonely = ground_robot();
    lonely.nominal.pure_pursuit = None;
    let error = lonely.use_controller(ControllerKind::PurePursuit).unwrap_err().to_string();
    assert!(error.contains("[nominal.pure_pursuit]"), "{error}");
    assert_eq!(lonely.nominal.controller, ControllerKind::Mpc, "a refused choice changes nothing");
    for wrong in [ControllerKind::PurePursuit, ControllerKind::Mpc] {
        assert!(quadrotor().use_controller(wrong).is_err(), "{wrong:?}");
    }
    let mut external = ground_robot();
    external.use_controller(ControllerKind::External).unwrap();
    assert_eq!(NominalController::new(&external).err(), Some(NominalSetupError::External));
}
