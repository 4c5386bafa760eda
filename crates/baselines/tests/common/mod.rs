//! Settings, messages and stored problems for the tests.

#![allow(clippy::unwrap_used, reason = "a test may panic")]
#![allow(dead_code, unreachable_pub, reason = "every test takes what it needs")]

use std::path::{Path, PathBuf};

use barrier::Model;
use baselines::{Inputs, MethodOutput, MethodParameters};
use bytemuck::Zeroable;
use messages::{ControlKind, Goal, Intent, NominalCommand, Obstacle, Obstacles, RobotState};
use settings::Settings;

/// The time of every message and step, ns.
pub const NOW_NS: u64 = 1_000_000_000;

pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

pub fn ground_robot() -> Settings {
    Settings::load(&root().join("config/ground_robot_paper.toml")).unwrap()
}

pub fn quadrotor() -> Settings {
    Settings::load(&root().join("config/quadrotor_paper.toml")).unwrap()
}

pub fn model() -> Model {
    Model::load(&root().join("models/ground_robot_paper.safetensors")).unwrap()
}

/// A robot at `[x, y, heading]` that stands still.
pub fn robot([x, y, heading_rad]: [f64; 3]) -> RobotState {
    let mut state = RobotState::zeroed();
    state.stamp.valid_at_ns = NOW_NS;
    state.position_in_odom_m = [x, y];
    state.heading_rad = heading_rad;
    state
}

/// A robot at `[x, y, vx, vy]` with its axes along `odom`.
pub fn flying_robot([x, y, vx, vy]: [f64; 4]) -> RobotState {
    RobotState { velocity_in_base_mps: [vx, vy], ..robot([x, y, 0.0]) }
}

pub fn goal(position_in_odom_m: [f64; 2]) -> Goal {
    Goal { position_in_odom_m, ..Goal::zeroed() }
}

pub fn accelerate(control: [f64; 2]) -> NominalCommand {
    NominalCommand {
        control,
        control_kind: ControlKind::DoubleIntegrator.code(),
        intent: Intent::Drive.code(),
        ..NominalCommand::zeroed()
    }
}

/// A person of radius 0.35 m at `[x, y]` who walks with `[vx, vy]`.
pub fn person([x, y]: [f64; 2], [vx, vy]: [f64; 2]) -> Obstacle {
    Obstacle {
        track_id: 1,
        measured_at_ns: NOW_NS,
        valid_at_ns: NOW_NS,
        position_in_odom_m: [x, y],
        velocity_in_odom_mps: [vx, vy],
        heading_rad: vy.atan2(vx),
        speed_mps: vx.hypot(vy),
        radius_m: 0.35,
        ..Obstacle::zeroed()
    }
}

pub fn crowd(people: &[Obstacle]) -> Obstacles {
    let mut obstacles = Obstacles::zeroed();
    obstacles.count = people.len() as u32;
    obstacles.items[..people.len()].copy_from_slice(people);
    obstacles
}

/// One cycle of a planner that was made for it.
pub fn plan(
    parameters: &MethodParameters,
    start: [f64; 3],
    target: [f64; 2],
    people: &[Obstacle],
) -> MethodOutput {
    let model = model();
    let mut method = parameters.build(&ground_robot(), Some(&model)).unwrap();
    let (state, goal, obstacles) = (robot(start), goal(target), crowd(people));
    let inputs =
        Inputs { robot_state: Some(&state), obstacles: Some(&obstacles), goal: Some(&goal), nominal: None };
    method.step(&inputs, NOW_NS).unwrap()
}
