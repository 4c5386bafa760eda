//! What a run starts from: the robot's start and goal, the arena, and the people.
//!
//! Lives here: the data, as it stands in a file, and its validation. Drawing scenarios at random is in `generate`, files of
//! them in `scenario_file`.

use dynamics::InputBox;
use serde::{Deserialize, Serialize};

use crate::person::Person;
use crate::rectangle::Rectangle;
use crate::scenario_error::{ScenarioError, at_most, coordinates, positive};

/// People that one scenario may have; the social force model looks at every pair of them a hundred times a second.
pub(crate) const MOST_PEOPLE: usize = 1_000;
/// Longest name of a scenario, bytes.
const LONGEST_NAME: usize = 64;

/// Where the robot stands at time zero, at rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotStart {
    /// Centre in `odom`, m.
    pub position_m: [f64; 2],
    /// Heading in `odom`, rad; ignored by a plant without heading.
    pub heading_rad: f64,
}

/// What the robot's actuators can do, whatever they are told.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotLimits {
    /// Lowest input: `[m/s, rad/s]` for a unicycle, `[m/s², m/s²]` for a double integrator. At most zero.
    pub input_min: [f64; 2],
    /// Highest input, same units. At least zero.
    pub input_max: [f64; 2],
    /// Highest speed along each axis, m/s. Double integrator only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis_speed_mps: Option<f64>,
}

/// A complete starting situation. Everything in `odom`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Name, by which tables and the command line call it: 1 to 64 letters, digits, `_`, `-` and `.`.
    pub name: String,
    /// Seed of everything that is drawn while the scenario runs (sensor noise), and that the people were drawn with if they
    /// were drawn; zero if a file does not say.
    #[serde(default)]
    pub seed: u64,
    /// Start of the robot.
    pub start: RobotStart,
    /// Where the robot has to go, m.
    pub goal_m: [f64; 2],
    /// Heading that the nominal controller shall arrive with, rad. A goal counts as reached with any.
    #[serde(default)]
    pub goal_heading_rad: f64,
    /// Distance from the goal at which it counts as reached, m.
    pub goal_tolerance_m: f64,
    /// Time after which a run has failed, s.
    pub time_limit_s: f64,
    /// Radius of the disc that stands for the robot, m. It decides what a contact is, not what the filter assumes.
    pub robot_radius_m: f64,
    /// What the robot's actuators can do; as the settings say if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot_limits: Option<RobotLimits>,
    /// Where people walk. The robot may leave it.
    pub arena: Rectangle,
    /// The pedestrians.
    pub people: Vec<Person>,
}

impl RobotLimits {
    /// The same as bounds on a plant's inputs.
    pub fn inputs(&self) -> InputBox<2> {
        InputBox { min: self.input_min, max: self.input_max }
    }

    fn validate(&self) -> Result<(), ScenarioError> {
        let (min, max) = (self.input_min, self.input_max);
        if !(0..2).all(|k| min[k].is_finite() && max[k].is_finite() && min[k] <= 0.0 && max[k] >= 0.0) {
            return Err(ScenarioError::BadLimits { min, max });
        }
        self.axis_speed_mps
            .map_or(Ok(()), |speed_mps| positive(|| "robot_limits.axis_speed_mps".to_owned(), speed_mps))
    }
}

impl Scenario {
    /// Checks that the scenario can be run.
    ///
    /// # Errors
    /// The first defect found, see [`ScenarioError`].
    pub fn validate(&self) -> Result<(), ScenarioError> {
        let own = |field: &'static str| move || field.to_owned();
        if !is_name(&self.name) {
            return Err(ScenarioError::BadName { name: self.name.chars().take(LONGEST_NAME + 1).collect() });
        }
        if !self.arena.is_valid() {
            return Err(ScenarioError::EmptyArena(self.arena));
        }
        coordinates(own("arena"), [self.arena.x_m, self.arena.y_m].as_flattened())?;
        coordinates(own("start.position_m"), &self.start.position_m)?;
        coordinates(own("start.heading_rad"), &[self.start.heading_rad])?;
        coordinates(own("goal_m"), &self.goal_m)?;
        coordinates(own("goal_heading_rad"), &[self.goal_heading_rad])?;
        positive(own("goal_tolerance_m"), self.goal_tolerance_m)?;
        positive(own("time_limit_s"), self.time_limit_s)?;
        positive(own("robot_radius_m"), self.robot_radius_m)?;
        self.robot_limits.as_ref().map_or(Ok(()), RobotLimits::validate)?;
        at_most(own("people"), self.people.len(), MOST_PEOPLE)?;
        for (index, person) in self.people.iter().enumerate() {
            if person.id == 0 || self.people[..index].iter().any(|earlier| earlier.id == person.id) {
                return Err(ScenarioError::BadId { id: person.id });
            }
            person.validate(&format!("people[{index}]"), &self.arena)?;
        }
        Ok(())
    }
}

/// Whether `name` can be a key of a table, a part of a file name, and what follows a `:` on the command line.
fn is_name(name: &str) -> bool {
    (1..=LONGEST_NAME).contains(&name.len())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.'))
}
