//! Computing times: the only figures that differ from run to run, and therefore kept apart.

use std::collections::BTreeMap;

use crate::row::Row;
use crate::statistics::Spread;

/// Computing times of one method at one crowd size.
#[derive(Debug, Clone, PartialEq)]
pub struct ComputeTime {
    /// Robot.
    pub robot: String,
    /// Number of people.
    pub people: u32,
    /// Method.
    pub method: String,
    /// Medians of what answers at the filter's ticks, µs.
    pub tick_median_us: Option<Spread>,
    /// Its 99th percentiles, µs.
    pub tick_p99_us: Option<Spread>,
    /// Medians of the nominal controller, µs.
    pub nominal_median_us: Option<Spread>,
    /// Simulated seconds per second of one thread.
    pub speed: Option<f64>,
}

/// Computing times by robot, people and method.
pub fn compute_times(rows: &[Row]) -> Vec<ComputeTime> {
    let mut groups: BTreeMap<(&str, u32, &str), Vec<&Row>> = BTreeMap::new();
    for row in rows {
        groups.entry((row.robot.as_str(), row.people, row.method.as_str())).or_default().push(row);
    }
    let spread = |group: &[&Row], value: fn(&Row) -> Option<f64>| {
        Spread::of(&group.iter().filter_map(|row| value(row)).collect::<Vec<_>>())
    };
    groups
        .into_iter()
        .map(|((robot, people, method), group)| {
            let timed: Vec<(f64, f64)> =
                group.iter().filter_map(|row| Some((row.time_s, row.cpu_s?))).collect();
            let cpu_s: f64 = timed.iter().map(|(_, cpu_s)| cpu_s).sum();
            ComputeTime {
                robot: robot.to_owned(),
                people,
                method: method.to_owned(),
                tick_median_us: spread(&group, |row| row.tick_median_us),
                tick_p99_us: spread(&group, |row| row.tick_p99_us),
                nominal_median_us: spread(&group, |row| row.nominal_median_us),
                speed: (cpu_s > 0.0).then(|| timed.iter().map(|(time_s, _)| time_s).sum::<f64>() / cpu_s),
            }
        })
        .collect()
}
