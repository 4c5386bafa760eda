//! One method against the reference, scenario by scenario. How it is told in words is in `tables`.

use std::collections::BTreeMap;

use serde::Serialize;

use super::Radius;
use crate::row::Row;
use crate::statistics::{Spread, mcnemar_exact, paired_difference};

/// A method against the reference, on the scenarios that both have run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Pair {
    /// Robot.
    pub robot: String,
    /// Number of people.
    pub people: u32,
    /// How contacts were judged.
    pub radius: Radius,
    /// The reference.
    pub reference: String,
    /// The other method.
    pub method: String,
    /// Scenarios that both have run.
    pub scenarios: u64,
    /// Scenarios in which both succeeded.
    pub both: u64,
    /// Scenarios in which the reference succeeded alone.
    pub only_reference: u64,
    /// Scenarios in which the other one did.
    pub only_method: u64,
    /// Share of the reference's successes less the other's: above zero the reference is ahead.
    pub difference: f64,
    /// Its 95 % interval, Newcombe's for pairs.
    pub difference_interval: [f64; 2],
    /// Two-sided p of McNemar's exact test.
    pub p: f64,
    /// Time of the other method over the reference's, where both succeeded.
    pub time_ratio: Option<Spread>,
    /// The same of the way driven.
    pub path_ratio: Option<Spread>,
}

/// `other` against `reference`, by `radius`. Neither is empty, and each has one robot, crowd size and method.
pub(super) fn pair(reference: &[&Row], other: &[&Row], radius: Radius) -> Pair {
    let by_scenario: BTreeMap<&str, &Row> =
        reference.iter().map(|row| (row.scenario.as_str(), *row)).collect();
    let runs: Vec<(&Row, &Row)> = other
        .iter()
        .filter_map(|row| Some((*by_scenario.get(row.scenario.as_str())?, *row)))
        // A scenario of the same name from another file is another scenario.
        .filter(|(one, row)| one.scenario_hash == row.scenario_hash)
        .collect();
    let count = |first: bool, second: bool| {
        runs.iter().filter(|(one, row)| (radius.success(one), radius.success(row)) == (first, second)).count()
            as u64
    };
    let (both, only_reference, only_method) = (count(true, true), count(true, false), count(false, true));
    let (difference, difference_interval) =
        paired_difference(both, only_reference, only_method, count(false, false));
    let ratio = |value: fn(&Row) -> f64| {
        let ratios: Vec<f64> = runs
            .iter()
            .filter(|(one, row)| radius.success(one) && radius.success(row) && value(one) > 0.0)
            .map(|(one, row)| value(row) / value(one))
            .collect();
        Spread::of(&ratios)
    };
    Pair {
        robot: other[0].robot.clone(),
        people: other[0].people,
        radius,
        reference: reference[0].method.clone(),
        method: other[0].method.clone(),
        scenarios: runs.len() as u64,
        both,
        only_reference,
        only_method,
        difference,
        difference_interval,
        p: mcnemar_exact(only_reference, only_method),
        time_ratio: ratio(|row| row.time_s),
        path_ratio: ratio(|row| row.path_length_m),
    }
}
