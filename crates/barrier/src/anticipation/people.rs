//! Where people will be if they go on as they go.
//!
//! "As they go" is in their present direction, at the pace they are known to walk at: somebody who just turned is slow for a
//! moment only, and to believe that moment is to be run into. A person comes up to its pace `p` from its speed `v` by
//! `p t − (p − v) τₚ (1 − e^(−t/τₚ))`.
//!
//! Beside that, and with a small share of the weight, everybody may turn round at any moment: the second prediction of a person
//! stops now and comes straight to where the robot is, `p (t − τₚ (1 − e^(−t/τₚ)))` far.

use super::AnticipationHorizon;
use super::risk::{LANES, Piece, Pieces, Risk, Stretch};
use crate::lanes::{Group, Group8};
use crate::{BarrierObstacle, Kernel, MAX_OBSTACLES};

/// The axes in which paths are given: the robot's place, turned by the angle of `[cos, sin]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    pub(super) origin_m: [f64; 2],
    pub(super) cos_sin: [f64; 2],
}

impl Frame {
    /// A point of `odom` in these axes, m.
    pub(super) fn point(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        self.vector([x - self.origin_m[0], y - self.origin_m[1]])
    }

    /// A direction of `odom` in these axes.
    pub(super) fn vector(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [cos, sin] = self.cos_sin;
        [cos * x + sin * y, cos * y - sin * x]
    }
}

/// Below this speed nobody's direction is known, m/s.
const STANDING_MPS: f64 = 0.05;
/// What `(radius + ℓ)²` is made larger by, so that rounding takes nobody for far who is not.
const NEAR_MARGIN: f64 = 1.0 + 1e-4;
/// `τₚ`, s: walkers reach their pace in about a step.
const PACE_TIME_S: f64 = 0.3;

/// Predicted people, and how much they count when.
pub(super) struct People {
    step_s: f64,
    top_speed_mps: f64,
    /// `ℓ(t)`, m.
    clearance_m: Vec<f64>,
    /// `τₚ (1 − e^(−t/τₚ))`, s.
    catching_up_s: Vec<f64>,
    /// Weight that all who may turn have together.
    turn_share: f64,
    stretches: Vec<Stretch>,
    pieces: Vec<Piece>,
    /// How many pieces there are up to the end of each stretch.
    pieces_until: Vec<usize>,
    /// What computes the risk; the bits are the same on all.
    kernel: Kernel,
}

impl People {
    pub(super) fn new(horizon: &AnticipationHorizon, top_speed_mps: f64) -> Self {
        let step_s = horizon.horizon_s / horizon.moments as f64;
        let times_s = (1..=horizon.moments).map(|moment| step_s * moment as f64);
        let clearance_m: Vec<f64> =
            times_s.clone().map(|t_s| horizon.clearance_m + horizon.clearance_growth_mps * t_s).collect();
        let weight_s = |t_s: f64| (horizon.risk_weight * step_s * libm::exp(-t_s / horizon.trust_s)) as f32;
        let stretches = (0..horizon.moments / LANES).map(|at| Stretch {
            per_clearance: Group8(std::array::from_fn(|lane| (1.0 / clearance_m[at * LANES + lane]) as f32)),
            weight_s: Group8(std::array::from_fn(|lane| weight_s(step_s * (at * LANES + lane + 1) as f64))),
        });
        Self {
            step_s,
            top_speed_mps,
            stretches: stretches.collect(),
            clearance_m,
            catching_up_s: times_s.map(|t_s| PACE_TIME_S * (1.0 - libm::exp(-t_s / PACE_TIME_S))).collect(),
            turn_share: horizon.turn_share,
            pieces: Vec::with_capacity(2 * horizon.moments / LANES * MAX_OBSTACLES),
            pieces_until: Vec::with_capacity(horizon.moments / LANES),
            kernel: Kernel::detect(),
        }
    }

    /// Predicts `obstacles` at their `paces_mps` in `frame`, those of them whom the robot could come near, the soonest moments
    /// first.
    pub(super) fn predict(&mut self, frame: &Frame, obstacles: &[BarrierObstacle], paces_mps: &[f64]) {
        self.pieces.clear();
        self.pieces_until.clear();
        let turn_share = self.turn_share / obstacles.len().max(1) as f64;
        for stretch in 0..self.stretches.len() {
            for (obstacle, &pace_mps) in obstacles.iter().zip(paces_mps).take(MAX_OBSTACLES) {
                let place = frame.point([obstacle.state[0], obstacle.state[1]]);
                let velocity = frame.vector([obstacle.rate[0], obstacle.rate[1]]);
                let speed_mps = length(velocity);
                let pace_mps = pace_mps.max(speed_mps);
                // How much faster than now the person will walk, as a share of its speed now.
                let gain = if speed_mps > STANDING_MPS { pace_mps / speed_mps - 1.0 } else { 0.0 };
                let radius_m = obstacle.radius_m;
                self.add(stretch, radius_m, 1.0, |t_s, catching_up_s| {
                    let walked_s = t_s + gain * (t_s - catching_up_s);
                    [place[0] + velocity[0] * walked_s, place[1] + velocity[1] * walked_s]
                });
                if turn_share > 0.0 {
                    let approach = pace_mps / length(place).max(f64::MIN_POSITIVE);
                    self.add(stretch, radius_m, turn_share, |t_s, catching_up_s| {
                        let left = 1.0 - approach * (t_s - catching_up_s);
                        [left * place[0], left * place[1]]
                    });
                }
            }
            self.pieces_until.push(self.pieces.len());
        }
    }

