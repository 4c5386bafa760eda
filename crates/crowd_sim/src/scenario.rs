//! What a run starts from: the robot's start and goal, the arena, and the people with their goals.
//!
//! Lives here: the data, as it stands in a file, and its validation. Drawing scenarios at random is in `generate`.

use serde::{Deserialize, Serialize};

/// An axis-aligned rectangle in `odom`, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rectangle {
    /// Smallest and largest x, m.
    pub x_m: [f64; 2],
    /// Smallest and largest y, m.
    pub y_m: [f64; 2],
}

impl Rectangle {
    /// Whether `point_m` lies inside or on the edge.
    pub fn contains(&self, point_m: [f64; 2]) -> bool {
        (self.x_m[0]..=self.x_m[1]).contains(&point_m[0]) && (self.y_m[0]..=self.y_m[1]).contains(&point_m[1])
    }

    pub(crate) fn is_valid(&self) -> bool {
        [self.x_m, self.y_m].iter().all(|[low, high]| low.is_finite() && high.is_finite() && low < high)
    }
}

/// Where the robot stands at time zero, at rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotStart {
    /// Centre in `odom`, m.
    pub position_m: [f64; 2],
    /// Heading in `odom`, rad; ignored by a plant without heading.
    pub heading_rad: f64,
}

/// One pedestrian, at rest at time zero.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Person {
    /// Identity, unique in the scenario and greater than zero (zero means anonymous in detections).
    pub id: u64,
    /// Centre at time zero in `odom`, m.
    pub position_m: [f64; 2],
    /// Goals in `odom`, m, walked one after the other and over again.
    pub goals_m: Vec<[f64; 2]>,
    /// Radius of each goal, m.
    pub goal_radius_m: f64,
    /// Walking speed when nothing is in the way, which is also the highest, m/s.
    pub desired_speed_mps: f64,
    /// Radius of the disc that stands for the body, m.
    pub radius_m: f64,
}

/// A complete starting situation. Everything in `odom`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Seed that the people were drawn with; carried along so that a report can name it.
    pub seed: u64,
    /// Start of the robot.
    pub start: RobotStart,
    /// Where the robot has to go, m.
    pub goal_m: [f64; 2],
    /// Distance from the goal at which it counts as reached, m.
    pub goal_tolerance_m: f64,
    /// Radius of the disc that stands for the robot, m.
    pub robot_radius_m: f64,
    /// Where people walk. The robot may leave it.
    pub arena: Rectangle,
    /// The pedestrians.
    pub people: Vec<Person>,
}

/// Why a scenario cannot be run.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ScenarioError {
    /// A number that must be finite is not, or one that must be positive is not.
    #[error("scenario: {field} is {value}; give a finite number{}", if *positive { " greater than zero" } else { "" })]
    BadNumber {
        /// Path of the field, such as `people[3].radius_m`.
        field: String,
        /// What stands there.
        value: f64,
        /// Whether it must also be positive.
        positive: bool,
    },
    /// The arena is empty or not finite.
    #[error("scenario: arena {0:?} is empty; give finite bounds, the smaller one first")]
    EmptyArena(Rectangle),
    /// A person has nowhere to go.
    #[error("scenario: person {id} has no goals; give at least one")]
    NoGoals {
        /// Identity of the person.
        id: u64,
    },
    /// Two people share an identity, or one has the reserved identity zero.
    #[error("scenario: id {id} is taken twice or zero; give every person an own id from 1 on")]
    BadId {
        /// The identity in question.
        id: u64,
    },
}

impl Scenario {
    /// Checks that the scenario can be run.
    ///
    /// # Errors
    /// The first defect found, see [`ScenarioError`].
    pub fn validate(&self) -> Result<(), ScenarioError> {
        if !self.arena.is_valid() {
            return Err(ScenarioError::EmptyArena(self.arena));
        }
        finite("start.position_m", &self.start.position_m)?;
        finite("start.heading_rad", &[self.start.heading_rad])?;
        finite("goal_m", &self.goal_m)?;
        positive("goal_tolerance_m", self.goal_tolerance_m)?;
        positive("robot_radius_m", self.robot_radius_m)?;
        for (index, person) in self.people.iter().enumerate() {
            let name = |field: &str| format!("people[{index}].{field}");
            if person.id == 0 || self.people[..index].iter().any(|earlier| earlier.id == person.id) {
                return Err(ScenarioError::BadId { id: person.id });
            }
            if person.goals_m.is_empty() {
                return Err(ScenarioError::NoGoals { id: person.id });
            }
            finite(&name("position_m"), &person.position_m)?;
            finite(&name("goals_m"), person.goals_m.as_flattened())?;
            positive(&name("goal_radius_m"), person.goal_radius_m)?;
            positive(&name("desired_speed_mps"), person.desired_speed_mps)?;
            positive(&name("radius_m"), person.radius_m)?;
        }
        Ok(())
    }
}

fn finite(field: &str, values: &[f64]) -> Result<(), ScenarioError> {
    match values.iter().find(|value| !value.is_finite()) {
        Some(&value) => Err(ScenarioError::BadNumber { field: field.to_owned(), value, positive: false }),
        None => Ok(()),
    }
}

fn positive(field: &str, value: f64) -> Result<(), ScenarioError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(ScenarioError::BadNumber { field: field.to_owned(), value, positive: true })
    }
}
