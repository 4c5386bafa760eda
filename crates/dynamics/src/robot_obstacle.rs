//! The online half of a pair: from the states of robot and obstacle to the relative state and back.

/// How the relative state depends on robot state `x` and obstacle state `o`, and how the robot moves.
///
/// Source: paper, equations `rho` and `h_bar_to_h`. Both pairs have four obstacle states, four relative
/// states and two controls. Positions of robot and obstacle are in `odom`.
pub trait RobotObstaclePair<const NX: usize>: Send + Sync {
    /// What the relative states of all obstacles take from the robot state, so that it is worked out once for all of them.
    type Frame: Copy;

    /// Returns the frame of a robot in state `x`.
    fn robot_frame(&self, x: &[f64; NX]) -> Self::Frame;

    /// Returns `z = ρ(x, o)` for the frame of `x`.
    fn relative_state_in(&self, frame: &Self::Frame, o: &[f64; 4]) -> [f64; 4];

    /// Returns `∂z/∂x` at the relative state `z` in `frame`; an angle's jump at ±π is left out.
    fn relative_state_by_robot(&self, frame: &Self::Frame, z: &[f64; 4]) -> [[f64; NX]; 4];

    /// Returns `∂z/∂o` at the relative state `z` in `frame`; an angle's jump at ±π is left out.
    fn relative_state_by_obstacle(&self, frame: &Self::Frame, z: &[f64; 4]) -> [[f64; 4]; 4];

    /// Returns `z = ρ(x, o)`.
    fn relative_state(&self, x: &[f64; NX], o: &[f64; 4]) -> [f64; 4] {
        self.relative_state_in(&self.robot_frame(x), o)
    }

    /// Returns `f(x)` of the robot, `ẋ = f(x) + g(x) u`.
    fn robot_drift(&self, x: &[f64; NX]) -> [f64; NX];

    /// Returns `g(x)` of the robot.
    fn robot_control_jacobian(&self, x: &[f64; NX]) -> [[f64; 2]; NX];
}

/// A robot's pose with the sine and cosine of its heading: the frame of unicycles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadingFrame {
    pub(crate) x: [f64; 3],
    pub(crate) sin: f64,
    pub(crate) cos: f64,
}

impl HeadingFrame {
    /// The frame of the pose `[x m, y m, heading rad]`.
    pub fn of(x: &[f64; 3]) -> Self {
        let (sin, cos) = x[2].sin_cos();
        Self { x: *x, sin, cos }
    }

    /// A position in `odom`, m, as seen from the robot: `[ahead, left]`.
    pub(crate) fn seen(&self, o: &[f64; 4]) -> [f64; 2] {
        let (dx, dy) = (o[0] - self.x[0], o[1] - self.x[1]);
        [self.cos * dx + self.sin * dy, -self.sin * dx + self.cos * dy]
    }
}
