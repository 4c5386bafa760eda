//! What can be wrong with a scenario, and the checks that say so.

use crate::rectangle::Rectangle;

/// Largest absolute coordinate, m, and time, s. Farther out, f64 still counts in nanometres, but nobody means it.
const MOST_AWAY: f64 = 1e6;
/// Fastest anybody may move, m/s.
const FASTEST_MPS: f64 = 1e3;

/// Why a scenario cannot be run. Fields are named by their path in the scenario, such as `people[3].radius_m`.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ScenarioError {
    /// A number that must be finite is not, or one that must be positive is not.
    #[error("scenario: {field} is {value}; give a finite number{}", if *positive { " greater than zero" } else { "" })]
    BadNumber {
        /// Path of the field.
        field: String,
        /// What stands there.
        value: f64,
        /// Whether it must also be positive.
        positive: bool,
    },
    /// A number is beyond everything that makes sense.
    #[error("scenario: {field} is {value}, beyond ±{most}; check its unit")]
    TooLarge {
        /// Path of the field.
        field: String,
        /// What stands there.
        value: f64,
        /// The largest absolute value taken.
        most: f64,
    },
    /// A list is longer than anything that can be simulated in reasonable time.
    #[error("scenario: {field} has {found} entries; at most {most} are taken")]
    TooMany {
        /// Path of the field.
        field: String,
        /// Its length.
        found: usize,
        /// The most taken.
        most: usize,
    },
    /// The name is empty, too long, or has characters that a file name or a table key cannot have.
    #[error("scenario: name {name:?} is refused; use 1 to 64 letters, digits, `_`, `-` and `.`")]
    BadName {
        /// The name.
        name: String,
    },
    /// The arena is empty or not finite.
    #[error("scenario: arena {0:?} is empty; give finite bounds, the smaller one first")]
    EmptyArena(Rectangle),
    /// Somebody who bounces off the arena's walls starts behind them.
    #[error(
        "scenario: {field} is {position_m:?}, outside the arena {arena:?}; move the person or widen the arena"
    )]
    OutsideArena {
        /// Path of the field.
        field: String,
        /// What stands there, m.
        position_m: [f64; 2],
        /// The arena.
        arena: Rectangle,
    },
    /// A person has nowhere to go.
    #[error("scenario: person {id} has no goals; give at least one in `goals_m`")]
    NoGoals {
        /// Identity of the person.
        id: u64,
    },
    /// A track has not one position for each time, or fewer than two.
    #[error(
        "scenario: {field} has {times} times and {positions} positions; give as many of each, at least two"
    )]
    UnevenTrack {
        /// Path of the track.
        field: String,
        /// Number of times.
        times: usize,
        /// Number of positions.
        positions: usize,
    },
    /// The times of a track do not rise.
    #[error("scenario: {field} is {after_s} after {before_s}; times must rise by at least 0.001 s")]
    FallingTimes {
        /// Path of the later time.
        field: String,
        /// The earlier time, s.
        before_s: f64,
        /// The later one, s.
        after_s: f64,
    },
    /// Two people share an identity, or one has the reserved identity zero.
    #[error("scenario: id {id} is taken twice or zero; give every person an own id from 1 on")]
    BadId {
        /// The identity in question.
        id: u64,
    },
    /// The robot could not be stopped.
    #[error(
        "scenario: robot_limits {min:?} to {max:?} are refused; give finite numbers with zero between them, \
         so that the robot can be stopped"
    )]
    BadLimits {
        /// Lower limits.
        min: [f64; 2],
        /// Upper limits.
        max: [f64; 2],
    },
}

/// Refuses numbers that are not finite or farther away than anything meant.
pub(crate) fn coordinates(field: impl Fn() -> String, values: &[f64]) -> Result<(), ScenarioError> {
    within(field, values, MOST_AWAY)
}

/// Refuses velocities or speeds that are not finite or faster than anything meant.
pub(crate) fn finite_speed(field: impl Fn() -> String, values: &[f64]) -> Result<(), ScenarioError> {
    within(field, values, FASTEST_MPS)
}

fn within(field: impl Fn() -> String, values: &[f64], most: f64) -> Result<(), ScenarioError> {
    for &value in values {
        if !value.is_finite() {
            return Err(ScenarioError::BadNumber { field: field(), value, positive: false });
        }
        if value.abs() > most {
            return Err(ScenarioError::TooLarge { field: field(), value, most });
        }
    }
    Ok(())
}

/// Refuses anything but a finite number greater than zero.
pub(crate) fn positive(field: impl Fn() -> String, value: f64) -> Result<(), ScenarioError> {
    if value.is_finite() && value > 0.0 {
        coordinates(field, &[value])
    } else {
        Err(ScenarioError::BadNumber { field: field(), value, positive: true })
    }
}

/// Refuses lists that are too long.
pub(crate) fn at_most(field: impl Fn() -> String, found: usize, most: usize) -> Result<(), ScenarioError> {
    if found <= most { Ok(()) } else { Err(ScenarioError::TooMany { field: field(), found, most }) }
}
