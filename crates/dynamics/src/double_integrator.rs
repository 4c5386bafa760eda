//! The quadrotor in the plane: robot and obstacle as double integrators.

use crate::{InputBox, RelativeDynamics, RobotObstaclePair};

/// Double-integrator robot and obstacle (paper, section on the quadrotor).
///
/// * robot `x = [x_m, y_m, vx_mps, vy_mps]` in `odom`, control `u = [ax_mps2, ay_mps2]`;
/// * obstacle `o = [x_m, y_m, vx_mps, vy_mps]` in `odom`, disturbance `d = [ax_mps2, ay_mps2]`;
/// * relative `z = o − x`, axes of `odom`, so that `ż = [z₃, z₄, d₁ − u₁, d₂ − u₂]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DoubleIntegratorPair {
    /// Limits of the robot's `[ax_mps2, ay_mps2]`.
    pub control: InputBox<2>,
    /// Limits of the obstacle's `[ax_mps2, ay_mps2]`.
    pub disturbance: InputBox<2>,
}

impl RelativeDynamics<4, 2, 2> for DoubleIntegratorPair {
    fn drift(&self, z: &[f64; 4]) -> [f64; 4] {
        [z[2], z[3], 0.0, 0.0]
    }

    fn control_jacobian(&self, _z: &[f64; 4]) -> [[f64; 2]; 4] {
        [[0.0, 0.0], [0.0, 0.0], [-1.0, 0.0], [0.0, -1.0]]
    }

    fn disturbance_jacobian(&self, _z: &[f64; 4]) -> [[f64; 2]; 4] {
        [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
    }

    fn control_box(&self) -> &InputBox<2> {
        &self.control
    }

    fn disturbance_box(&self) -> &InputBox<2> {
        &self.disturbance
    }
}

impl RobotObstaclePair<4> for DoubleIntegratorPair {
    type Frame = [f64; 4];

    fn robot_frame(&self, x: &[f64; 4]) -> [f64; 4] {
        *x
    }

    fn relative_state_in(&self, x: &[f64; 4], o: &[f64; 4]) -> [f64; 4] {
        std::array::from_fn(|i| o[i] - x[i])
    }

    fn relative_state_by_robot(&self, _x: &[f64; 4], _z: &[f64; 4]) -> [[f64; 4]; 4] {
        diagonal(-1.0)
    }

    fn relative_state_by_obstacle(&self, _x: &[f64; 4], _z: &[f64; 4]) -> [[f64; 4]; 4] {
        diagonal(1.0)
    }

    fn robot_drift(&self, x: &[f64; 4]) -> [f64; 4] {
        [x[2], x[3], 0.0, 0.0]
    }

    fn robot_control_jacobian(&self, _x: &[f64; 4]) -> [[f64; 2]; 4] {
        [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
    }
}

/// Returns `value` times the identity.
fn diagonal(value: f64) -> [[f64; 4]; 4] {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { value } else { 0.0 }))
}
