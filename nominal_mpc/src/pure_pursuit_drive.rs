//! Pure pursuit: the circle through a point ahead on the straight way to the goal.

use std::f64::consts::{FRAC_PI_2, PI};

use settings::{PurePursuitSettings, RobotSettings};

/// Nearer than this the point ahead makes no sensible circle, m.
const NEAREST_M: f64 = 1e-3;

/// The unicycle's simplest controller: a point, a circle, no optimisation.
#[derive(Debug, Clone)]
pub(crate) struct PurePursuitDrive {
    lookahead_m: f64,
    speed_mps: f64,
    min_speed_mps: f64,
    yaw_rate_range_radps: [f64; 2],
}

impl PurePursuitDrive {
    pub(crate) fn new(settings: &PurePursuitSettings, robot: &RobotSettings) -> Self {
        let [min_speed_mps, min_yaw_rate_radps] = robot.control_min;
        let [max_speed_mps, max_yaw_rate_radps] = robot.control_max;
        Self {
            lookahead_m: settings.lookahead_m,
            speed_mps: settings.speed_mps.clamp(min_speed_mps, max_speed_mps),
            min_speed_mps: min_speed_mps.max(0.0).min(max_speed_mps),
            yaw_rate_range_radps: [min_yaw_rate_radps, max_yaw_rate_radps],
        }
    }

    /// Control `[speed_mps, yaw_rate_radps]` from `pose` (`[x_m, y_m, heading_rad]`) towards `goal_in_odom_m`.
    ///
    /// Curvature is `2 sin(bearing) / distance` of the point ahead. Behind the robot that circle would straighten again: it
    /// turns there as for a point at its side. Where the yaw rate does not suffice for the curvature, speed gives way, down
    /// to the robot's least.
    pub(crate) fn control(&self, pose: &[f64; 3], goal_in_odom_m: [f64; 2]) -> [f64; 2] {
        let (dx, dy) = (goal_in_odom_m[0] - pose[0], goal_in_odom_m[1] - pose[1]);
        let bearing = (dy.atan2(dx) - pose[2] + PI).rem_euclid(2.0 * PI) - PI;
        let ahead_m = dx.hypot(dy).min(self.lookahead_m).max(NEAREST_M);
        let side = if bearing.abs() < FRAC_PI_2 { bearing.sin() } else { 1.0_f64.copysign(bearing) };
        let curvature = 2.0 * side / ahead_m;
        let [min_yaw_rate, max_yaw_rate] = self.yaw_rate_range_radps;
        let room = if curvature < 0.0 { -min_yaw_rate } else { max_yaw_rate };
        let speed = if curvature == 0.0 {
            self.speed_mps
        } else {
            self.speed_mps.min(room.max(0.0) / curvature.abs()).max(self.min_speed_mps)
        };
        [speed, (speed * curvature).clamp(min_yaw_rate, max_yaw_rate)]
    }
}
