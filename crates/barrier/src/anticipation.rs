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
use risk::{LANES, Risk};

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
    /// When each manoeuvre would be at the goal, s.
    times_s: Vec<f32>,
    candidates: Vec<Candidate>,
    /// The risk of each beginning that manoeuvres share, as far as it was asked for.
    begun: Vec<Risk>,
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
            times_s: vec![0.0; manoeuvres.count()],
            candidates: Vec::with_capacity(manoeuvres.count()),
            begun: vec![Risk::UNKNOWN; manoeuvres.beginnings()],
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
        let nominal_risk_s = self.people.whole_risk_s(&self.xs, &self.ys);
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
                + self.people.whole_risk_s(&self.xs, &self.ys)
                - CONTINUATION_BONUS_S;
            if cost_s < least_s {
                (least_s, best) = (cost_s, Best::UnderWay);
            }
        }
        self.manoeuvres.begin(x);
        self.candidates.clear();
        self.manoeuvres.times_to_goal_s(goal, &mut self.times_s);
        for (index, &time_s) in self.times_s.iter().enumerate() {
            if time_s < least_s {
                self.candidates.push(Candidate::new(time_s, index));
            }
        }
        // The quickest first: once one is slower than the best is costly, so are all after it. What is known of a beginning then
        // holds for whoever shares it, since the limit only falls.
        let mut pieces = 0;
        self.begun.fill(Risk::UNKNOWN);
        self.candidates.sort_unstable();
        for candidate in &self.candidates {
            let (time_s, index) = (candidate.time_s(), candidate.index());
            if time_s >= least_s || pieces > MOST_PIECES {
                break;
            }
            let (xs, ys) = self.manoeuvres.path(index);
            let limit_s = least_s - time_s;
            let (beginning, moments) = self.manoeuvres.beginning(index);
            let known = self.begun[beginning];
            let begun = self.people.risk_of_beginning(moments, xs, ys, known, limit_s);
            let risk = self.people.risk(xs, ys, begun, limit_s);
            self.begun[beginning] = begun;
            pieces += risk.pieces - known.pieces;
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // helpers of a test may panic

    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;

    const GOAL: [f64; 2] = [12.0, 0.0];

    /// What the tests of the people take, too.
    pub(super) const HORIZON: AnticipationHorizon = AnticipationHorizon {
        horizon_s: 3.0,
        moments: 32,
        clearance_m: 0.5,
        clearance_growth_mps: 0.15,
        risk_weight: 20.0,
        turn_share: 0.05,
        trust_s: 2.0,
        negligible_risk_s: 0.02,
        cruise_speed_mps: 1.0,
    };

    fn searches() -> [Anticipation; 2] {
        let unicycle =
            AnticipatingRobot::Unicycle { control: InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap() };
        let double_integrator = AnticipatingRobot::DoubleIntegrator {
            control: InputBox::new([-2.0; 2], [2.0; 2]).unwrap(),
            max_speed_mps: 2.0,
        };
        [unicycle, double_integrator].map(|robot| Anticipation::new(robot, HORIZON))
    }

    fn crowd(rng: &mut Pcg64) -> Vec<BarrierObstacle> {
        let mut within = |reach: f64| rng.random_range(-reach..reach);
        (0..8)
            .map(|_| {
                let [x, y, vx, vy] = [within(4.0), within(4.0), within(1.0), within(1.0)];
                BarrierObstacle { state: [x, y, vx, vy], rate: [vx, vy, 0.0, 0.0], radius_m: 0.7, model: 0 }
            })
            .collect()
    }

    #[test]
    fn the_search_finds_what_comparing_all_manoeuvres_finds() {
        let mut rng = Pcg64::seed_from_u64(7);
        for mut search in searches() {
            let mut chosen = 0;
            for _ in 0..40 {
                search.under_way = None;
                let x = [0.0, 0.0, rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0)];
                let people = crowd(&mut rng);
                let control = search.choose(&x, GOAL, &people, &[1.0; 8], 0.02);

                let frame = search.manoeuvres.frame(&x);
                let goal = frame.point(GOAL);
                search.manoeuvres.toward(&x, goal, &mut search.xs, &mut search.ys);
                let cost_s = |xs: &[f32], ys: &[f32]| {
                    search.manoeuvres.time_to_goal_s(xs, ys, goal) + search.people.whole_risk_s(xs, ys)
                };
                let nominal_s = cost_s(&search.xs, &search.ys);
                let of_all = (0..search.manoeuvres.count()).map(|index| {
                    let (xs, ys) = search.manoeuvres.path(index);
                    (cost_s(xs, ys), index)
                });
                let (least_s, index) = of_all.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
                if control.is_none() {
                    let negligible = search.people.whole_risk_s(&search.xs, &search.ys) <= 0.02;
                    assert!(negligible || nominal_s <= least_s);
                    continue;
                }
                chosen += 1;
                let best = search.manoeuvres.manoeuvre(index);
                assert_eq!(search.under_way.map(|(manoeuvre, _)| manoeuvre), Some(best));
            }
            assert!(chosen > 20, "{chosen} of 40");
        }
    }

    #[test]
    fn paths_are_what_following_the_manoeuvre_gives_and_alike_as_long_as_their_beginnings() {
        let x = [1.0, 2.0, 0.4, -0.3];
        for mut search in searches() {
            let manoeuvres = &mut search.manoeuvres;
            manoeuvres.begin(&x);
            let mut first_with = vec![None; manoeuvres.beginnings()];
            for index in 0..manoeuvres.count() {
                let (xs, ys) = manoeuvres.path(index);
                manoeuvres.follow(&manoeuvres.manoeuvre(index), 0.0, &x, &mut search.xs, &mut search.ys);
                assert_eq!((xs, ys), (search.xs.as_slice(), search.ys.as_slice()), "manoeuvre {index}");

                let (beginning, moments) = manoeuvres.beginning(index);
                let (first_xs, first_ys) = manoeuvres.path(*first_with[beginning].get_or_insert(index));
                assert_eq!((&xs[..moments], &ys[..moments]), (&first_xs[..moments], &first_ys[..moments]));
            }
            assert!(first_with.iter().all(Option::is_some) && first_with.len() < manoeuvres.count() / 2);
        }
    }

    #[test]
    fn times_to_the_goal_are_those_of_the_paths_whether_it_is_near_or_far() {
        let x = [0.0, 0.0, 0.2, 0.1];
        for mut search in searches() {
            search.manoeuvres.begin(&x);
            for goal in [[12.0, 1.0], [1.2, 0.3]] {
                search.manoeuvres.times_to_goal_s(goal, &mut search.times_s);
                for (index, &time_s) in search.times_s.iter().enumerate() {
                    let (xs, ys) = search.manoeuvres.path(index);
                    let left_m =
                        |moment: usize| (goal[0] as f32 - xs[moment]).hypot(goal[1] as f32 - ys[moment]);
                    let mut expected_s = 3.0 + left_m(31);
                    for moment in (3..31).step_by(4).filter(|&moment| left_m(moment) < 0.5) {
                        expected_s = expected_s.min((moment + 1) as f32 * 3.0 / 32.0 + left_m(moment));
                    }
                    assert!((time_s - expected_s).abs() < 1e-5, "{goal:?} {index}: {time_s}, {expected_s}");
                }
            }
        }
    }
}
