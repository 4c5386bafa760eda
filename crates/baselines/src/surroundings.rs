//! Robot and obstacles at the time of the cycle, and which obstacles a method looks at: the nearest ones inside a window,
//! as in the authors' code. Not here: any demand on them.

use messages::{Obstacle, Obstacles, RobotState};

use crate::parameters::SightParameters;

/// One obstacle at the time of the cycle, in `odom`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Seen {
    pub(crate) position_m: [f64; 2],
    pub(crate) velocity_mps: [f64; 2],
    pub(crate) acceleration_mps2: [f64; 2],
    pub(crate) heading_rad: f64,
    pub(crate) speed_mps: f64,
    /// Distance of the centres that counts as contact, m.
    pub(crate) contact_m: f64,
    /// Distance of the centres, m.
    pub(crate) distance_m: f64,
}

impl Seen {
    /// Somebody who walks across the way to the plan's origin, for the scaling of solvers.
    pub(crate) fn typical(contact_m: f64) -> Self {
        Self {
            position_m: [-1.5, 1.5],
            velocity_mps: [0.0, -1.0],
            acceleration_mps2: [0.0; 2],
            heading_rad: -std::f64::consts::FRAC_PI_2,
            speed_mps: 1.0,
            contact_m,
            distance_m: 1.5,
        }
    }

    /// Signed distance now, m.
    pub(crate) fn clearance_m(&self) -> f64 {
        self.distance_m - self.contact_m
    }
}

/// The obstacles a method looks at. Holds its buffer.
#[derive(Debug, Clone)]
pub(crate) struct Surroundings {
    sight: SightParameters,
    /// Robot radius plus margin, m.
    own_radius_m: f64,
    seen: Vec<Seen>,
}

fn age_s(from_ns: u64, to_ns: u64) -> f64 {
    to_ns.saturating_sub(from_ns) as f64 * 1e-9
}

/// Pose `[x m, y m, heading rad]` in `odom` at `now_ns`, by the measured velocities.
pub(crate) fn pose_at(state: &RobotState, now_ns: u64) -> [f64; 3] {
    let age_s = age_s(state.stamp.valid_at_ns, now_ns);
    let [x, y] = state.position_in_odom_m;
    let [vx, vy] = state.velocity_in_odom_mps();
    [x + vx * age_s, y + vy * age_s, dynamics::wrap_angle(state.heading_rad + state.yaw_rate_radps * age_s)]
}

impl Surroundings {
    pub(crate) fn new(sight: SightParameters, robot_radius_m: f64) -> Self {
        Self {
            sight,
            own_radius_m: robot_radius_m + sight.margin_m,
            seen: Vec::with_capacity(messages::MAX_OBSTACLES),
        }
    }

    /// Looks around a robot at `[x, y]`, m. The nearest come first; equally near ones as in the message.
    pub(crate) fn look(&mut self, obstacles: &Obstacles, robot_m: [f64; 2], now_ns: u64) -> &[Seen] {
        self.seen.clear();
        for obstacle in obstacles.as_slice() {
            let seen = self.place(obstacle, robot_m, now_ns);
            let inside =
                (0..2).all(|i| (seen.position_m[i] - robot_m[i]).abs() <= self.sight.window_half_width_m);
            if inside {
                let at = self.seen.partition_point(|other| other.distance_m <= seen.distance_m);
                self.seen.insert(at, seen);
            }
        }
        self.seen.truncate(self.sight.obstacle_limit);
        &self.seen
    }

    fn place(&self, obstacle: &Obstacle, robot_m: [f64; 2], now_ns: u64) -> Seen {
        let age_s = age_s(obstacle.valid_at_ns, now_ns);
        let [vx, vy] = obstacle.velocity_in_odom_mps;
        let [x, y] = obstacle.position_in_odom_m;
        let position_m = [x + vx * age_s, y + vy * age_s];
        Seen {
            position_m,
            velocity_mps: [vx, vy],
            acceleration_mps2: obstacle.acceleration_in_odom_mps2,
            heading_rad: obstacle.heading_rad + obstacle.heading_rate_radps * age_s,
            speed_mps: obstacle.speed_mps,
            contact_m: obstacle.radius_m + self.own_radius_m,
            distance_m: (position_m[0] - robot_m[0]).hypot(position_m[1] - robot_m[1]),
        }
    }
}
