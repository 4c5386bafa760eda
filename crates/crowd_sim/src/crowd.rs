//! People who walk between their goals: one fixed-period step of the social force model for everybody.
//!
//! Lives here: integration, speed cap, goal switching. The forces are in `social_force`, interpolation to other times
//! than the crowd's own ticks in `world`.

use crate::scenario::Person;
use crate::social_force::SocialForce;

/// Period of the crowd's own step, ns: HuNavSim's Gazebo plugin updates at 100 Hz.
///
/// People always move in steps of this length, whatever period the robot is controlled at, so that controllers of
/// different rates face the same crowd.
pub const CROWD_PERIOD_NS: u64 = 10_000_000;

/// Distance by which a goal counts as reached before its radius is entered, m (HuNavSim's behaviour tree).
const GOAL_REACHED_MARGIN_M: f64 = 0.1;

/// One person in motion.
#[derive(Debug, Clone)]
pub(crate) struct Walker {
    pub(crate) person: Person,
    pub(crate) position_m: [f64; 2],
    pub(crate) velocity_mps: [f64; 2],
    goal_index: usize,
}

/// A crowd that feels itself, its goals and nothing else.
#[derive(Debug, Clone)]
pub struct Crowd {
    model: SocialForce,
    walkers: Vec<Walker>,
    /// `None` for a walker that switches goals in this tick and therefore does not move.
    forces_mps2: Vec<Option<[f64; 2]>>,
}

impl Crowd {
    /// Puts everybody at their start, at rest, heading for their first goal.
    ///
    /// People without goals never move; a valid scenario has none.
    pub fn new(model: SocialForce, people: &[Person]) -> Self {
        let walkers: Vec<_> = people
            .iter()
            .map(|person| Walker {
                position_m: person.position_m,
                velocity_mps: [0.0, 0.0],
                goal_index: 0,
                person: person.clone(),
            })
            .collect();
        let forces_mps2 = vec![None; walkers.len()];
        Self { model, walkers, forces_mps2 }
    }

    /// Number of people.
    pub fn len(&self) -> usize {
        self.walkers.len()
    }

    /// Whether nobody is there.
    pub fn is_empty(&self) -> bool {
        self.walkers.is_empty()
    }

    /// Position of person `index` (order of the scenario) in `odom`, m.
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

    /// Moves everybody by `dt_s` (s): all forces from one snapshot, then semi-implicit Euler with the speed capped at
    /// each person's desired speed.
    ///
    /// Whoever is within the goal's radius plus 0.1 m turns to the next goal of the cycle instead and stays put for
    /// this tick. HuNavSim feeds back velocities that are differences of positions, so such a person starts the next
    /// tick from rest. Allocates nothing.
    pub fn step(&mut self, dt_s: f64) {
        for i in 0..self.walkers.len() {
            self.forces_mps2[i] =
                if self.walkers[i].has_reached_goal() { None } else { Some(self.force_on(i)) };
        }
        for (walker, force) in self.walkers.iter_mut().zip(&self.forces_mps2) {
            match force {
                Some(force_mps2) => walker.advance(*force_mps2, dt_s),
                None => walker.turn_to_next_goal(),
            }
        }
    }

    fn force_on(&self, i: usize) -> [f64; 2] {
        let Walker { person, position_m, velocity_mps, .. } = &self.walkers[i];
        let goal_m = self.walkers[i].goal_m();
        let [mut fx, mut fy] = self.model.goal_force(
            *position_m,
            *velocity_mps,
            person.desired_speed_mps,
            goal_m,
            person.goal_radius_m,
        );
        for (j, other) in self.walkers.iter().enumerate() {
            if j != i {
                let [px, py] =
                    self.model.pair_force(*position_m, *velocity_mps, other.position_m, other.velocity_mps);
                fx += px;
                fy += py;
            }
        }
        [fx, fy]
    }
}

impl Walker {
    /// A person without goals has always arrived.
    fn goal_m(&self) -> [f64; 2] {
        self.person.goals_m.get(self.goal_index).copied().unwrap_or(self.position_m)
    }

    fn has_reached_goal(&self) -> bool {
        let goal_m = self.goal_m();
        let distance_m = (goal_m[0] - self.position_m[0]).hypot(goal_m[1] - self.position_m[1]);
        distance_m <= self.person.goal_radius_m + GOAL_REACHED_MARGIN_M
    }

    fn turn_to_next_goal(&mut self) {
        self.goal_index = (self.goal_index + 1) % self.person.goals_m.len().max(1);
        self.velocity_mps = [0.0, 0.0];
    }

    fn advance(&mut self, force_mps2: [f64; 2], dt_s: f64) {
        let [mut vx, mut vy] =
            [self.velocity_mps[0] + force_mps2[0] * dt_s, self.velocity_mps[1] + force_mps2[1] * dt_s];
        let speed_mps = vx.hypot(vy);
        if speed_mps > self.person.desired_speed_mps {
            let scale = self.person.desired_speed_mps / speed_mps;
            vx *= scale;
            vy *= scale;
        }
        self.velocity_mps = [vx, vy];
        self.position_m = [self.position_m[0] + vx * dt_s, self.position_m[1] + vy * dt_s];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn person(position_m: [f64; 2], goals_m: Vec<[f64; 2]>) -> Person {
        Person { id: 1, position_m, goals_m, goal_radius_m: 0.3, desired_speed_mps: 1.0, radius_m: 0.35 }
    }

    #[test]
    fn goals_are_walked_in_a_cycle_with_one_tick_at_rest() {
        let goals = vec![[2.0, 0.0], [0.0, 0.0]];
        let mut crowd = Crowd::new(SocialForce::HUNAVSIM, &[person([0.0, 0.0], goals)]);
        let (mut switches, mut resting) = (Vec::new(), 0);
        for _ in 0..2000 {
            let (before_m, goal) = (crowd.position_m(0), crowd.walkers[0].goal_index);
            crowd.step(0.01);
            if crowd.walkers[0].goal_index != goal {
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
                person(at, vec![[-at[0], -at[1]], at])
            })
            .collect();
        let mut crowd = Crowd::new(SocialForce::HUNAVSIM, &people);
        for _ in 0..3000 {
            crowd.step(0.01);
            for i in 0..crowd.len() {
                let [vx, vy] = crowd.velocity_mps(i);
                assert!(vx.hypot(vy) <= 1.0 + 1e-12);
            }
        }
    }
}
