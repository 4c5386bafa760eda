//! The fallback that needs no input at all: come to a halt.

use messages::{ControlKind, RobotState};
use settings::{RobotKind, RobotSettings};

/// Below this the robot counts as standing, m/s.
const STANDSTILL_MPS: f64 = 1e-3;

/// Remembers how fast the robot moves, so that it can be braked even when nothing is heard of it any more.
#[derive(Debug, Clone)]
pub(crate) struct Brake {
    kind: ControlKind,
    deceleration_mps2: f64,
    /// Unicycle: `[forward speed, 0]` as last commanded. Double integrator: velocity in `odom` as last measured.
    velocity_mps: [f64; 2],
    /// Whether a command was ever noted. Before that a unicycle's speed is what is measured: the filter may have been
    /// restarted while the robot moved.
    has_commanded: bool,
}

impl Brake {
    pub(crate) fn new(robot: &RobotSettings) -> Self {
        let kind = match robot.kind {
            RobotKind::Unicycle => ControlKind::Unicycle,
            RobotKind::DoubleIntegrator => ControlKind::DoubleIntegrator,
        };
        Self {
            kind,
            deceleration_mps2: robot.brake_deceleration_mps2,
            velocity_mps: [0.0; 2],
            has_commanded: false,
        }
    }

    /// Notes the command that was sent and the state it was made from, as the starting point of a later brake.
    pub(crate) fn note(&mut self, state: &RobotState, control: [f64; 2]) {
        self.has_commanded = true;
        self.velocity_mps = match self.kind {
            ControlKind::Unicycle => [control[0], 0.0],
            ControlKind::DoubleIntegrator => state.velocity_in_odom_mps(),
        };
    }

    /// Takes a fresh measurement while braking: the double integrator, whose command is an acceleration, always needs it,
    /// the unicycle only until it was commanded for the first time.
    pub(crate) fn observe(&mut self, state: &RobotState) {
        match self.kind {
            ControlKind::Unicycle if self.has_commanded => {}
            ControlKind::Unicycle => self.velocity_mps = [state.velocity_in_base_mps[0].max(0.0), 0.0],
            ControlKind::DoubleIntegrator => self.velocity_mps = state.velocity_in_odom_mps(),
        }
    }

    /// Braking for `elapsed_s` > 0 along the present direction of motion: the control, and whether the robot stands with it.
    pub(crate) fn step(&mut self, elapsed_s: f64) -> ([f64; 2], bool) {
        let speed = self.velocity_mps[0].hypot(self.velocity_mps[1]);
        if speed <= STANDSTILL_MPS {
            self.velocity_mps = [0.0; 2];
            return ([0.0; 2], true);
        }
        let slower = (speed - self.deceleration_mps2 * elapsed_s).max(0.0);
        let [vx, vy] = self.velocity_mps;
        let next = [vx * slower / speed, vy * slower / speed];
        let control = match self.kind {
            ControlKind::Unicycle => next,
            ControlKind::DoubleIntegrator => [(next[0] - vx) / elapsed_s, (next[1] - vy) / elapsed_s],
        };
        self.velocity_mps = next;
        (control, slower <= STANDSTILL_MPS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    fn quadrotor() -> RobotSettings {
        RobotSettings {
            kind: RobotKind::DoubleIntegrator,
            radius_m: 0.35,
            control_min: [-2.0; 2],
            control_max: [2.0; 2],
            brake_deceleration_mps2: 1.5,
        }
    }

    #[test]
    fn a_double_integrator_decelerates_along_its_motion_to_a_halt() {
        let mut brake = Brake::new(&quadrotor());
        let state = RobotState { velocity_in_base_mps: [0.6, -0.8], ..RobotState::zeroed() };
        brake.observe(&state);
        let (mut velocity, elapsed_s) = ([0.6, -0.8], 0.004);
        for cycle in 0..1000 {
            let (control, standing) = brake.step(elapsed_s);
            assert!(control[0].hypot(control[1]) <= 1.5 + 1e-9, "{control:?}");
            velocity = [velocity[0] + control[0] * elapsed_s, velocity[1] + control[1] * elapsed_s];
            if standing {
                assert!(velocity[0].hypot(velocity[1]) < 1e-9, "{velocity:?}");
                // 1 m/s at 1.5 m/s² and 4 ms a cycle.
                assert_eq!(cycle + 1, 167);
                return;
            }
        }
        panic!("never stands");
    }

    #[test]
    fn a_robot_that_stands_is_kept_standing() {
        assert_eq!(Brake::new(&quadrotor()).step(0.004), ([0.0; 2], true));
    }
}
