//! A way through the crowd, looked for before anybody is near: the manoeuvre with the least sum of time and risk.
//!
//! The composite acts when some pair's worst case is at hand; among many people that is often too late, since no one control
//! answers all of them. [`Anticipation`] compares a fixed set of manoeuvres `m` of two parts (`manoeuvres`) over a few seconds,
//! in which people are predicted to go on as they go (`people`), and takes the one with the smallest
//!
//! ```text
//! J(m) = t_goal(m) + k · Σᵢ ∫₀ᵀ e^(−t/τ) · [ρ(cᵢ(t)) + q/M · ρ(c̃ᵢ(t))] dt,     ρ(c) = max(0, 1 − c/ℓ(t))⁴,  ℓ(t) = ℓ₀ + g·t
//! ```
//!
//! with `cᵢ(t)` the signed distance to person `i` of `M` at `t`, `c̃ᵢ(t)` the one if it turned round to the robot now, `t_goal` when the goal would be reached (the rest of the way at
//! cruising speed), and `e^(−t/τ)` the trust that the prediction still holds. Nothing is robust here: bounds are the barrier's
//! business, which corrects what comes out of this as it corrects any nominal control. Not here: who asks, how often, and what
//! follows (`cbf_filter`).

mod manoeuvres;
mod people;
pub(crate) mod risk;

use dynamics::InputBox;

use crate::BarrierObstacle;
use manoeuvres::{Manoeuvre, Manoeuvres};
use people::People;
use risk::LANES;

/// Going on as decided is preferred to something new by this much, s: without it two ways of equal cost alternate.
const CONTINUATION_BONUS_S: f32 = 0.05;

/// A search ends after as many pieces of eight moments: about 1 ms on one core of a server of 2023, a quarter of a cycle. Reached with
/// dozens of people within a few metres; the quickest manoeuvres have then been looked at.
const MOST_PIECES: usize = 150_000;

/// What an [`Anticipation`] weighs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AnticipationHorizon {
    /// `T`, s.
    pub horizon_s: f64,
    /// Moments in `T` at which distances are taken; rounded up to a multiple of eight.
    pub moments: usize,
    /// `ℓ₀`: signed distance from which on a person is no risk now, m.
    pub clearance_m: f64,
    /// `g`: how that distance grows with the time ahead, m/s.
    pub clearance_growth_mps: f64,
    /// `k`: seconds of way that one second in contact is worth.
    pub risk_weight: f64,
    /// `q`: weight of everybody's turning round to the robot, all together, where their going on has weight 1 each.
    pub turn_share: f64,
    /// `τ`: time after which a prediction counts 1/e, s.
    pub trust_s: f64,
    /// The nominal controller is left alone where its own way has less than this `k · Σ ∫`, s.
    pub negligible_risk_s: f64,
    /// Speed at which the way to the goal is made where nobody is near, m/s.
    pub cruise_speed_mps: f64,
}

/// The robot whose manoeuvres are compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AnticipatingRobot {
    /// Speed and yaw rate.
    Unicycle {
        /// Limits of `[speed m/s, yaw rate rad/s]`.
        control: InputBox<2>,
    },
    /// Accelerations.
    DoubleIntegrator {
        /// Limits of `[ax, ay]`, m/s².
        control: InputBox<2>,
        /// Speed along each axis that manoeuvres do not exceed, m/s.
        max_speed_mps: f64,
    },
}

/// The search for the best manoeuvre. Holds every buffer it needs: nothing allocates after construction.
pub struct Anticipation {
    horizon: AnticipationHorizon,
    manoeuvres: Manoeuvres,
    people: People,
    candidates: Vec<Candidate>,
    /// The manoeuvre under way and for how long it has been, s.
    under_way: Option<(Manoeuvre, f64)>,
    /// A path that is none of the fixed ones, m.
    xs: Vec<f32>,
    ys: Vec<f32>,
}

/// What has the least cost so far.
#[derive(Clone, Copy)]
enum Best {
    Nominal,
    UnderWay,
    Fixed(usize),
}

/// A manoeuvre that could be better than the best so far: time to the goal and index in one number, by which the quickest comes
/// first. Sorting numbers takes half as long as sorting pairs.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate(u64);

