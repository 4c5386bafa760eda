//! The nominal controller on its way between goals on all sides, every cycle from where the last one led.

use messages::{Goal, NominalCommand, RobotState};
use nominal_mpc::{Inputs, NominalController};

use super::{settings, stamp};

/// Period of the controller.
pub const PERIOD_NS: u64 = 50_000_000;
/// A new goal after this many steps: 10 s.
pub const STEPS_PER_GOAL: usize = 200;
pub const GOALS_IN_ODOM_M: [[f64; 2]; 5] = [[13.0, 0.0], [-4.0, 3.0], [1.0, -6.0], [2.0, 2.0], [-9.0, -1.0]];

/// A closed loop of `NominalController::step` and a robot that does as it is told.
pub struct Drive {
    controller: NominalController,
    robot: RobotState,
    goal: Goal,
    steps: usize,
}

impl Drive {
    pub fn new() -> Self {
        Self {
            controller: NominalController::new(&settings()).unwrap(),
            robot: RobotState {
                stamp: stamp(0),
                position_in_odom_m: [0.0; 2],
                heading_rad: 0.0,
                velocity_in_base_mps: [0.0; 2],
                yaw_rate_radps: 0.0,
            },
            goal: Goal { stamp: stamp(0), position_in_odom_m: GOALS_IN_ODOM_M[0], heading_rad: 0.0 },
            steps: 0,
        }
    }

    /// Sets what the next step starts from.
    pub fn arrive(&mut self) {
        self.robot.stamp.valid_at_ns = self.steps as u64 * PERIOD_NS;
        self.goal.position_in_odom_m = GOALS_IN_ODOM_M[self.steps / STEPS_PER_GOAL % GOALS_IN_ODOM_M.len()];
        self.steps += 1;
    }

    /// The step itself.
    pub fn step(&mut self) -> NominalCommand {
        let now_ns = self.robot.stamp.valid_at_ns;
        let inputs = Inputs {
            robot_state: Some(&self.robot),
            robot_state_received_ns: now_ns,
            goal: Some(&self.goal),
        };
        self.controller.step(&inputs, now_ns).unwrap()
    }

    /// Moves the robot by one period of the command.
    pub fn follow(&mut self, command: &NominalCommand) {
        let period_s = PERIOD_NS as f64 * 1e-9;
        let [speed_mps, yaw_rate_radps] = command.control;
        let (sin, cos) = self.robot.heading_rad.sin_cos();
        self.robot.position_in_odom_m[0] += period_s * speed_mps * cos;
        self.robot.position_in_odom_m[1] += period_s * speed_mps * sin;
        self.robot.heading_rad = dynamics::wrap_angle(self.robot.heading_rad + period_s * yaw_rate_radps);
    }

    /// Pose `[x_m, y_m, heading_rad]` in `odom`.
    pub fn pose(&self) -> [f64; 3] {
        let [x, y] = self.robot.position_in_odom_m;
        [x, y, self.robot.heading_rad]
    }
}

impl Default for Drive {
    fn default() -> Self {
        Self::new()
    }
}
