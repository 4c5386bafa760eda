//! Where people can be: for each person and moment a box that grows with the modelled disturbance, and a radius around it.
//!
//! The double integrator's person with `|aₖ| ≤ dₖ` and `|vₖ| ≤ v_max` on each axis fills the box exactly. The unicycle's person
//! with `|θ̇| ≤ ω` stays within `v ω t²/2` of its straight line: a point with a larger radius.

use dynamics::InputBox;

use super::{JointHorizon, JointRobot, LANES};
use crate::{BarrierObstacle, MAX_OBSTACLES};

/// One person over all moments of a block of the horizon: centre and half widths of the box, and the radius, m.
#[derive(Debug, Clone, Copy, Default)]
struct Block {
    x: [f32; LANES],
    y: [f32; LANES],
    half_x: [f32; LANES],
    half_y: [f32; LANES],
    radius: [f32; LANES],
}

#[derive(Debug, Clone, Copy)]
enum Motion {
    Turning { turn_rate_radps: f64 },
    Accelerating { limits: InputBox<2>, max_speed_mps: f64 },
}

/// Reach sets of everybody, seen from the robot.
#[derive(Debug)]
pub(super) struct Reach {
    motion: Motion,
    step_s: f64,
    blocks_each: usize,
    /// Person after person, each with `blocks_each` blocks.
    blocks: Vec<Block>,
}

impl Reach {
    pub(super) fn new(robot: &JointRobot, horizon: &JointHorizon) -> Self {
        let share = horizon.disturbance_share;
        let motion = match robot {
            JointRobot::Unicycle { turn_rate_radps, .. } => {
                Motion::Turning { turn_rate_radps: share * turn_rate_radps }
            }
            JointRobot::DoubleIntegrator { disturbance, .. } => Motion::Accelerating {
                limits: InputBox {
                    min: disturbance.min.map(|least| share * least),
                    max: disturbance.max.map(|most| share * most),
                },
                max_speed_mps: horizon.max_person_speed_mps,
            },
        };
        let blocks_each = horizon.moments / LANES;
        Self {
            motion,
            step_s: horizon.horizon_s / horizon.moments as f64,
            blocks_each,
            blocks: Vec::with_capacity(blocks_each * MAX_OBSTACLES),
        }
    }

    /// Fills the sets of `obstacles` for moments that begin `delay_s` from now, relative to `origin_m` in axes turned by the
    /// angle of `[cos, sin]`. The boxes of accelerating people need `[1, 0]`: they do not turn.
    pub(super) fn spread(
        &mut self,
        origin_m: [f64; 2],
        [cos, sin]: [f64; 2],
        delay_s: f64,
        obstacles: &[BarrierObstacle],
    ) {
        self.blocks.clear();
        for obstacle in obstacles.iter().take(MAX_OBSTACLES) {
            let [dx, dy] = [obstacle.state[0] - origin_m[0], obstacle.state[1] - origin_m[1]];
            let [vx, vy] = [obstacle.rate[0], obstacle.rate[1]];
            let place = [cos * dx + sin * dy, cos * dy - sin * dx];
            let velocity = [cos * vx + sin * vy, cos * vy - sin * vx];
            for block in 0..self.blocks_each {
                let mut filled = Block::default();
                for lane in 0..LANES {
                    let t_s = delay_s + self.step_s * (block * LANES + lane + 1) as f64;
                    let (centre, half, grown_m) = self.motion.at(&velocity, t_s);
                    filled.x[lane] = (place[0] + centre[0]) as f32;
                    filled.y[lane] = (place[1] + centre[1]) as f32;
                    filled.half_x[lane] = half[0] as f32;
                    filled.half_y[lane] = half[1] as f32;
                    filled.radius[lane] = (obstacle.radius_m + grown_m) as f32;
                }
                self.blocks.push(filled);
            }
        }
    }

    /// Smallest signed distance of a path to everybody, m, `+∞` without people. The search stops where it is below `floor`.
    pub(super) fn clearance(&self, xs: &[f32], ys: &[f32], floor: f32) -> f32 {
        let mut least = f32::INFINITY;
        for person in self.blocks.chunks_exact(self.blocks_each) {
            for (block, (x, y)) in person.iter().zip(xs.chunks_exact(LANES).zip(ys.chunks_exact(LANES))) {
                least = least.min(block.clearance(x, y));
            }
            if least < floor {
                return least;
            }
        }
        least
    }
}

impl Block {
    /// Smallest signed distance in the block: to the box outside of it, to its nearest side within it, less the radius.
    fn clearance(&self, xs: &[f32], ys: &[f32]) -> f32 {
        let mut distances = [0.0_f32; LANES];
        for lane in 0..LANES {
            let qx = (xs[lane] - self.x[lane]).abs() - self.half_x[lane];
            let qy = (ys[lane] - self.y[lane]).abs() - self.half_y[lane];
            let (ox, oy) = (larger(qx, 0.0), larger(qy, 0.0));
            let inside = larger(qx, qy);
            let inside = if inside < 0.0 { inside } else { 0.0 };
            distances[lane] = (ox * ox + oy * oy).sqrt() + inside - self.radius[lane];
        }
        distances
            .iter()
            .fold(f32::INFINITY, |least, &distance| if distance < least { distance } else { least })
    }
}

/// The larger of two numbers that are none of them NaN, in one instruction.
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

impl Motion {
    /// Displacement of the box's centre, its half widths and the growth of the radius after `t_s`, m.
    fn at(&self, velocity_mps: &[f64; 2], t_s: f64) -> ([f64; 2], [f64; 2], f64) {
        match self {
            Self::Turning { turn_rate_radps } => {
                let speed_mps = velocity_mps[0].hypot(velocity_mps[1]);
                (velocity_mps.map(|v| v * t_s), [0.0; 2], 0.5 * speed_mps * turn_rate_radps * t_s * t_s)
            }
            Self::Accelerating { limits, max_speed_mps } => {
                let far = [0, 1].map(|axis| {
                    let v = velocity_mps[axis];
                    let most = ramp(v, limits.max[axis], *max_speed_mps, t_s);
                    let least = -ramp(-v, -limits.min[axis], *max_speed_mps, t_s);
                    (0.5 * (least + most), 0.5 * (most - least))
                });
                (far.map(|(centre, _)| centre), far.map(|(_, half)| half), 0.0)
            }
        }
    }
}

/// Way after `t_s` with acceleration `a ≥ 0` from `v` until `limit` is reached, m; a faster one keeps its speed.
pub(super) fn ramp(v: f64, a: f64, limit: f64, t_s: f64) -> f64 {
    if v >= limit || a <= 0.0 {
        return v * t_s;
    }
    let ramp_s = ((limit - v) / a).min(t_s);
    v * ramp_s + 0.5 * a * ramp_s * ramp_s + (v + a * ramp_s) * (t_s - ramp_s)
}
