//! What rows add up to: one line per method and crowd size, and each method against a reference on the same scenarios.
//!
//! Nothing here looks at a column that a clock measured, so equal runs give equal summaries, byte for byte. Computing times
//! are in `times`.

mod pairs;
mod tables;
mod times;

use std::collections::BTreeMap;

use serde::Serialize;

use crate::Cause;
use crate::row::Row;
use crate::statistics::{Spread, wilson};

pub use pairs::Pair;
pub use tables::{Table, markdown, tables, time_table};
pub use times::{ComputeTime, compute_times};

/// The method that others are compared with where it is in the table.
pub const REFERENCE: &str = "cn_cbf";

/// The two ways to judge a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Radius {
    /// Contact at the sum of both radii, the filter's own.
    Full,
    /// Contact 5 cm further in.
    Smaller,
}

impl Radius {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Full, Self::Smaller];

    /// Whether the run succeeded by this radius.
    pub const fn success(self, row: &Row) -> bool {
        match self {
            Self::Full => row.success,
            Self::Smaller => row.success_smaller,
        }
    }

    const fn cause(self, row: &Row) -> &String {
        match self {
            Self::Full => &row.cause,
            Self::Smaller => &row.cause_smaller,
        }
    }
}

/// One method at one crowd size, by one radius.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Line {
    /// Robot.
    pub robot: String,
    /// Number of people.
    pub people: u32,
    /// Method.
    pub method: String,
    /// How contacts were judged.
    pub radius: Radius,
    /// Runs.
    pub runs: u64,
    /// Runs that reached the goal without contact.
    pub successes: u64,
    /// Wilson's 95 % interval of their share.
    pub interval: [f64; 2],
    /// Runs with contact.
    pub collisions: u64,
    /// Runs that did neither: time ran out.
    pub timeouts: u64,
    /// Contacts by cause, in the order of [`Cause::ALL`].
    pub causes: Vec<(String, u64)>,
    /// Time to the goal of the successes, s.
    pub time_s: Option<Spread>,
    /// Way to the goal of the successes, m.
    pub path_length_m: Option<Spread>,
    /// Smallest distance of discs in each run, m.
    pub min_distance_m: Option<Spread>,
    /// Mean share of cycles that intervened.
    pub intervention_share: f64,
    /// Runs that needed slack at least once.
    pub runs_with_slack: u64,
    /// Smallest hard-feasibility margin of all runs.
    pub min_hard_margin: Option<f64>,
    /// Mean share of people's walking time beyond 0.35 rad/s.
    pub turn_rate_exceeded_share: f64,
    /// Mean share of people's walking time beyond 1 m/s² on an axis.
    pub acceleration_exceeded_share: f64,
}

/// Everything that a table says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Lines by robot, people, method and radius; methods stand in the order of their first names.
    pub lines: Vec<Line>,
    /// Pairs in the same order.
    pub pairs: Vec<Pair>,
}

/// Sums up `rows`. Methods appear in the order of `methods`, then by name.
pub fn summarise(rows: &[Row], methods: &[String]) -> Summary {
    let rank = |method: &str| methods.iter().position(|known| known == method).unwrap_or(methods.len());
    let mut groups: BTreeMap<(&str, u32, usize, &str), Vec<&Row>> = BTreeMap::new();
    for row in rows {
        let group = (row.robot.as_str(), row.people, rank(&row.method), row.method.as_str());
        groups.entry(group).or_default().push(row);
    }
    let mut summary = Summary { lines: Vec::new(), pairs: Vec::new() };
    for (&(robot, people, _, _), group) in &groups {
        for radius in Radius::ALL {
            summary.lines.push(line(group, radius));
            let reference = (robot, people, rank(REFERENCE), REFERENCE);
            if let Some(reference) =
                groups.get(&reference).filter(|reference| reference[0].method != group[0].method)
            {
                summary.pairs.push(pairs::pair(reference, group, radius));
            }
        }
    }
    summary
}

fn line(group: &[&Row], radius: Radius) -> Line {
    let first = group[0];
    let runs = group.len() as u64;
    let succeeded: Vec<&&Row> = group.iter().filter(|row| radius.success(row)).collect();
    let successes = succeeded.len() as u64;
    let spread =
        |value: fn(&Row) -> f64| Spread::of(&succeeded.iter().map(|row| value(row)).collect::<Vec<_>>());
    let mean = |value: fn(&Row) -> f64| group.iter().map(|row| value(row)).sum::<f64>() / runs as f64;
    let count = |holds: &dyn Fn(&Row) -> bool| group.iter().filter(|row| holds(row)).count() as u64;
    let causes: Vec<_> = Cause::ALL
        .iter()
        .map(|cause| (cause.name().to_owned(), count(&|row| radius.cause(row) == cause.name())))
        .filter(|(_, count)| *count > 0)
        .collect();
    let collisions = count(&|row| match radius {
        Radius::Full => row.collision,
        Radius::Smaller => row.collision_smaller,
    });
    let distances: Vec<f64> = group.iter().filter_map(|row| row.min_distance_m).collect();
    Line {
        robot: first.robot.clone(),
        people: first.people,
        method: first.method.clone(),
        radius,
        runs,
        successes,
        interval: wilson(successes, runs),
        collisions,
        timeouts: runs - successes - collisions,
        causes,
        time_s: spread(|row| row.time_s),
        path_length_m: spread(|row| row.path_length_m),
        min_distance_m: Spread::of(&distances),
        intervention_share: mean(|row| row.intervention_share),
        runs_with_slack: count(&|row| row.slack_cycles > 0),
        min_hard_margin: group.iter().filter_map(|row| row.min_hard_margin).min_by(f64::total_cmp),
        turn_rate_exceeded_share: mean(|row| row.turn_rate_exceeded_share),
        acceleration_exceeded_share: mean(|row| row.acceleration_exceeded_share),
    }
}
