//! Everybody together: one fixed-period step for people of all kinds of motion.
//!
//! Lives here: who pushes whom. The forces themselves are in `social_force`, what people do with them in `walker`,
//! interpolation to other times than the crowd's own ticks in `world`.

use crate::person::Person;
use crate::rectangle::Rectangle;
use crate::social_force::SocialForce;
use crate::walker::{Gait, Walk, Walker};

/// Period of the crowd's own step, ns: HuNavSim's Gazebo plugin updates at 100 Hz.
///
/// People always move in steps of this length, whatever period the robot is controlled at, so that controllers of
/// different rates face the same crowd.
pub const CROWD_PERIOD_NS: u64 = 10_000_000;

/// A crowd that feels itself, its goals and nothing else.
#[derive(Debug, Clone)]
pub struct Crowd {
    model: SocialForce,
    arena: Rectangle,
    time_s: f64,
    walkers: Vec<Walker>,
    /// `None` for everybody who feels no force: on a straight line or a track, or switching goals in this tick.
    forces_mps2: Vec<Option<[f64; 2]>>,
}

impl Crowd {
    /// Puts everybody at their start; walkers head for their first goal. `arena` has the walls that some bounce off.
    ///
    /// Walkers without goals never move; a valid scenario has none.
    pub fn new(model: SocialForce, arena: Rectangle, people: &[Person]) -> Self {
        let walkers: Vec<_> = people.iter().map(Walker::new).collect();
        let forces_mps2 = vec![None; walkers.len()];
        Self { model, arena, time_s: 0.0, walkers, forces_mps2 }
    }

    /// Number of people, absent ones included.
    pub fn len(&self) -> usize {
        self.walkers.len()
    }

    /// Whether the crowd has nobody, absent people included.
    pub fn is_empty(&self) -> bool {
        self.walkers.is_empty()
    }

    /// Whether person `index` (order of the scenario) is there now.
    pub fn is_present(&self, index: usize) -> bool {
        self.walkers[index].is_present
    }

    /// Position of person `index` in `odom`, m; of an absent one the last, or else the first one to come.
    pub fn position_m(&self, index: usize) -> [f64; 2] {
        self.walkers[index].position_m
    }

    /// Velocity of person `index` in `odom`, m/s.
    pub fn velocity_mps(&self, index: usize) -> [f64; 2] {
        self.walkers[index].velocity_mps
    }

    pub(crate) fn walkers(&self) -> &[Walker] {
        &self.walkers
    }

    /// Moves everybody by `dt_s` (s), all forces taken from one snapshot.
    ///
    /// By forces, people move by semi-implicit Euler with the speed capped at the desired one. Whoever is within the goal's
    /// radius plus 0.1 m turns to the next goal of the cycle instead and stays put for this tick. HuNavSim feeds back
    /// velocities that are differences of positions, so such a person starts the next tick from rest. Allocates nothing.
    pub fn step(&mut self, dt_s: f64) {
        for i in 0..self.walkers.len() {
            let walker = &self.walkers[i];
            self.forces_mps2[i] = match &walker.gait {
                Gait::SocialForce(walk) if !walk.has_arrived(walker.position_m) => {
                    Some(self.force_on(i, walk))
                }
                Gait::SocialForce(_) | Gait::Bounce | Gait::Track(_) => None,
            };
        }
        self.time_s += dt_s;
        for (walker, force) in self.walkers.iter_mut().zip(&self.forces_mps2) {
            walker.advance(*force, self.time_s, dt_s, &self.arena);
        }
    }

    fn force_on(&self, i: usize, walk: &Walk) -> [f64; 2] {
        let Walker { position_m, velocity_mps, .. } = &self.walkers[i];
        let [mut fx, mut fy] = self.model.goal_force(
            *position_m,
            *velocity_mps,
            walk.desired_speed_mps,
            walk.goal_m(*position_m),
            walk.goal_radius_m,
        );
        for (j, other) in self.walkers.iter().enumerate() {
            if j != i && other.is_present {
                let [px, py] =
                    self.model.pair_force(*position_m, *velocity_mps, other.position_m, other.velocity_mps);
                fx += px;
                fy += py;
            }
        }
        [fx, fy]
    }
}

