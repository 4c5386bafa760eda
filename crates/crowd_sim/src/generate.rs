//! Random scenarios: people spawned anywhere in the arena, each with a cyclic list of random goals or a random heading.
//!
//! Drawn from PCG, whose stream is the same on every machine. People are drawn one after the other, so the scenario
//! with ten people begins with the five of the scenario with five.

use std::f64::consts::PI;

use rand::RngExt;
use rand_pcg::Pcg64;

use crate::person::{Motion, Person};
use crate::rectangle::Rectangle;
use crate::scenario::{MOST_PEOPLE, RobotStart, Scenario};
use crate::scenario_error::{ScenarioError, at_most};

/// PCG's stream selector; any odd-ish constant does, but changing it changes every scenario.
const STREAM: u128 = 0xA02B_DBF7_BB3C_0A7A_C28F_A16A_64AB_F96D;
/// Draws per person before the arena counts as full.
const MAX_DRAWS: usize = 10_000;

/// What the people of a random scenario do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrowdKind {
    /// Walk between random goals by the social force model.
    SocialForce,
    /// Walk straight on in a random direction and bounce off the arena's walls.
    Bounce,
}

/// What to draw a scenario from.
#[derive(Debug, Clone, PartialEq)]
pub struct ScenarioRequest {
    /// Seed of everything random.
    pub seed: u64,
    /// What they do.
    pub crowd: CrowdKind,
    /// Number of pedestrians.
    pub count: usize,
    /// Where they start and where their goals lie.
    pub arena: Rectangle,
    /// Range of the desired speeds, drawn uniformly, m/s.
    pub desired_speed_mps: [f64; 2],
    /// Goals per person.
    pub goals_per_person: usize,
    /// Radius of each goal, m.
    pub goal_radius_m: f64,
    /// Radius of each person, m.
    pub person_radius_m: f64,
    /// No person starts closer to the robot's start than this (centre to centre), m.
    pub clear_of_start_m: f64,
    /// Start of the robot.
    pub start: RobotStart,
    /// Goal of the robot, m.
    pub goal_m: [f64; 2],
    /// Distance from the goal at which it counts as reached, m.
    pub goal_tolerance_m: f64,
    /// Time after which a run has failed, s.
    pub time_limit_s: f64,
    /// Radius of the robot, m.
    pub robot_radius_m: f64,
}

/// Why no scenario could be drawn.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GenerateError {
    /// The arena has no room left.
    #[error(
        "only {placed} of {count} people fit into {arena:?} without touching; \
         enlarge the arena, or lower the count, the radii or `clear_of_start_m`"
    )]
    NoRoom {
        /// People placed before the arena was full.
        placed: usize,
        /// People asked for.
        count: usize,
        /// The arena.
        arena: Rectangle,
    },
    /// The speed range is empty, not finite or not positive.
    #[error("desired speeds {0:?} m/s are no range; give two positive numbers, the smaller one first")]
    BadSpeedRange([f64; 2]),
    /// The request leads to a scenario that cannot be run.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
}

impl ScenarioRequest {
    /// The demo: a 12 m by 8 m arena with ten people of 0.6 m/s to 1.2 m/s, the robot crossing from left to right.
    pub fn demo(seed: u64) -> Self {
        Self {
            seed,
            crowd: CrowdKind::SocialForce,
            count: 10,
            arena: Rectangle { x_m: [0.0, 12.0], y_m: [-4.0, 4.0] },
            desired_speed_mps: [0.6, 1.2],
            goals_per_person: 3,
            goal_radius_m: 0.3,
            person_radius_m: 0.35,
            clear_of_start_m: 2.0,
            start: RobotStart { position_m: [-1.5, 0.0], heading_rad: 0.0 },
            goal_m: [13.5, 0.0],
            goal_tolerance_m: 0.3,
            time_limit_s: 60.0,
            robot_radius_m: 0.35,
        }
    }

    /// The evaluation: people of 0.8 m/s to 1.5 m/s in 16 m by 10 m, crossed by either robot of the paper within 60 s.
    ///
    /// The paper states neither the rectangle nor speeds, start, goal or time; docs/scenarios.md has the reasons for these.
    /// They hold for the ground robot and the quadrotor alike.
    pub fn evaluation(seed: u64, count: usize) -> Self {
        Self {
            count,
            arena: Rectangle { x_m: [0.0, 16.0], y_m: [-5.0, 5.0] },
            desired_speed_mps: [0.8, 1.5],
            start: RobotStart { position_m: [-2.0, 0.0], heading_rad: 0.0 },
            goal_m: [13.0, 0.0],
            ..Self::demo(seed)
        }
    }

    /// Draws the scenario. The same request gives the same scenario on every machine.
    ///
    /// People start at least `clear_of_start_m` away from the robot's start and without touching one another.
    ///
    /// # Errors
    /// See [`GenerateError`].
    pub fn generate(&self) -> Result<Scenario, GenerateError> {
        let [slowest, fastest] = self.desired_speed_mps;
        if !(slowest > 0.0 && slowest <= fastest && fastest.is_finite()) {
            return Err(GenerateError::BadSpeedRange(self.desired_speed_mps));
        }
        at_most(|| "people".to_owned(), self.count, MOST_PEOPLE)?;
        let mut scenario = Scenario {
            name: format!("{}-people-seed-{}", self.count, self.seed),
            seed: self.seed,
            start: self.start,
            goal_m: self.goal_m,
            goal_heading_rad: 0.0,
            goal_tolerance_m: self.goal_tolerance_m,
            time_limit_s: self.time_limit_s,
            robot_radius_m: self.robot_radius_m,
            robot_limits: None,
            arena: self.arena,
            people: Vec::with_capacity(self.count),
        };
        scenario.validate()?;

        let mut random = Pcg64::new(u128::from(self.seed), STREAM);
        for placed in 0..self.count {
            let position_m = self
                .draw_free_place(&mut random, &scenario.people)
                .ok_or(GenerateError::NoRoom { placed, count: self.count, arena: self.arena })?;
            let motion = match self.crowd {
                CrowdKind::SocialForce => Motion::SocialForce {
                    position_m,
                    velocity_mps: [0.0, 0.0],
                    goals_m: (0..self.goals_per_person).map(|_| self.draw_point(&mut random)).collect(),
                    goal_radius_m: self.goal_radius_m,
                    desired_speed_mps: random.random_range(slowest..=fastest),
                },
                CrowdKind::Bounce => {
                    let speed_mps = random.random_range(slowest..=fastest);
                    let (sin, cos) = random.random_range(-PI..PI).sin_cos();
                    Motion::Bounce { position_m, velocity_mps: [speed_mps * cos, speed_mps * sin] }
                }
            };
            let id = placed as u64 + 1;
            scenario.people.push(Person { id, radius_m: self.person_radius_m, motion });
        }
        scenario.validate()?;
        Ok(scenario)
    }

    fn draw_point(&self, random: &mut Pcg64) -> [f64; 2] {
        let [x, y] = [self.arena.x_m, self.arena.y_m];
        [random.random_range(x[0]..=x[1]), random.random_range(y[0]..=y[1])]
    }

    fn draw_free_place(&self, random: &mut Pcg64, earlier: &[Person]) -> Option<[f64; 2]> {
        (0..MAX_DRAWS).map(|_| self.draw_point(random)).find(|&candidate| {
            distance_m(candidate, self.start.position_m) >= self.clear_of_start_m
                && earlier.iter().all(|person| {
                    distance_m(candidate, person.start_m()) >= person.radius_m + self.person_radius_m
                })
        })
    }
}

fn distance_m(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
