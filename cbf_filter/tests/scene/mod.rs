//! A robot on its way with people around it, as messages. Shared by the tests of this crate.

#![allow(dead_code, missing_docs, unreachable_pub)]

use barrier::{Bounds, DynamicsKind, InputEncoding, Model, NetworkWeights};
use bytemuck::Zeroable;
use cbf_filter::{Inputs, SafetyFilter, load_model};
use messages::{
    ControlKind, Goal, Intent, NominalCommand, Obstacle, ObstacleQuality, Obstacles, Reason, RobotState,
    SafeCommand, SafetyStatus, Stamp,
};
use node_runtime::Tick;
use settings::{FilterSettings, Settings};

pub const MS: u64 = 1_000_000;
pub const START_NS: u64 = 1_000 * MS;

/// The shipped settings with a buffer of their own, so that the scenes stay what they are when the default is tuned.
pub fn settings() -> Settings {
    let text = include_str!("../../../config/ground_robot.toml");
    let mut settings =
        Settings::parse(text, "ground_robot.toml".as_ref(), ".".as_ref()).expect("shipped settings");
    settings.filter.sdf_buffer_m = 0.05;
    settings
}

pub fn filter() -> SafetyFilter {
    filter_with(|_| {})
}

/// The same with changed settings.
pub fn filter_with(change: impl Fn(&mut FilterSettings)) -> SafetyFilter {
    let mut settings = settings();
    change(&mut settings.filter);
    let model = load_model(&settings.filter.model).expect("shipped model");
    SafetyFilter::new(&settings, &model).expect("shipped model fits shipped settings")
}

/// People so near and from so many sides that no control meets the composite's condition.
pub fn boxed_in() -> Scene {
    let people = [
        person(1, [0.75, 0.0], [-1.2, 0.0], START_NS),
        person(2, [0.4, 0.8], [-0.3, -1.2], START_NS),
        person(3, [0.4, -0.8], [-0.3, 1.2], START_NS),
    ];
    Scene::fresh(&people, START_NS)
}

/// What a command says of itself.
pub fn verdict(command: &SafeCommand) -> (SafetyStatus, Reason) {
    let status = SafetyStatus::try_from(command.status).expect("a known status");
    (status, Reason::try_from(command.reason).expect("a known reason"))
}
/// A model of static obstacles: the shipped weights, as far as they look at the position.
pub fn static_model() -> Model {
    let shipped = load_model(&settings().filter.model).expect("shipped model");
    let mut metadata = shipped.metadata().clone();
    metadata.dynamics = DynamicsKind::UnicycleStaticPair;
    metadata.encoding = InputEncoding::Position;
    metadata.disturbance = Bounds { min: vec![], max: vec![] };
    metadata.grid.min[2..].fill(-1.0);
    metadata.grid.max[2..].fill(1.0);
    metadata.grid.periodic = [false; 4];
    let mut layers = shipped.weights().layers().to_vec();
    let inputs = layers[0].weight.len() / layers[0].bias.len();
    layers[0].weight = layers[0].weight.chunks(inputs).flat_map(|row| row[..2].to_vec()).collect();
    let weights = NetworkWeights::new(InputEncoding::Position, layers).expect("two inputs");
    Model::new(weights, metadata).expect("a static model")
}

pub fn stamp(now_ns: u64) -> Stamp {
    Stamp { sequence: 1, source_ns: now_ns, valid_at_ns: now_ns, ingress_ns: now_ns, published_ns: now_ns }
}

pub fn robot_state(now_ns: u64) -> RobotState {
    RobotState {
        stamp: stamp(now_ns),
        position_in_odom_m: [0.0; 2],
        heading_rad: 0.0,
        velocity_in_base_mps: [0.8, 0.0],
        yaw_rate_radps: 0.0,
    }
}

pub fn nominal(now_ns: u64) -> NominalCommand {
    NominalCommand {
        stamp: stamp(now_ns),
        control: [0.8, 0.1],
        control_kind: ControlKind::Unicycle.code(),
        intent: Intent::Drive.code(),
        ..NominalCommand::zeroed()
    }
}

/// A person at `position` walking with `velocity`.
pub fn person(track_id: u64, position: [f64; 2], velocity: [f64; 2], now_ns: u64) -> Obstacle {
    Obstacle {
        track_id,
        measured_at_ns: now_ns,
        valid_at_ns: now_ns,
        position_in_odom_m: position,
        velocity_in_odom_mps: velocity,
        heading_rad: velocity[1].atan2(velocity[0]),
        speed_mps: velocity[0].hypot(velocity[1]),
        radius_m: 0.35,
        quality: ObstacleQuality::Full.code(),
        ..Obstacle::zeroed()
    }
}

pub fn obstacles(people: &[Obstacle], now_ns: u64) -> Obstacles {
    let mut message = Obstacles { stamp: stamp(now_ns), count: people.len() as u32, ..Obstacles::zeroed() };
    message.items[..people.len()].copy_from_slice(people);
    message
}

/// Everything one cycle takes.
pub struct Scene {
    pub robot_state: Option<RobotState>,
    pub obstacles: Option<Obstacles>,
    pub nominal: Option<NominalCommand>,
    pub goal: Option<Goal>,
}

impl Scene {
    /// A scene in which every input is fresh at `now_ns`.
    pub fn fresh(people: &[Obstacle], now_ns: u64) -> Self {
        Self {
            robot_state: Some(robot_state(now_ns)),
            obstacles: Some(obstacles(people, now_ns)),
            nominal: Some(nominal(now_ns)),
            goal: None,
        }
    }

    pub fn step(&self, filter: &mut SafetyFilter, now_ns: u64) -> SafeCommand {
        let inputs = Inputs {
            robot_state: self.robot_state.as_ref(),
            obstacles: self.obstacles.as_ref(),
            nominal: self.nominal.as_ref(),
            goal: self.goal.as_ref(),
        };
        filter.step(&inputs, Tick::timer(now_ns, now_ns))
    }
}
