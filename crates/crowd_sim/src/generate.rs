//! Random scenarios: people spawned anywhere in the arena, each with a cyclic list of random goals or a random heading; if
//! asked for, cyclists and standing things among them.
//!
//! Drawn from PCG, whose stream is the same on every machine. People are drawn one after the other, so the scenario
//! with ten people begins with the five of the scenario with five.

use std::f64::consts::PI;

use rand::RngExt;
use rand_pcg::Pcg64;
use settings::{ClassName, ClassesSettings};

use crate::person::{Motion, Person};
use crate::rectangle::Rectangle;
use crate::scenario::{MOST_PEOPLE, RobotStart, Scenario};
use crate::scenario_error::{ScenarioError, at_most};

/// PCG's stream selector; any odd-ish constant does, but changing it changes every scenario.
const STREAM: u128 = 0xA02B_DBF7_BB3C_0A7A_C28F_A16A_64AB_F96D;
/// The same for who is what: a stream of its own, so that crowds of pedestrians only are as they ever were.
const CLASS_STREAM: u128 = 0x5F1D_36C8_9A4E_B207_31EE_8C55_D7A0_62B9;
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
    /// Number of people, cyclists and things included.
    pub count: usize,
    /// Who of them is no pedestrian; all are pedestrians without it.
    pub classes: Option<ClassesSettings>,
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
            classes: None,
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
        is_speed_range(self.desired_speed_mps)?;
        self.classes.map_or(Ok(()), |classes| is_speed_range(classes.cyclist_speed_mps))?;
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
        let mut classes = Pcg64::new(u128::from(self.seed), CLASS_STREAM);
        for placed in 0..self.count {
            let (class, radius_m) = self.draw_class(&mut classes);
            let position_m = self
                .draw_free_place(&mut random, &scenario.people, class, radius_m)
                .ok_or(GenerateError::NoRoom { placed, count: self.count, arena: self.arena })?;
            let motion = self.draw_motion(&mut random, class, position_m);
            let id = placed as u64 + 1;
            scenario.people.push(Person { id, radius_m, class, motion });
        }
        scenario.validate()?;
        Ok(scenario)
    }

    /// What the next one is, and its radius, m.
    fn draw_class(&self, random: &mut Pcg64) -> (ClassName, f64) {
        let pedestrian = (ClassName::Pedestrian, self.person_radius_m);
        let Some(classes) = &self.classes else { return pedestrian };
        let drawn: f64 = random.random();
        if drawn < classes.cyclist_share {
            (ClassName::Cyclist, classes.cyclist_radius_m)
        } else if drawn < classes.cyclist_share + classes.static_share {
            (ClassName::Static, classes.static_radius_m)
        } else {
            pedestrian
        }
    }

    fn draw_motion(&self, random: &mut Pcg64, class: ClassName, position_m: [f64; 2]) -> Motion {
        match (class, self.crowd, &self.classes) {
            (ClassName::Static, _, _) => Motion::Bounce { position_m, velocity_mps: [0.0, 0.0] },
            (ClassName::Cyclist, _, Some(classes)) => {
                draw_bounce(random, position_m, classes.cyclist_speed_mps)
            }
            (_, CrowdKind::SocialForce, _) => {
                let [slowest, fastest] = self.desired_speed_mps;
                Motion::SocialForce {
                    position_m,
                    velocity_mps: [0.0, 0.0],
                    goals_m: (0..self.goals_per_person).map(|_| self.draw_point(random)).collect(),
                    goal_radius_m: self.goal_radius_m,
                    desired_speed_mps: random.random_range(slowest..=fastest),
                }
            }
            (_, CrowdKind::Bounce, _) => draw_bounce(random, position_m, self.desired_speed_mps),
        }
    }

    fn draw_point(&self, random: &mut Pcg64) -> [f64; 2] {
        let [x, y] = [self.arena.x_m, self.arena.y_m];
        [random.random_range(x[0]..=x[1]), random.random_range(y[0]..=y[1])]
    }

    /// Who stands for good does not stand on the robot's goal either.
    fn draw_free_place(
        &self,
        random: &mut Pcg64,
        earlier: &[Person],
        class: ClassName,
        radius_m: f64,
    ) -> Option<[f64; 2]> {
        let is_clear = |candidate, of_m| distance_m(candidate, of_m) >= self.clear_of_start_m;
        (0..MAX_DRAWS).map(|_| self.draw_point(random)).find(|&candidate| {
            is_clear(candidate, self.start.position_m)
                && (class != ClassName::Static || is_clear(candidate, self.goal_m))
                && earlier
                    .iter()
                    .all(|person| distance_m(candidate, person.start_m()) >= person.radius_m + radius_m)
        })
    }
}

/// Straight on in any direction, at a speed of the range, m/s.
fn draw_bounce(random: &mut Pcg64, position_m: [f64; 2], [slowest, fastest]: [f64; 2]) -> Motion {
    let speed_mps = random.random_range(slowest..=fastest);
    let (sin, cos) = random.random_range(-PI..PI).sin_cos();
    Motion::Bounce { position_m, velocity_mps: [speed_mps * cos, speed_mps * sin] }
}

fn is_speed_range(range_mps: [f64; 2]) -> Result<(), GenerateError> {
    let [slowest, fastest] = range_mps;
    if slowest > 0.0 && slowest <= fastest && fastest.is_finite() {
        Ok(())
    } else {
        Err(GenerateError::BadSpeedRange(range_mps))
    }
}

fn distance_m(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
