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
    /// How long a command is meant to hold, s.
    period_s: f64,
    /// Unicycle: `[forward speed, 0]` as last commanded. Double integrator: velocity in `odom`, measured or reckoned.
    velocity_mps: [f64; 2],
    /// Double integrator: the command in force since the last cycle, by which its velocity is reckoned.
    acceleration_mps2: [f64; 2],
    /// When the measurement that was last taken held, stack clock, ns. It is not taken twice: commands have changed the
    /// velocity since.
    observed_at_ns: Option<u64>,
    /// Whether the robot was ever set in motion, or braked, from here. Before that a unicycle's speed is what is measured:
    /// the filter may have been restarted while the robot moved.
    has_commanded: bool,
}

impl Brake {
    /// A brake for cycles of `period_s` > 0.
    pub(crate) fn new(robot: &RobotSettings, period_s: f64) -> Self {
        let kind = match robot.kind {
            RobotKind::Unicycle => ControlKind::Unicycle,
            RobotKind::DoubleIntegrator => ControlKind::DoubleIntegrator,
        };
        Self {
            kind,
            deceleration_mps2: robot.brake_deceleration_mps2,
            period_s,
            velocity_mps: [0.0; 2],
            acceleration_mps2: [0.0; 2],
            observed_at_ns: None,
            has_commanded: false,
        }
    }

    /// Notes the command that was sent and the state it was made from, as the starting point of a later brake.
    pub(crate) fn note(&mut self, state: &RobotState, control: [f64; 2]) {
        self.has_commanded = true;
        match self.kind {
            ControlKind::Unicycle => self.velocity_mps = [control[0], 0.0],
            ControlKind::DoubleIntegrator => {
                self.velocity_mps = state.velocity_in_odom_mps();
                self.observed_at_ns = Some(state.stamp.valid_at_ns);
                self.acceleration_mps2 = control;
            }
        }
    }

    /// Braking at a cycle that began `elapsed_s` > 0 after the last one, along the present direction of motion: the control,
    /// and whether the robot stands with it. `fresh` is what can be believed of the robot, if anything can.
    pub(crate) fn step(&mut self, fresh: Option<&RobotState>, elapsed_s: f64) -> ([f64; 2], bool) {
        self.observe(fresh, elapsed_s);
        let [vx, vy] = self.velocity_mps;
        let speed = vx.hypot(vy);
        if speed <= STANDSTILL_MPS {
            (self.velocity_mps, self.acceleration_mps2) = ([0.0; 2], [0.0; 2]);
            return ([0.0; 2], true);
        }
        self.has_commanded = true;
        // A speed is given for now, an acceleration for the time until the next cycle.
        let braked_s = match self.kind {
            ControlKind::Unicycle => elapsed_s,
            ControlKind::DoubleIntegrator => self.period_s,
        };
        let slower = (speed - self.deceleration_mps2 * braked_s).max(0.0);
        let next = [vx * slower / speed, vy * slower / speed];
        let control = match self.kind {
            ControlKind::Unicycle => {
                self.velocity_mps = next;
                next
            }
            ControlKind::DoubleIntegrator => {
                self.acceleration_mps2 = [(next[0] - vx) / braked_s, (next[1] - vy) / braked_s];
                self.acceleration_mps2
            }
        };
        (control, slower <= STANDSTILL_MPS)
    }

