//! The online half of a pair: from the states of robot and obstacle to the relative state and back.

/// How the relative state depends on robot state `x` and obstacle state `o`, and how the robot moves.
///
/// Source: paper, equations `rho` and `h_bar_to_h`. Both pairs have four obstacle states, four relative
/// states and two controls. Positions of robot and obstacle are in `odom`.
pub trait RobotObstaclePair<const NX: usize>: Send + Sync {
    /// Returns `z = ρ(x, o)`.
    fn relative_state(&self, x: &[f64; NX], o: &[f64; 4]) -> [f64; 4];

    /// Returns `∂z/∂x`; an angle's jump at ±π is left out.
    fn relative_state_by_robot(&self, x: &[f64; NX], o: &[f64; 4]) -> [[f64; NX]; 4];

    /// Returns `∂z/∂o`; an angle's jump at ±π is left out.
    fn relative_state_by_obstacle(&self, x: &[f64; NX], o: &[f64; 4]) -> [[f64; 4]; 4];

    /// Returns `f(x)` of the robot, `ẋ = f(x) + g(x) u`.
    fn robot_drift(&self, x: &[f64; NX]) -> [f64; NX];

    /// Returns `g(x)` of the robot.
    fn robot_control_jacobian(&self, x: &[f64; NX]) -> [[f64; 2]; NX];
}
