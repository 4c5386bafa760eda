//! The ground robot among things that do not move: the unicycle pair with the obstacle's motion taken away.

use crate::{HeadingFrame, InputBox, RelativeDynamics, RobotObstaclePair};

/// Unicycle robot and an obstacle that stands still.
///
/// * robot `x = [x_m, y_m, heading_rad]` in `odom`, control `u = [speed_mps, yaw_rate_radps]`;
/// * obstacle `o = [x_m, y_m, heading_rad, speed_mps]` in `odom`, of which only the position is looked at; no disturbance;
/// * relative `z = [x_rel_m, y_rel_m, 0, 0]`: the obstacle's centre seen from the robot (x forward, y left).
///
/// ```text
/// ż₁ = −v + ω z₂      ż₂ = −ω z₁      ż₃ = 0      ż₄ = 0
/// ```
///
/// The last two components neither move nor matter. They are kept so that the pair has the four relative states of its
/// moving sibling [`UnicyclePair`](crate::UnicyclePair) and fits wherever that one does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnicycleStaticPair {
    /// Limits of `[speed_mps, yaw_rate_radps]`.
    pub control: InputBox<2>,
}

/// The inputs of an obstacle that has none.
const NO_INPUT: InputBox<0> = InputBox { min: [], max: [] };

impl RelativeDynamics<4, 2, 0> for UnicycleStaticPair {
    fn drift(&self, _z: &[f64; 4]) -> [f64; 4] {
        [0.0; 4]
    }

    fn control_jacobian(&self, z: &[f64; 4]) -> [[f64; 2]; 4] {
        [[-1.0, z[1]], [0.0, -z[0]], [0.0, 0.0], [0.0, 0.0]]
    }

    fn disturbance_jacobian(&self, _z: &[f64; 4]) -> [[f64; 0]; 4] {
        [[]; 4]
    }

    fn control_box(&self) -> &InputBox<2> {
        &self.control
    }

    fn disturbance_box(&self) -> &InputBox<0> {
        &NO_INPUT
    }
}

impl RobotObstaclePair<3> for UnicycleStaticPair {
    type Frame = HeadingFrame;

    fn robot_frame(&self, x: &[f64; 3]) -> HeadingFrame {
        HeadingFrame::of(x)
    }

    fn relative_state_in(&self, frame: &HeadingFrame, o: &[f64; 4]) -> [f64; 4] {
        let [ahead, left] = frame.seen(o);
        [ahead, left, 0.0, 0.0]
    }

    fn relative_state_by_robot(&self, frame: &HeadingFrame, z: &[f64; 4]) -> [[f64; 3]; 4] {
        let &HeadingFrame { sin, cos, .. } = frame;
        [[-cos, -sin, z[1]], [sin, -cos, -z[0]], [0.0; 3], [0.0; 3]]
    }

    fn relative_state_by_obstacle(&self, frame: &HeadingFrame, _z: &[f64; 4]) -> [[f64; 4]; 4] {
        let &HeadingFrame { sin, cos, .. } = frame;
        [[cos, sin, 0.0, 0.0], [-sin, cos, 0.0, 0.0], [0.0; 4], [0.0; 4]]
    }

    fn robot_drift(&self, _x: &[f64; 3]) -> [f64; 3] {
        [0.0; 3]
    }

    fn robot_control_jacobian(&self, x: &[f64; 3]) -> [[f64; 2]; 3] {
        let (sin, cos) = x[2].sin_cos();
        [[cos, 0.0], [sin, 0.0], [0.0, 1.0]]
    }
}