#[cfg(test)]
mod tests {
    use settings::ClassName;

    use super::*;
    use crate::person::Motion;

    const ARENA: Rectangle = Rectangle { x_m: [-5.0, 5.0], y_m: [-5.0, 5.0] };

    fn walking(position_m: [f64; 2], goals_m: Vec<[f64; 2]>) -> Person {
        let motion = Motion::SocialForce {
            position_m,
            velocity_mps: [0.0, 0.0],
            goals_m,
            goal_radius_m: 0.3,
            desired_speed_mps: 1.0,
        };
        Person { id: 1, radius_m: 0.35, class: ClassName::Pedestrian, motion }
    }

    fn crowd(people: &[Person]) -> Crowd {
        Crowd::new(SocialForce::HUNAVSIM, ARENA, people)
    }

    fn goal_index(crowd: &Crowd) -> usize {
        match &crowd.walkers[0].gait {
            Gait::SocialForce(walk) => walk.goal_index(),
            Gait::Bounce | Gait::Track(_) => panic!("walks by forces"),
        }
    }

    #[test]
    fn goals_are_walked_in_a_cycle_with_one_tick_at_rest() {
        let mut crowd = crowd(&[walking([0.0, 0.0], vec![[2.0, 0.0], [0.0, 0.0]])]);
        let (mut switches, mut resting) = (Vec::new(), 0);
        for _ in 0..2000 {
            let (before_m, goal) = (crowd.position_m(0), goal_index(&crowd));
            crowd.step(0.01);
            if goal_index(&crowd) != goal {
                switches.push(before_m[0]);
                resting += usize::from(crowd.position_m(0) == before_m);
            }
        }
        assert!(switches.len() > 8, "{switches:?}");
        assert_eq!(switches.len(), resting, "the tick that switches the goal is one without motion");
        for pair in switches.chunks_exact(2) {
            assert!((1.6..1.62).contains(&pair[0]) && (0.38..=0.4).contains(&pair[1]), "{switches:?}");
        }
    }

    #[test]
    fn nobody_exceeds_the_desired_speed() {
        let people: Vec<_> = (0..6)
            .map(|k| {
                let angle = f64::from(k) * 1.047;
                let at = [2.0 * angle.cos(), 2.0 * angle.sin()];
                walking(at, vec![[-at[0], -at[1]], at])
            })
            .collect();
        let mut crowd = crowd(&people);
        for _ in 0..3000 {
            crowd.step(0.01);
            for i in 0..crowd.len() {
                let [vx, vy] = crowd.velocity_mps(i);
                assert!(vx.hypot(vy) <= 1.0 + 1e-12);
            }
        }
    }

    #[test]
    fn only_who_is_present_pushes() {
        let track = |times_s: Vec<f64>| Person {
            id: 2,
            radius_m: 0.35,
            class: ClassName::Pedestrian,
            motion: Motion::Track { times_s, positions_m: vec![[1.0, 0.3], [1.0, 0.3]] },
        };
        let alone = walking([0.0, 0.0], vec![[4.0, 0.0]]);
        let [mut lonely, mut late, mut met] = [
            crowd(std::slice::from_ref(&alone)),
            crowd(&[alone.clone(), track(vec![0.5, 9.0])]),
            crowd(&[alone, track(vec![0.0, 9.0])]),
        ];
        for tick in 1..=49 {
            for crowd in [&mut lonely, &mut late, &mut met] {
                crowd.step(0.01);
            }
            assert!(!late.is_present(1) && met.is_present(1));
            assert_eq!(late.position_m(0), lonely.position_m(0), "after {tick} ticks");
        }
        assert_ne!(met.position_m(0), lonely.position_m(0));
        for _ in 0..3 {
            lonely.step(0.01);
            late.step(0.01);
        }
        assert!(late.is_present(1) && late.position_m(0) != lonely.position_m(0));
    }
}
