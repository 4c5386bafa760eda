//! The robot of a closed loop: starts where the recorded one did, obeys the safe commands.

use bytemuck::Zeroable;
use crowd_sim::{Plant, PlantError, PlantSettings, RobotStart};
use messages::{RobotState, SafeCommand};
use settings::{RobotKind, Settings};

use crate::command_sink::{CommandSink, SinkState};

const NS_PER_MS: u64 = 1_000_000;
const S_PER_NS: f64 = 1e-9;

/// A plant and its command sink, on the recording's time.
pub(super) struct SimulatedRobot {
    plant: Plant,
    sink: CommandSink,
    kind: RobotKind,
    step_ns: u64,
    state_period_ns: u64,
    /// Recording time of the plant's state, ns.
    at_ns: u64,
    next_state_ns: u64,
}

/// The robot after a step.
pub(super) struct Stepped {
    pub(super) at_ns: u64,
    pub(super) state: RobotState,
}

impl SimulatedRobot {
    /// At rest where `first` says.
    pub(super) fn new(settings: &Settings, first: &RobotState) -> Result<Self, PlantError> {
        let start = RobotStart { position_m: first.position_in_odom_m, heading_rad: first.heading_rad };
        Ok(Self {
            plant: Plant::new(PlantSettings::of(settings), start)?,
            sink: CommandSink::new(settings),
            kind: settings.robot.kind,
            step_ns: settings.simulation.step_ms * NS_PER_MS,
            state_period_ns: settings.simulation.robot_state_period_ms * NS_PER_MS,
            at_ns: 0,
            next_state_ns: 0,
        })
    }

    pub(super) fn command(&mut self, command: &SafeCommand, now_ns: u64) {
        self.sink.take(command, now_ns);
    }

    pub(super) fn sink_state(&self) -> SinkState {
        self.sink.state()
    }

    pub(super) fn refused_commands(&self) -> u64 {
        self.sink.refusals()
    }

    /// Recording time at which the next state is to be published, ns.
    pub(super) fn next_state_ns(&self) -> u64 {
        self.next_state_ns
    }

    /// Notes that the state at `at_ns` was published.
    pub(super) fn published(&mut self, at_ns: u64) {
        self.next_state_ns = at_ns + self.state_period_ns;
    }

    /// Takes one step if it does not go beyond recording time `until_ns`; the recording began at stack time `origin_ns`.
    pub(super) fn step_towards(&mut self, until_ns: u64, origin_ns: u64) -> Option<Stepped> {
        let end_ns = self.at_ns + self.step_ns;
        if end_ns > until_ns {
            return None;
        }
        let state = self.plant.state();
        let velocity_mps = match self.kind {
            RobotKind::Unicycle => state.body_velocity_mps(),
            RobotKind::DoubleIntegrator => state.velocity_mps,
        };
        let control = self.sink.control(origin_ns + end_ns, self.step_ns, velocity_mps);
        self.plant.step(self.step_ns as f64 * S_PER_NS, control);
        self.at_ns = end_ns;
        Some(Stepped { at_ns: end_ns, state: self.state() })
    }

    /// The robot as the stack's message, without stamp.
    pub(super) fn state(&self) -> RobotState {
        let state = self.plant.state();
        RobotState {
            position_in_odom_m: state.position_m,
            heading_rad: state.heading_rad,
            velocity_in_base_mps: state.body_velocity_mps(),
            yaw_rate_radps: state.yaw_rate_radps,
            ..RobotState::zeroed()
        }
    }
}
