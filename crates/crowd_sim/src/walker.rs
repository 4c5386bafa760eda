//! One person in motion: state, and how each kind of motion advances it.
//!
//! Not here: who pushes whom, which `crowd` sums up before anybody moves.

use crate::person::{Motion, Person};
use crate::rectangle::Rectangle;
use crate::track::Track;

/// Distance by which a goal counts as reached before its radius is entered, m (HuNavSim's behaviour tree).
const GOAL_REACHED_MARGIN_M: f64 = 0.1;

/// One person in motion.
#[derive(Debug, Clone)]
pub(crate) struct Walker {
    pub(crate) position_m: [f64; 2],
    pub(crate) velocity_mps: [f64; 2],
    /// Whether they are there at all; people on a recorded track come and go.
    pub(crate) is_present: bool,
    pub(crate) gait: Gait,
}

/// What a kind of motion has to remember.
#[derive(Debug, Clone)]
pub(crate) enum Gait {
    /// By forces.
    SocialForce(Walk),
    /// Straight on.
    Bounce,
    /// As recorded.
    Track(Track),
}

/// A cyclic walk between goals.
#[derive(Debug, Clone)]
pub(crate) struct Walk {
    goals_m: Vec<[f64; 2]>,
    goal_index: usize,
    pub(crate) goal_radius_m: f64,
    pub(crate) desired_speed_mps: f64,
}

impl Walker {
    /// Puts a person where they are at time zero.
    pub(crate) fn new(person: &Person) -> Self {
        match &person.motion {
            Motion::SocialForce { position_m, velocity_mps, goals_m, goal_radius_m, desired_speed_mps } => {
                Self {
                    position_m: *position_m,
                    velocity_mps: *velocity_mps,
                    is_present: true,
                    gait: Gait::SocialForce(Walk {
                        goals_m: goals_m.clone(),
                        goal_index: 0,
                        goal_radius_m: *goal_radius_m,
                        desired_speed_mps: *desired_speed_mps,
                    }),
                }
            }
            Motion::Bounce { position_m, velocity_mps } => Self {
                position_m: *position_m,
                velocity_mps: *velocity_mps,
                is_present: true,
                gait: Gait::Bounce,
            },
            Motion::Track { times_s, positions_m } => {
                let mut walker = Self {
                    position_m: person.start_m(),
                    velocity_mps: [0.0, 0.0],
                    is_present: false,
                    gait: Gait::Track(Track::new(times_s, positions_m)),
                };
                walker.follow_track(0.0);
                walker
            }
        }
    }

    /// Moves on by `dt_s` (s) to `time_s` (s since the start), by `force_mps2` if there is one.
    ///
    /// By forces: semi-implicit Euler, speed capped at the desired one; without a force somebody who has arrived turns to
    /// the next goal and stays put for this tick.
    pub(crate) fn advance(
        &mut self,
        force_mps2: Option<[f64; 2]>,
        time_s: f64,
        dt_s: f64,
        arena: &Rectangle,
    ) {
        match (&mut self.gait, force_mps2) {
            (Gait::SocialForce(walk), Some([fx, fy])) => {
                let [mut vx, mut vy] = [self.velocity_mps[0] + fx * dt_s, self.velocity_mps[1] + fy * dt_s];
                let speed_mps = vx.hypot(vy);
                if speed_mps > walk.desired_speed_mps {
                    let scale = walk.desired_speed_mps / speed_mps;
                    vx *= scale;
                    vy *= scale;
                }
                self.velocity_mps = [vx, vy];
                self.position_m = [self.position_m[0] + vx * dt_s, self.position_m[1] + vy * dt_s];
            }
            (Gait::SocialForce(walk), None) => {
                walk.turn_to_next_goal();
                self.velocity_mps = [0.0, 0.0];
            }
            (Gait::Bounce, _) => {
                let [vx, vy] = self.velocity_mps;
                self.position_m = [self.position_m[0] + vx * dt_s, self.position_m[1] + vy * dt_s];
                arena.reflect(&mut self.position_m, &mut self.velocity_mps);
            }
            (Gait::Track(_), _) => self.follow_track(time_s),
        }
    }

    fn follow_track(&mut self, time_s: f64) {
        let Gait::Track(track) = &mut self.gait else { return };
        let now = track.at(time_s);
        self.is_present = now.is_some();
        if let Some((position_m, velocity_mps)) = now {
            self.position_m = position_m;
            self.velocity_mps = velocity_mps;
        }
    }
}

impl Walk {
    /// The goal now, m; for somebody at `position_m` without goals, who has always arrived, that place.
    pub(crate) fn goal_m(&self, position_m: [f64; 2]) -> [f64; 2] {
        self.goals_m.get(self.goal_index).copied().unwrap_or(position_m)
    }

    /// Whether somebody at `position_m` (m) is within the goal's radius plus a margin.
    pub(crate) fn has_arrived(&self, position_m: [f64; 2]) -> bool {
        let goal_m = self.goal_m(position_m);
        let distance_m = (goal_m[0] - position_m[0]).hypot(goal_m[1] - position_m[1]);
        distance_m <= self.goal_radius_m + GOAL_REACHED_MARGIN_M
    }

    fn turn_to_next_goal(&mut self) {
        self.goal_index = (self.goal_index + 1) % self.goals_m.len().max(1);
    }

    #[cfg(test)]
    pub(crate) const fn goal_index(&self) -> usize {
        self.goal_index
    }
}
