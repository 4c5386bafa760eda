//! Brings robot and obstacles from the time of their measurement to the time of the cycle.

use barrier::BarrierObstacle;
use messages::{Obstacle, RobotState};
use settings::Settings;

const S_PER_NS: f64 = 1e-9;

/// Time from `from_ns` to `to_ns`, s; zero where the measurement is (within tolerance) ahead of the cycle.
fn elapsed_s(from_ns: u64, to_ns: u64) -> f64 {
    to_ns.saturating_sub(from_ns) as f64 * S_PER_NS
}

/// Robot pose `[x m, y m, heading rad]` in `odom` at `now_ns`, by its measured body velocity and yaw rate.
pub(crate) fn robot_pose(state: &RobotState, now_ns: u64) -> [f64; 3] {
    let age_s = elapsed_s(state.stamp.valid_at_ns, now_ns);
    let [vx, vy] = state.velocity_in_odom_mps();
    let [x, y] = state.position_in_odom_m;
    [x + vx * age_s, y + vy * age_s, dynamics::wrap_angle(state.heading_rad + state.yaw_rate_radps * age_s)]
}

/// How much is added to an obstacle's own radius.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Inflation {
    /// Robot radius plus the fixed buffer, m.
    fixed_m: f64,
    /// Motion that the prediction does not explain, m/s of age.
    unexplained_motion_mps: f64,
}

impl Inflation {
    pub(crate) fn new(settings: &Settings) -> Self {
        Self {
            fixed_m: settings.robot.radius_m + settings.filter.sdf_buffer_m,
            unexplained_motion_mps: settings.filter.unexplained_motion_mps,
        }
    }

    /// Effective radius at `now_ns`, m: an old measurement makes a larger obstacle, not a cliff.
    pub(crate) fn radius_m(&self, obstacle: &Obstacle, now_ns: u64) -> f64 {
        let age_s = elapsed_s(obstacle.measured_at_ns, now_ns);
        obstacle.radius_m + self.fixed_m + self.unexplained_motion_mps * age_s
    }
}

/// Obstacle as a walking unicycle o = `[x, y, heading, speed]` with ȯ, at `now_ns`.
pub(crate) fn unicycle_obstacle(obstacle: &Obstacle, inflation: &Inflation, now_ns: u64) -> BarrierObstacle {
    let age_s = elapsed_s(obstacle.valid_at_ns, now_ns);
    let [x, y] = obstacle.position_in_odom_m;
    let [vx, vy] = obstacle.velocity_in_odom_mps;
    let heading = dynamics::wrap_angle(obstacle.heading_rad + obstacle.heading_rate_radps * age_s);
    BarrierObstacle {
        state: [x + vx * age_s, y + vy * age_s, heading, obstacle.speed_mps],
        rate: [vx, vy, obstacle.heading_rate_radps, obstacle.speed_rate_mps2],
        radius_m: inflation.radius_m(obstacle, now_ns),
        model: 0,
    }
}

/// Obstacle as a double integrator o = `[x, y, vx, vy]` with ȯ, at `now_ns`.
pub(crate) fn double_integrator_obstacle(
    obstacle: &Obstacle,
    inflation: &Inflation,
    now_ns: u64,
) -> BarrierObstacle {
    let age_s = elapsed_s(obstacle.valid_at_ns, now_ns);
    let [x, y] = obstacle.position_in_odom_m;
    let [vx, vy] = obstacle.velocity_in_odom_mps;
    let [ax, ay] = obstacle.acceleration_in_odom_mps2;
    BarrierObstacle {
        state: [x + vx * age_s, y + vy * age_s, vx, vy],
        rate: [vx, vy, ax, ay],
        radius_m: inflation.radius_m(obstacle, now_ns),
        model: 0,
    }
}
