//! The ground robot: a unicycle robot and a pedestrian who walks as a unicycle of constant speed.

use crate::{HeadingFrame, InputBox, RelativeDynamics, RobotObstaclePair, wrap_angle};

/// Unicycle robot and unicycle obstacle (paper, section on the ground robot).
///
/// * robot `x = [x_m, y_m, heading_rad]` in `odom`, control `u = [speed_mps, yaw_rate_radps]`;
/// * obstacle `o = [x_m, y_m, heading_rad, speed_mps]` in `odom`, disturbance `d = [turn_rate_radps]`;
/// * relative `z = [x_rel_m, y_rel_m, heading_rel_rad, obstacle_speed_mps]`: the obstacle's centre seen
///   from the robot (x forward, y left), its heading minus the robot's in `[-π, π)`, its speed.
///
/// ```text
/// ż₁ = z₄ cos z₃ − v + ω z₂      ż₂ = z₄ sin z₃ − ω z₁      ż₃ = ω_o − ω      ż₄ = 0
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnicyclePair {
    /// Limits of `[speed_mps, yaw_rate_radps]`.
    pub control: InputBox<2>,
    /// Limits of `[turn_rate_radps]`.
    pub disturbance: InputBox<1>,
}

impl RelativeDynamics<4, 2, 1> for UnicyclePair {
    fn drift(&self, z: &[f64; 4]) -> [f64; 4] {
        let (sin, cos) = z[2].sin_cos();
        [z[3] * cos, z[3] * sin, 0.0, 0.0]
    }

    fn control_jacobian(&self, z: &[f64; 4]) -> [[f64; 2]; 4] {
        [[-1.0, z[1]], [0.0, -z[0]], [0.0, -1.0], [0.0, 0.0]]
    }

    fn disturbance_jacobian(&self, _z: &[f64; 4]) -> [[f64; 1]; 4] {
        [[0.0], [0.0], [1.0], [0.0]]
    }

    fn control_box(&self) -> &InputBox<2> {
        &self.control
    }

    fn disturbance_box(&self) -> &InputBox<1> {
        &self.disturbance
    }
}

impl RobotObstaclePair<3> for UnicyclePair {
    type Frame = HeadingFrame;

    fn robot_frame(&self, x: &[f64; 3]) -> HeadingFrame {
        HeadingFrame::of(x)
    }

    fn relative_state_in(&self, frame: &HeadingFrame, o: &[f64; 4]) -> [f64; 4] {
        let [ahead, left] = frame.seen(o);
        [ahead, left, wrap_angle(o[2] - frame.x[2]), o[3]]
    }

    fn relative_state_by_robot(&self, frame: &HeadingFrame, z: &[f64; 4]) -> [[f64; 3]; 4] {
        let &HeadingFrame { sin, cos, .. } = frame;
        [[-cos, -sin, z[1]], [sin, -cos, -z[0]], [0.0, 0.0, -1.0], [0.0, 0.0, 0.0]]
    }

    fn relative_state_by_obstacle(&self, frame: &HeadingFrame, _z: &[f64; 4]) -> [[f64; 4]; 4] {
        let &HeadingFrame { sin, cos, .. } = frame;
        [[cos, sin, 0.0, 0.0], [-sin, cos, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
    }

    fn robot_drift(&self, _x: &[f64; 3]) -> [f64; 3] {
        [0.0; 3]
    }

    fn robot_control_jacobian(&self, x: &[f64; 3]) -> [[f64; 2]; 3] {
        let (sin, cos) = x[2].sin_cos();
        [[cos, 0.0], [sin, 0.0], [0.0, 1.0]]
    }
}