impl Candidate {
    /// `time_s` is not negative, so its bits are in its own order.
    fn new(time_s: f32, index: usize) -> Self {
        Self(u64::from(time_s.to_bits()) << 32 | index as u64)
    }

    fn time_s(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    fn index(self) -> usize {
        self.0 as u32 as usize
    }
}

impl Anticipation {
    /// Prepares the search.
    pub fn new(robot: AnticipatingRobot, horizon: AnticipationHorizon) -> Self {
        let moments = horizon.moments.max(1).next_multiple_of(LANES);
        let horizon = AnticipationHorizon { moments, ..horizon };
        let manoeuvres = Manoeuvres::new(robot, &horizon);
        Self {
            people: People::new(&horizon, manoeuvres.top_speed_mps()),
            candidates: Vec::with_capacity(manoeuvres.count()),
            manoeuvres,
            horizon,
            under_way: None,
            xs: vec![0.0; moments],
            ys: vec![0.0; moments],
        }
    }

    /// The control now of the best manoeuvre; `None` where the nominal controller's own way is the best or nobody is near it.
    ///
    /// `x` is the robot's state as its pair in `dynamics` states, the double integrator's `[x, y, vx, vy]` or the unicycle's
    /// `[x, y, heading, _]`; `obstacles` are as they are now and walk at `paces_mps` when nothing keeps them; the last call was
    /// `elapsed_s` ago.
    pub fn choose(
        &mut self,
        x: &[f64; 4],
        goal_in_odom_m: [f64; 2],
        obstacles: &[BarrierObstacle],
        paces_mps: &[f64],
        elapsed_s: f64,
    ) -> Option<[f64; 2]> {
        let frame = self.manoeuvres.frame(x);
        let goal = frame.point(goal_in_odom_m);
        self.people.predict(&frame, obstacles, paces_mps);
        self.manoeuvres.toward(x, goal, &mut self.xs, &mut self.ys);
        let nominal_risk_s = self.people.risk(&self.xs, &self.ys, f32::INFINITY).risk_s;
        if f64::from(nominal_risk_s) <= self.horizon.negligible_risk_s {
            self.under_way = None;
            return None;
        }
        let mut least_s = self.manoeuvres.time_to_goal_s(&self.xs, &self.ys, goal) + nominal_risk_s;
        let mut best = Best::Nominal;
        self.under_way = self
            .under_way
            .map(|(manoeuvre, begun_s)| (manoeuvre, begun_s + elapsed_s))
            .filter(|&(_, begun_s)| begun_s < self.horizon.horizon_s);
        if let Some((manoeuvre, begun_s)) = &self.under_way {
            self.manoeuvres.follow(manoeuvre, *begun_s, x, &mut self.xs, &mut self.ys);
            let cost_s = self.manoeuvres.time_to_goal_s(&self.xs, &self.ys, goal)
                + self.people.risk(&self.xs, &self.ys, f32::INFINITY).risk_s
                - CONTINUATION_BONUS_S;
            if cost_s < least_s {
                (least_s, best) = (cost_s, Best::UnderWay);
            }
        }
        self.manoeuvres.begin(x);
        self.candidates.clear();
        for index in 0..self.manoeuvres.count() {
            let (xs, ys) = self.manoeuvres.path(index);
            let time_s = self.manoeuvres.time_to_goal_s(xs, ys, goal);
            if time_s < least_s {
                self.candidates.push(Candidate::new(time_s, index));
            }
        }
        // The quickest first: once one is slower than the best is costly, so are all after it.
        let mut pieces = 0;
        self.candidates.sort_unstable();
        for candidate in &self.candidates {
            let (time_s, index) = (candidate.time_s(), candidate.index());
            if time_s >= least_s || pieces > MOST_PIECES {
                break;
            }
            let (xs, ys) = self.manoeuvres.path(index);
            let risk = self.people.risk(xs, ys, least_s - time_s);
            pieces += risk.pieces;
            if time_s + risk.risk_s < least_s {
                (least_s, best) = (time_s + risk.risk_s, Best::Fixed(index));
            }
        }
        self.under_way = match best {
            Best::Nominal => None,
            Best::UnderWay => self.under_way,
            Best::Fixed(index) => Some((self.manoeuvres.manoeuvre(index), 0.0)),
        };
        self.under_way.map(|(manoeuvre, begun_s)| self.manoeuvres.control(&manoeuvre, begun_s, x))
    }
}
