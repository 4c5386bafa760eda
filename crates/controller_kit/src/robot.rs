//! The robot of the bench: alone in an open field, it does what the candidate says.

use crowd_sim::{Plant, PlantError, PlantSettings, RobotStart};
use messages::{ControlKind, Intent, NominalCommand, RobotState, Stamp};
use settings::{RobotKind, Settings};

/// A plant that obeys nominal commands and brakes where there is none to obey.
pub(crate) struct Robot {
    plant: Plant,
    kind: ControlKind,
    deceleration_mps2: f64,
    silence_ns: u64,
}

impl Robot {
    /// At rest at the origin, looking along x.
    pub(crate) fn new(settings: &Settings) -> Result<Self, PlantError> {
        let start = RobotStart { position_m: [0.0; 2], heading_rad: 0.0 };
        Ok(Self {
            plant: Plant::new(PlantSettings::of(settings), start)?,
            kind: kind(settings),
            deceleration_mps2: settings.robot.brake_deceleration_mps2,
            silence_ns: settings.filter.nominal_max_silence_ms * 1_000_000,
        })
    }

    /// Moves for `dt_s` under `command`, as far as the filter would believe it at `now_ns`; brakes otherwise.
    pub(crate) fn step(&mut self, dt_s: f64, command: Option<&NominalCommand>, now_ns: u64) {
        let usable = command.filter(|command| {
            ControlKind::try_from(command.control_kind) == Ok(self.kind)
                && Intent::try_from(command.intent) == Ok(Intent::Drive)
                && command.control.iter().all(|value| value.is_finite())
                && now_ns.saturating_sub(command.stamp.published_ns) <= self.silence_ns
        });
        let control = usable.map_or_else(|| self.brake(dt_s), |command| command.control);
        self.plant.step(dt_s, control);
    }

    fn brake(&self, dt_s: f64) -> [f64; 2] {
        let [vx, vy] = self.plant.state().velocity_mps;
        let speed = vx.hypot(vy);
        let slower = (speed - self.deceleration_mps2 * dt_s).max(0.0);
        match self.kind {
            ControlKind::Unicycle => [slower, 0.0],
            ControlKind::DoubleIntegrator if speed > 0.0 => [vx, vy].map(|v| (v * slower / speed - v) / dt_s),
            ControlKind::DoubleIntegrator => [0.0; 2],
        }
    }

    /// Where it is, as the stack's message.
    pub(crate) fn state(&self, stamp: Stamp) -> RobotState {
        let state = self.plant.state();
        RobotState {
            stamp,
            position_in_odom_m: state.position_m,
            heading_rad: state.heading_rad,
            velocity_in_base_mps: state.body_velocity_mps(),
            yaw_rate_radps: state.yaw_rate_radps,
        }
    }

    /// Its place, m, and heading, rad.
    pub(crate) fn pose(&self) -> ([f64; 2], f64) {
        (self.plant.state().position_m, self.plant.state().heading_rad)
    }
}

/// What the two numbers of a control mean for the robot of `settings`.
pub(crate) const fn kind(settings: &Settings) -> ControlKind {
    match settings.robot.kind {
        RobotKind::Unicycle => ControlKind::Unicycle,
        RobotKind::DoubleIntegrator => ControlKind::DoubleIntegrator,
    }
}
