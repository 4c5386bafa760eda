//! One person or thing of a scenario: identity, body, what it is, and how it moves.
//!
//! Lives here: the data, as it stands in a file, and its validation. What becomes of it in motion is in `walker`.

use serde::{Deserialize, Serialize};
use settings::ClassName;

use crate::rectangle::Rectangle;
use crate::scenario_error::{ScenarioError, at_most, coordinates, finite_speed, positive};

/// Goals that one person may have.
pub(crate) const MOST_GOALS: usize = 1_000;
/// Points that one track may have: an hour and more at 20 Hz.
pub(crate) const MOST_TRACK_POINTS: usize = 100_000;
/// Least distance of two times of a track, s. Closer ones would turn the noise of positions into any speed.
const LEAST_TRACK_INTERVAL_S: f64 = 1e-3;

/// One person, or thing. Everything in `odom`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Person {
    /// Identity, unique in the scenario and greater than zero (zero means anonymous in detections).
    pub id: u64,
    /// Radius of the disc that stands for the body, m.
    pub radius_m: f64,
    /// What perception takes them for; a pedestrian if a file does not say. It decides nothing about the motion.
    #[serde(default = "pedestrian", skip_serializing_if = "is_pedestrian")]
    pub class: ClassName,
    /// Where they begin and how they go on.
    pub motion: Motion,
}

const fn pedestrian() -> ClassName {
    ClassName::Pedestrian
}

/// Serde hands over a reference.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature is serde's")]
const fn is_pedestrian(class: &ClassName) -> bool {
    matches!(class, ClassName::Pedestrian)
}

/// How a person moves. Nobody takes notice of the robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Motion {
    /// By the social force model from goal to goal, over and over again; everybody who is present pushes.
    SocialForce {
        /// Centre at time zero, m.
        position_m: [f64; 2],
        /// Velocity at time zero, m/s; at rest if a file does not say.
        #[serde(default)]
        velocity_mps: [f64; 2],
        /// Goals, walked one after the other and over again, m.
        goals_m: Vec<[f64; 2]>,
        /// Radius of each goal, m.
        goal_radius_m: f64,
        /// Walking speed when nothing is in the way, which is also the highest, m/s.
        desired_speed_mps: f64,
    },
    /// Straight on at constant speed, reflected where the centre meets an edge of the arena; pushed by nobody.
    Bounce {
        /// Centre at time zero, within the arena, m.
        position_m: [f64; 2],
        /// Velocity at time zero, m/s; zero for somebody who stands.
        velocity_mps: [f64; 2],
    },
    /// Along a recorded track, present from its first to its last time only; pushed by nobody.
    Track {
        /// When, s since the start of the run, rising by at least 1 ms. Times below zero lie before the run.
        times_s: Vec<f64>,
        /// Where the centre was at those times, m.
        positions_m: Vec<[f64; 2]>,
    },
}

impl Person {
    /// Centre at time zero, m; of a track its first position, even if that lies in the future.
    pub fn start_m(&self) -> [f64; 2] {
        match &self.motion {
            Motion::SocialForce { position_m, .. } | Motion::Bounce { position_m, .. } => *position_m,
            Motion::Track { positions_m, .. } => positions_m.first().copied().unwrap_or_default(),
        }
    }

    /// Checks everything but the identity; `name` is the person's place in the scenario, such as `people[3]`.
    pub(crate) fn validate(&self, name: &str, arena: &Rectangle) -> Result<(), ScenarioError> {
        positive(|| format!("{name}.radius_m"), self.radius_m)?;
        match &self.motion {
            Motion::SocialForce { position_m, velocity_mps, goals_m, goal_radius_m, desired_speed_mps } => {
                let field = |field: &str| format!("{name}.motion.social_force.{field}");
                if goals_m.is_empty() {
                    return Err(ScenarioError::NoGoals { id: self.id });
                }
                at_most(|| field("goals_m"), goals_m.len(), MOST_GOALS)?;
                coordinates(|| field("position_m"), position_m)?;
                finite_speed(|| field("velocity_mps"), velocity_mps)?;
                coordinates(|| field("goals_m"), goals_m.as_flattened())?;
                positive(|| field("goal_radius_m"), *goal_radius_m)?;
                positive(|| field("desired_speed_mps"), *desired_speed_mps)?;
                finite_speed(|| field("desired_speed_mps"), &[*desired_speed_mps])
            }
            Motion::Bounce { position_m, velocity_mps } => {
                let field = |field: &str| format!("{name}.motion.bounce.{field}");
                coordinates(|| field("position_m"), position_m)?;
                finite_speed(|| field("velocity_mps"), velocity_mps)?;
                if arena.contains(*position_m) {
                    Ok(())
                } else {
                    let field = field("position_m");
                    Err(ScenarioError::OutsideArena { field, position_m: *position_m, arena: *arena })
                }
            }
            Motion::Track { times_s, positions_m } => {
                let field = |field: &str| format!("{name}.motion.track.{field}");
                at_most(|| field("times_s"), times_s.len(), MOST_TRACK_POINTS)?;
                if times_s.len() != positions_m.len() || times_s.len() < 2 {
                    return Err(ScenarioError::UnevenTrack {
                        field: format!("{name}.motion.track"),
                        times: times_s.len(),
                        positions: positions_m.len(),
                    });
                }
                coordinates(|| field("times_s"), times_s)?;
                coordinates(|| field("positions_m"), positions_m.as_flattened())?;
                match times_s.windows(2).position(|pair| pair[1] - pair[0] < LEAST_TRACK_INTERVAL_S) {
                    Some(at) => Err(ScenarioError::FallingTimes {
                        field: field(&format!("times_s[{}]", at + 1)),
                        before_s: times_s[at],
                        after_s: times_s[at + 1],
                    }),
                    None => Ok(()),
                }
            }
        }
    }
}
