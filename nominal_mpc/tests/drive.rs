//! What the controllers command, alone and in closed loop in virtual time.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::{MS, controller, goal, ground_robot, inputs, quadrotor, state};
use messages::{ControlKind, Controller, Goal, Intent, NominalCommand, RobotState};
use nominal_mpc::{Inputs, NominalController};
use settings::{ControllerKind, Settings};

const START_NS: u64 = 5_000 * MS;
const PERIOD_NS: u64 = 50 * MS;

#[test]
fn a_command_carries_the_times_of_the_state_it_answers() {
    let (state, goal) = (state([0.0; 3], START_NS), goal(5.0, 0.0));
    let mut controller = controller(&ground_robot());
    let now_ns = START_NS + 4 * MS;
    let command = controller.step(&inputs(&state, &goal), now_ns).unwrap();
    assert_eq!(command.stamp.sequence, 1);
    assert_eq!(command.stamp.source_ns, state.stamp.source_ns);
    assert_eq!(command.stamp.valid_at_ns, state.stamp.valid_at_ns);
    assert_eq!(command.stamp.ingress_ns, state.stamp.ingress_ns);
    assert_eq!(command.stamp.published_ns, now_ns);
    assert_eq!(command.bridge_published_ns, state.stamp.published_ns);
    assert_eq!(command.received_ns, START_NS + 3 * MS);
    assert_eq!(command.control_kind, ControlKind::Unicycle.code());
    assert_eq!(command.controller, Controller::Mpc.code());
    assert_eq!(command.intent, Intent::Drive.code());
    assert_eq!(controller.step(&inputs(&state, &goal), now_ns).unwrap().stamp.sequence, 2);
}

#[test]
fn a_far_goal_ahead_means_full_speed_straight_on() {
    let mut controller = controller(&ground_robot());
    for far_m in [13.0, 100.0, 10_000.0] {
        let (state, goal) = (state([0.0; 3], START_NS), goal(far_m, 0.0));
        let [speed_mps, yaw_rate_radps] = controller.step(&inputs(&state, &goal), START_NS).unwrap().control;
        assert!(speed_mps > 0.99 && yaw_rate_radps.abs() < 0.01, "{far_m} m: {speed_mps} {yaw_rate_radps}");
    }
}

#[test]
fn a_goal_at_the_tolerance_is_reached_and_held_until_the_robot_is_twice_as_far() {
    let mut controller = controller(&ground_robot());
    let goal = goal(0.0, 0.0);
    let mut intent_at = |x_m: f64| {
        let command = controller.step(&inputs(&state([x_m, 0.0, 0.0], START_NS), &goal), START_NS).unwrap();
        if command.intent == Intent::Stop.code() {
            assert_eq!(command.control, [0.0; 2]);
        }
        Intent::try_from(command.intent).unwrap()
    };
    assert_eq!(intent_at(-0.31), Intent::Drive);
    assert_eq!(intent_at(-0.30), Intent::Stop);
    assert_eq!(intent_at(0.59), Intent::Stop);
    assert_eq!(intent_at(0.61), Intent::Drive);
    assert_eq!(intent_at(0.59), Intent::Drive);
}

#[test]
fn a_new_goal_releases_the_robot_at_once() {
    let mut controller = controller(&ground_robot());
    let state = state([0.0; 3], START_NS);
    let first = controller.step(&inputs(&state, &goal(0.1, 0.0)), START_NS).unwrap();
    assert_eq!(first.intent, Intent::Stop.code());
    let second = controller.step(&inputs(&state, &goal(0.4, 0.0)), START_NS).unwrap();
    assert_eq!(second.intent, Intent::Drive.code());
}

#[test]
fn hold_asks_for_a_stop_even_without_a_goal() {
    let mut settings = ground_robot();
    settings.nominal.controller = ControllerKind::Hold;
    let state = state([0.0; 3], START_NS);
    let inputs = Inputs { robot_state: Some(&state), ..Inputs::default() };
    let command = controller(&settings).step(&inputs, START_NS).unwrap();
    assert_eq!((command.intent, command.controller), (Intent::Stop.code(), Controller::Hold.code()));
    assert_eq!(command.control, [0.0; 2]);
}

#[test]
fn the_lqr_is_the_authors_with_a_shortened_error() {
    let mut controller = controller(&quadrotor());
    let damping = 5.0_f64.sqrt();
    let mut at = |x_m: f64, speed_mps: f64| {
        let mut state = state([x_m, 0.0, 0.0], START_NS);
        state.velocity_in_base_mps = [speed_mps, 0.0];
        let command = controller.step(&inputs(&state, &goal(13.0, 0.0)), START_NS).unwrap();
        assert_eq!(command.control_kind, ControlKind::DoubleIntegrator.code());
        assert!(command.control[1].abs() < 1e-12);
        command.control[0]
    };
    assert!((at(-2.0, 0.0) - 4.0).abs() < 1e-9);
    assert!((at(12.0, 0.0) - 2.0).abs() < 1e-9);
    assert!((at(12.0, 1.0) - (2.0 - damping)).abs() < 1e-9);
    // Cruise: 2 m · 2 / 2.236 = 1.79 m/s.
    assert!(at(0.0, 4.0 / damping).abs() < 1e-9);
}

