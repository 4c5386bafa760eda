//! Settings, states and goals for the tests of the nominal controller.

#![allow(dead_code, clippy::unwrap_used, reason = "each test file uses its part, and a test may panic")]

use std::path::Path;

use messages::{Goal, RobotState, Stamp};
use nominal_mpc::{Inputs, NominalController};
use settings::{ControllerKind, RobotKind, Settings};

pub(crate) const MS: u64 = 1_000_000;

/// The shipped ground robot.
pub(crate) fn ground_robot() -> Settings {
    let text = include_str!("../../../config/ground_robot.toml");
    Settings::parse(text, Path::new("ground_robot.toml"), Path::new("config")).unwrap()
}

/// The paper's quadrotor, as far as the nominal controller looks.
pub(crate) fn quadrotor() -> Settings {
    let mut settings = ground_robot();
    settings.robot.kind = RobotKind::DoubleIntegrator;
    settings.nominal.controller = ControllerKind::Lqr;
    settings.nominal.lqr.state_weight = [4.0, 4.0, 1.0, 1.0];
    settings.nominal.lqr.control_weight = [1.0, 1.0];
    settings.nominal.lqr.max_position_error_m = 2.0;
    settings
}

/// The shipped ground robot under pure pursuit.
pub(crate) fn pursuer() -> Settings {
    let mut settings = ground_robot();
    settings.use_controller(ControllerKind::PurePursuit).unwrap();
    settings
}

pub(crate) fn stamp(valid_at_ns: u64) -> Stamp {
    Stamp {
        sequence: 9,
        source_ns: 77,
        valid_at_ns,
        ingress_ns: valid_at_ns + MS,
        published_ns: valid_at_ns + 2 * MS,
    }
}

/// A robot at rest at `[x_m, y_m, heading_rad]`.
pub(crate) fn state(pose: [f64; 3], valid_at_ns: u64) -> RobotState {
    RobotState {
        stamp: stamp(valid_at_ns),
        position_in_odom_m: [pose[0], pose[1]],
        heading_rad: pose[2],
        velocity_in_base_mps: [0.0; 2],
        yaw_rate_radps: 0.0,
    }
}

pub(crate) fn goal(x_m: f64, y_m: f64) -> Goal {
    Goal { stamp: stamp(0), position_in_odom_m: [x_m, y_m], heading_rad: 0.0 }
}

/// Inputs of a cycle in which `state` was just taken.
pub(crate) fn inputs<'a>(state: &'a RobotState, goal: &'a Goal) -> Inputs<'a> {
    Inputs {
        robot_state: Some(state),
        robot_state_received_ns: state.stamp.valid_at_ns + 3 * MS,
        goal: Some(goal),
    }
}

pub(crate) fn controller(settings: &Settings) -> NominalController {
    NominalController::new(settings).unwrap()
}
