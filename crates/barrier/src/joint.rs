//! People treated jointly and ahead of time: is there one manoeuvre that keeps clear of everybody at once, whatever each of
//! them does within bounds?
//!
//! The composite asks for one control whose effect on a weighted sum of pairwise barriers is large enough. Where people pull
//! in opposite directions no such control exists although each pair is fine, and then it is too late. [`JointEscape`] looks
//! ahead instead: over a fixed set of open-loop manoeuvres it computes
//!
//! ```text
//! V_J(x) = max over manoeuvres m of  min over people i, times t ≤ T of  dist(p_m(t), P_i(t)) − R_i
//! ```
//!
//! with `P_i(t)` all places that person `i` can be at (`reach`). `V_J ≥ 0` is sufficient for the joint game to be won up to
//! `T`, since a manoeuvre that ignores what people do is one of the robot's strategies. Not here: who asks and what follows
//! (`cbf_filter`), how the robot moves in a manoeuvre (`manoeuvre`).

mod manoeuvre;
mod reach;

use dynamics::InputBox;

use crate::BarrierObstacle;
use manoeuvre::Manoeuvres;
use reach::Reach;

/// Times at which a manoeuvre is looked at are computed this many at once.
pub(crate) const LANES: usize = 8;

/// What a [`JointEscape`] looks at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointHorizon {
    /// `T`, s.
    pub horizon_s: f64,
    /// Moments in `T` at which distances are taken; rounded up to a multiple of eight.
    pub moments: usize,
    /// Controls per component in the grid of manoeuvres, at least 2.
    pub levels: usize,
    /// Part of the modelled disturbance that people are granted, 0 to 1: 1 is the game of the model, 0 a constant velocity.
    pub disturbance_share: f64,
    /// Speed that no person exceeds, m/s; along each axis for the double integrator.
    pub max_person_speed_mps: f64,
    /// Speed along each axis at which a double integrator stops to accelerate, m/s; infinite if it has no limit.
    pub max_robot_speed_mps: f64,
    /// Time after which a manoeuvre with two parts goes over to the second, s.
    pub switch_s: f64,
}

/// The robot, and by which of its two pairs people move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointRobot {
    /// Speed and yaw rate; people turn by at most `turn_rate_radps`.
    Unicycle {
        /// Limits of `[speed m/s, yaw rate rad/s]`.
        control: InputBox<2>,
        /// Largest turn rate of a person, rad/s.
        turn_rate_radps: f64,
    },
    /// Accelerations; people accelerate within `disturbance`.
    DoubleIntegrator {
        /// Limits of `[ax, ay]`, m/s².
        control: InputBox<2>,
        /// Limits of a person's `[ax, ay]`, m/s².
        disturbance: InputBox<2>,
    },
}

/// A manoeuvre that was chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Escape {
    /// Its control now.
    pub u: [f64; 2],
    /// Smallest clearance to anybody over the horizon, m; negative where someone could touch the robot.
    pub clearance_m: f64,
}

/// The search for a manoeuvre that keeps clear of everybody. Holds every buffer it needs: nothing allocates after
/// construction.
pub struct JointEscape {
    manoeuvres: Manoeuvres,
    reach: Reach,
    /// Place of the manoeuvre that passed last: asked first.
    last: usize,
}

impl JointEscape {
    /// Prepares the search.
    pub fn new(robot: JointRobot, horizon: JointHorizon) -> Self {
        let moments = horizon.moments.max(1).next_multiple_of(LANES);
        let horizon = JointHorizon { moments, levels: horizon.levels.max(2), ..horizon };
        Self { manoeuvres: Manoeuvres::new(&robot, &horizon), reach: Reach::new(&robot, &horizon), last: 0 }
    }

    /// Whether after the control `u` for `period_s` some manoeuvre keeps at least `margin_m` from everybody.
    ///
    /// `x` is the robot's state as its pair in `dynamics` states, the double integrator's `[x, y, vx, vy]` or the unicycle's
    /// `[x, y, heading, _]`; `obstacles` are as they are now.
    pub fn remains_after(
        &mut self,
        x: &[f64; 4],
        u: &[f64; 2],
        period_s: f64,
        obstacles: &[BarrierObstacle],
        margin_m: f64,
    ) -> bool {
        let next = self.manoeuvres.after(x, u, period_s);
        self.look(&next, period_s, obstacles);
        let floor = margin_m as f32;
        let count = self.manoeuvres.count();
        for offset in 0..count {
            let index = (self.last + offset) % count;
            if self.clearance(index, floor) >= floor {
                self.last = index;
                return true;
            }
        }
        false
    }

    /// The manoeuvre nearest to `wish` among those that keep at least `margin_m` from everybody; where there is none, the one
    /// with the largest clearance.
    ///
    /// Arguments as in [`JointEscape::remains_after`].
    pub fn escape(
        &mut self,
        x: &[f64; 4],
        wish: &[f64; 2],
        obstacles: &[BarrierObstacle],
        margin_m: f64,
    ) -> Escape {
        self.look(x, 0.0, obstacles);
        let floor = margin_m as f32;
        let mut best = (f32::NEG_INFINITY, f64::INFINITY, 0);
        for index in 0..self.manoeuvres.count() {
            let distance = self.manoeuvres.distance(index, wish);
            // A clear manoeuvre is only beaten by a nearer one that is clear too.
            let found = best.0 >= floor;
            if found && distance >= best.1 {
                continue;
            }
            let needed = if found { floor } else { best.0 };
            let clearance = self.clearance(index, needed);
            if clearance > best.0 || clearance >= floor {
                best = (clearance, distance, index);
            }
        }
        self.last = best.2;
        Escape { u: self.manoeuvres.control(best.2), clearance_m: f64::from(best.0) }
    }

    fn look(&mut self, x: &[f64; 4], delay_s: f64, obstacles: &[BarrierObstacle]) {
        let [cos, sin] = self.manoeuvres.begin(x);
        self.reach.spread([x[0], x[1]], [cos, sin], delay_s, obstacles);
    }

    /// Clearance of a manoeuvre, m; anything below `floor` where it falls short of it.
    fn clearance(&mut self, index: usize, floor: f32) -> f32 {
        let (xs, ys) = self.manoeuvres.path(index);
        self.reach.clearance(xs, ys, floor)
    }
}