#[test]
fn the_lqr_turns_body_velocity_into_odom() {
    let mut state = state([13.0, -1.0, std::f64::consts::FRAC_PI_2], START_NS);
    state.velocity_in_base_mps = [1.0, 0.0];
    let command = controller(&quadrotor()).step(&inputs(&state, &goal(13.0, 0.0)), START_NS).unwrap();
    assert!(command.control[0].abs() < 1e-9, "{command:?}");
    assert!((command.control[1] - (2.0 - 5.0_f64.sqrt())).abs() < 1e-9, "{command:?}");
}

/// Drives a perfect robot, its state measured every period, until it is asked to stop. Returns all commands.
fn drive(
    settings: &Settings,
    start: [f64; 3],
    goal: &Goal,
    limit_s: f64,
    advance: impl Fn(&mut RobotState, [f64; 2], f64),
) -> Vec<NominalCommand> {
    let mut controller: NominalController = controller(settings);
    let mut robot = state(start, START_NS);
    let mut commands = Vec::new();
    let cycles = (limit_s / (PERIOD_NS as f64 * 1e-9)) as u64;
    for cycle in 0..cycles {
        let now_ns = START_NS + cycle * PERIOD_NS;
        robot.stamp.valid_at_ns = now_ns;
        let command = controller.step(&inputs(&robot, goal), now_ns).unwrap();
        commands.push(command);
        if command.intent == Intent::Stop.code() {
            break;
        }
        for _ in 0..10 {
            advance(&mut robot, command.control, PERIOD_NS as f64 * 1e-10);
        }
    }
    commands
}

fn unicycle(robot: &mut RobotState, [speed, yaw_rate]: [f64; 2], step_s: f64) {
    let (sin, cos) = robot.heading_rad.sin_cos();
    robot.position_in_odom_m[0] += step_s * speed * cos;
    robot.position_in_odom_m[1] += step_s * speed * sin;
    let turned = robot.heading_rad + step_s * yaw_rate;
    robot.heading_rad =
        (turned + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
}

fn double_integrator(robot: &mut RobotState, acceleration: [f64; 2], step_s: f64) {
    // The heading stays zero, so that base and odom are parallel.
    for axis in 0..2 {
        robot.velocity_in_base_mps[axis] += step_s * acceleration[axis];
        robot.position_in_odom_m[axis] += step_s * robot.velocity_in_base_mps[axis];
    }
}

#[test]
fn the_mpc_crosses_the_arena_of_the_demo() {
    let commands = drive(&ground_robot(), [-1.5, 0.0, 0.0], &goal(13.5, 0.0), 20.0, unicycle);
    let last = commands.last().unwrap();
    assert_eq!(last.intent, Intent::Stop.code());
    // 14.7 m at 1 m/s, slowing down only at the very end.
    let time_s = (last.stamp.valid_at_ns - START_NS) as f64 * 1e-9;
    assert!(time_s < 15.2, "{time_s}");
    for command in &commands {
        let [speed_mps, yaw_rate_radps] = command.control;
        assert!(command.intent == Intent::Stop.code() || (0.25..=1.0).contains(&speed_mps));
        assert!(yaw_rate_radps.abs() < 0.05, "{command:?}");
    }
}

#[test]
fn the_mpc_reaches_a_goal_behind_and_beside() {
    for (x_m, y_m) in [(-3.0, 0.0), (0.0, 2.0), (0.0, -0.4), (-0.4, 0.0), (0.2, 0.31)] {
        let commands = drive(&ground_robot(), [0.0; 3], &goal(x_m, y_m), 20.0, unicycle);
        assert_eq!(commands.last().unwrap().intent, Intent::Stop.code(), "({x_m}, {y_m})");
    }
}

/// What a bridge makes of a goal given ahead of the robot: its heading is the robot's, whatever that is in odom.
#[test]
fn the_mpc_drives_straight_to_a_goal_ahead_whatever_the_heading_in_odom() {
    for heading in [-3.0_f64, -1.6, -0.5, 1.0, 2.3, 3.1] {
        let goal = Goal { heading_rad: heading, ..goal(12.0 * heading.cos(), 12.0 * heading.sin()) };
        let commands = drive(&ground_robot(), [0.0, 0.0, heading], &goal, 13.0, unicycle);
        assert_eq!(commands.last().unwrap().intent, Intent::Stop.code(), "{heading}");
        for command in &commands {
            assert!(command.control[1].abs() < 0.05, "{heading}: {command:?}");
        }
    }
}

#[test]
fn the_lqr_crosses_the_arena_of_the_paper() {
    let commands = drive(&quadrotor(), [-2.0, 0.0, 0.0], &goal(13.0, 0.0), 20.0, double_integrator);
    let last = commands.last().unwrap();
    assert_eq!(last.intent, Intent::Stop.code());
    let time_s = (last.stamp.valid_at_ns - START_NS) as f64 * 1e-9;
    assert!((8.0..11.0).contains(&time_s), "{time_s}");
}

#[test]
fn the_same_inputs_give_the_same_commands() {
    let run = || drive(&ground_robot(), [0.0, 1.0, 2.0], &goal(4.0, -3.0), 12.0, unicycle);
    let first = run();
    assert!(first.len() > 50);
    assert_eq!(first, run());
}