    /// Adds a person who will be `at(t, τₚ (1 − e^(−t/τₚ)))`, unless the robot cannot come near in these moments.
    fn add(&mut self, stretch: usize, radius_m: f64, share: f64, at: impl Fn(f64, f64) -> [f64; 2]) {
        let (mut x, mut y, mut within_reach) = (Group8::ZERO, Group8::ZERO, false);
        let mut within_m2 = Group8::ZERO;
        for lane in 0..LANES {
            let moment = stretch * LANES + lane;
            let t_s = self.step_s * (moment + 1) as f64;
            let [at_x, at_y] = at(t_s, self.catching_up_s[moment]);
            let near_m = radius_m + self.clearance_m[moment];
            within_m2.0[lane] = (NEAR_MARGIN * near_m * near_m) as f32;
            let reach_m = self.top_speed_mps * t_s + near_m;
            within_reach |= at_x * at_x + at_y * at_y < reach_m * reach_m;
            (x.0[lane], y.0[lane]) = (at_x as f32, at_y as f32);
        }
        if within_reach {
            let (radius_m, share) = (radius_m as f32, share as f32);
            self.pieces.push(Piece { stretch, x, y, radius_m, within_m2, share });
        }
    }

    /// The risk of a whole path, s.
    pub(super) fn whole_risk_s(&self, xs: &[f32], ys: &[f32]) -> f32 {
        self.risk(xs, ys, Risk::UNKNOWN, f32::INFINITY).risk_s
    }

    /// The risk of a path of which a part is `known`. The search stops where it exceeds `limit_s`.
    pub(super) fn risk(&self, xs: &[f32], ys: &[f32], known: Risk, limit_s: f32) -> Risk {
        self.risk_of(&self.pieces, xs, ys, known, limit_s)
    }

    /// The same over what whole stretches there are in the first `moments` of the path.
    pub(super) fn risk_of_beginning(
        &self,
        moments: usize,
        xs: &[f32],
        ys: &[f32],
        known: Risk,
        limit_s: f32,
    ) -> Risk {
        let pieces = match moments / LANES {
            0 => 0,
            stretches => self.pieces_until[stretches - 1],
        };
        self.risk_of(&self.pieces[..pieces], xs, ys, known, limit_s)
    }

    fn risk_of(&self, pieces: &[Piece], xs: &[f32], ys: &[f32], known: Risk, limit_s: f32) -> Risk {
        let pieces = Pieces { stretches: &self.stretches, pieces };
        pieces.risk_on(self.kernel, [xs, ys].map(|way| way.as_chunks().0), known, limit_s)
    }
}

fn length([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::tests::HORIZON;
    use super::*;

    /// Somebody who stands, at distances from contact to far away: nobody is taken for far who is near in some moment.
    #[test]
    fn the_risk_of_passing_somebody_is_the_formulas_at_every_distance() {
        let horizon = AnticipationHorizon { turn_share: 0.0, ..HORIZON };
        let frame = Frame { origin_m: [0.0; 2], cos_sin: [1.0, 0.0] };
        let step_s = 3.0 / 32.0;
        let xs: Vec<f32> = (1..=32).map(|moment| (step_s * f64::from(moment)) as f32).collect();
        let mut people = People::new(&horizon, 1.0);
        let (mut free, mut near) = (0, 0);
        for centimetres in 0..250 {
            let place = [1.7, f64::from(centimetres) * 0.01, 0.0, 0.0];
            let obstacle = BarrierObstacle { state: place, rate: [0.0; 4], radius_m: 0.7, model: 0 };
            people.predict(&frame, &[obstacle], &[0.0]);
            let found_s = f64::from(people.whole_risk_s(&xs, &[0.0; 32]));
            let expected_s: f64 = (1..=32)
                .map(|moment| {
                    let t_s = step_s * f64::from(moment);
                    let distance_m = (t_s - place[0]).hypot(place[1]) - 0.7;
                    let lack = (1.0 - distance_m / (0.5 + 0.15 * t_s)).max(0.0);
                    20.0 * step_s * (-t_s / 2.0).exp() * lack.powi(4)
                })
                .sum();
            assert!((found_s - expected_s).abs() <= 1e-5 * expected_s + 1e-12, "{place:?}: {found_s}");
            if expected_s > 0.0 {
                near += 1;
            } else {
                free += 1;
            }
        }
        assert!(near > 100 && free > 50, "{near} near, {free} free");
    }
}