    /// Brings the velocity up to now: the double integrator, whose command is an acceleration, by every new measurement or
    /// else by what was commanded; the unicycle by measurements only until it was commanded for the first time.
    fn observe(&mut self, fresh: Option<&RobotState>, elapsed_s: f64) {
        let new = fresh.filter(|state| self.observed_at_ns != Some(state.stamp.valid_at_ns));
        self.observed_at_ns = new.map(|state| state.stamp.valid_at_ns).or(self.observed_at_ns);
        match (self.kind, new) {
            (ControlKind::Unicycle, Some(state)) if !self.has_commanded => {
                self.velocity_mps = [state.velocity_in_base_mps[0].max(0.0), 0.0];
            }
            (ControlKind::Unicycle, _) => {}
            (ControlKind::DoubleIntegrator, Some(state)) => self.velocity_mps = state.velocity_in_odom_mps(),
            (ControlKind::DoubleIntegrator, None) => {
                let [vx, vy] = self.velocity_mps;
                let [ax, ay] = self.acceleration_mps2;
                self.velocity_mps = [vx + ax * elapsed_s, vy + ay * elapsed_s];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    const PERIOD_S: f64 = 0.004;

    fn robot(kind: RobotKind) -> RobotSettings {
        RobotSettings {
            kind,
            radius_m: 0.35,
            control_min: [-2.0; 2],
            control_max: [2.0; 2],
            brake_deceleration_mps2: 1.5,
        }
    }

    fn brake(kind: RobotKind) -> Brake {
        Brake::new(&robot(kind), PERIOD_S)
    }

    fn moving(velocity_in_base_mps: [f64; 2]) -> RobotState {
        RobotState { velocity_in_base_mps, ..RobotState::zeroed() }
    }

    #[test]
    fn a_double_integrator_decelerates_along_its_motion_to_a_halt() {
        let mut brake = brake(RobotKind::DoubleIntegrator);
        let mut velocity = [0.6, -0.8];
        let mut fresh = Some(moving(velocity));
        for cycle in 0..1000 {
            let (control, standing) = brake.step(fresh.take().as_ref(), PERIOD_S);
            assert!(control[0].hypot(control[1]) <= 1.5 + 1e-9, "{control:?}");
            velocity = [velocity[0] + control[0] * PERIOD_S, velocity[1] + control[1] * PERIOD_S];
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
    fn a_double_integrator_of_which_nothing_is_heard_stands_however_its_cycles_fall() {
        // What a command does depends on how long it holds, which nobody knows when it is given.
        let mut once_late_s = [PERIOD_S; 10];
        once_late_s[7] = 5.0 * PERIOD_S;
        for gaps_s in [&[PERIOD_S][..], &[0.0005, 0.0035], &[0.003, 0.001], &once_late_s] {
            let mut brake = brake(RobotKind::DoubleIntegrator);
            brake.note(&moving([0.6, -0.8]), [1.0, 0.5]);
            let (mut velocity, mut control) = ([0.6, -0.8], [1.0, 0.5]);
            let mut gaps = gaps_s.iter().cycle();
            for _ in 0..2_000 {
                let gap_s = *gaps.next().unwrap();
                velocity = [velocity[0] + control[0] * gap_s, velocity[1] + control[1] * gap_s];
                (control, _) = brake.step(None, gap_s);
            }
            assert!(velocity[0].hypot(velocity[1]) <= STANDSTILL_MPS, "{gaps_s:?}: {velocity:?}");
            assert_eq!(brake.step(None, gaps_s[0]), ([0.0; 2], true), "{gaps_s:?}");
        }
    }

    #[test]
    fn a_unicycle_found_moving_decelerates_as_told_though_its_speed_is_measured_less_often() {
        let mut brake = brake(RobotKind::Unicycle);
        let state = moving([1.0, 0.0]);
        let mut speed = 1.0;
        for elapsed_s in [0.004, 0.0003, 0.0037, 0.004] {
            let ([next, _], _) = brake.step(Some(&state), elapsed_s);
            assert!((speed - next - 1.5 * elapsed_s).abs() < 1e-12, "{speed} -> {next} in {elapsed_s}");
            speed = next;
        }
    }

    #[test]
    fn a_robot_that_stands_is_kept_standing() {
        for kind in [RobotKind::Unicycle, RobotKind::DoubleIntegrator] {
            assert_eq!(brake(kind).step(None, PERIOD_S), ([0.0; 2], true));
        }
    }
}
