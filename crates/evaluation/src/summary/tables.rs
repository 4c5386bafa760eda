//! Summaries as tables of words, and those as Markdown. Pages take the same tables.

mod finding;

use core::fmt::Write as _;

use super::{ComputeTime, Line, Pair, Radius, Summary};
use crate::Cause;
use crate::statistics::Spread;

impl Radius {
    /// What it says in a heading.
    const fn heading(self) -> &'static str {
        match self {
            Self::Full => "collision radius equal to the filter's",
            Self::Smaller => "collision radius 5 cm smaller",
        }
    }
}

/// A table in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    /// What it shows.
    pub title: String,
    /// Headings of the columns.
    pub headings: Vec<&'static str>,
    /// Cells, one per heading in each row.
    pub rows: Vec<Vec<String>>,
}

/// The tables of `summary`, each robot and radius by itself. Equal summaries give equal tables.
pub fn tables(summary: &Summary) -> Vec<Table> {
    let mut tables = Vec::new();
    for robot in robots(summary.lines.iter().map(|line| line.robot.as_str())) {
        for radius in Radius::ALL {
            let title = format!("{robot}, {}", radius.heading());
            let lines = || summary.lines.iter().filter(|line| line.robot == robot && line.radius == radius);
            let pairs = || summary.pairs.iter().filter(|pair| pair.robot == robot && pair.radius == radius);
            tables.push(results(title.clone(), lines()));
            tables.push(causes(format!("{title}: contacts by cause"), lines()));
            tables.push(finding::finding(format!("{title}: the paper's finding"), pairs()));
            tables.push(paired(format!("{title}: on the same scenarios"), pairs()));
        }
    }
    tables.retain(|table| !table.rows.is_empty());
    tables
}

/// Computing times, which are measured and therefore not the same on every run.
pub fn time_table(times: &[ComputeTime]) -> Table {
    let median = |spread: &Option<Spread>| spread.map_or_else(dash, |spread| format!("{:.1}", spread.median));
    table(
        "Computing time (measured, not the same on every run)".to_owned(),
        &[
            "robot",
            "people",
            "method",
            "tick median µs",
            "tick p99 µs",
            "nominal median µs",
            "simulated s per s and thread",
        ],
        times.iter().map(|time| {
            vec![
                time.robot.clone(),
                time.people.to_string(),
                time.method.clone(),
                median(&time.tick_median_us),
                median(&time.tick_p99_us),
                median(&time.nominal_median_us),
                time.speed.map_or_else(dash, |speed| format!("{speed:.0}")),
            ]
        }),
    )
}

/// `tables` as Markdown.
pub fn markdown(tables: &[Table]) -> String {
    let mut text = String::new();
    for Table { title, headings, rows } in tables {
        let _ = write!(
            text,
            "## {title}\n\n| {} |\n|{}\n",
            headings.join(" | "),
            " --- |".repeat(headings.len())
        );
        for row in rows {
            let _ = writeln!(text, "| {} |", row.join(" | "));
        }
        text.push('\n');
    }
    text
}

/// Each name once, in the order of the first appearance.
fn robots<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut robots: Vec<&str> = Vec::new();
    for name in names {
        if !robots.contains(&name) {
            robots.push(name);
        }
    }
    robots
}

fn results<'a>(title: String, lines: impl Iterator<Item = &'a Line>) -> Table {
    table(
        title,
        &[
            "people",
            "method",
            "runs",
            "success %",
            "95 % interval",
            "collisions",
            "timeouts",
            "time s",
            "path m",
            "median distance m",
            "intervening %",
            "runs with slack",
            "least margin",
        ],
        lines.map(|line| {
            let percent = |share: f64| format!("{:.1}", share * 100.0);
            let mean =
                |spread: &Option<Spread>| spread.map_or_else(dash, |spread| format!("{:.2}", spread.mean));
            vec![
                line.people.to_string(),
                line.method.clone(),
                line.runs.to_string(),
                percent(line.successes as f64 / line.runs.max(1) as f64),
                format!("{} to {}", percent(line.interval[0]), percent(line.interval[1])),
                line.collisions.to_string(),
                line.timeouts.to_string(),
                mean(&line.time_s),
                mean(&line.path_length_m),
                line.min_distance_m.map_or_else(dash, |spread| format!("{:.3}", spread.median)),
                percent(line.intervention_share),
                line.runs_with_slack.to_string(),
                line.min_hard_margin.map_or_else(dash, |margin| format!("{margin:.2}")),
            ]
        }),
    )
}

/// Contacts of each method by class. Every class has a column, so that nothing seems forgotten.
fn causes<'a>(title: String, lines: impl Iterator<Item = &'a Line>) -> Table {
    let names = Cause::ALL.map(Cause::name);
    let headings = [&["people", "method", "runs", "contacts"][..], &names].concat();
    table(
        title,
        &headings,
        lines.map(|line| {
            let of = |name: &str| {
                line.causes.iter().find(|(cause, _)| cause == name).map_or(0, |(_, count)| *count)
            };
            let first = [
                line.people.to_string(),
                line.method.clone(),
                line.runs.to_string(),
                line.collisions.to_string(),
            ];
            first.into_iter().chain(names.map(|name| of(name).to_string())).collect()
        }),
    )
}

fn paired<'a>(title: String, pairs: impl Iterator<Item = &'a Pair>) -> Table {
    table(
        title,
        &[
            "people",
            "method",
            "against",
            "scenarios",
            "only the latter succeeds",
            "only the former",
            "the latter ahead by, points",
            "95 % interval",
            "p (McNemar)",
            "time ratio, median",
            "95 % interval",
            "path ratio, median",
            "95 % interval",
        ],
        pairs.map(|pair| {
            vec![
                pair.people.to_string(),
                pair.method.clone(),
                pair.reference.clone(),
                pair.scenarios.to_string(),
                pair.only_reference.to_string(),
                pair.only_method.to_string(),
                points(pair.difference),
                interval(pair.difference_interval.map(points)),
                probability(pair.p),
                median(pair.time_ratio),
                median_interval(pair.time_ratio),
                median(pair.path_ratio),
                median_interval(pair.path_ratio),
            ]
        }),
    )
}

fn median(ratio: Option<Spread>) -> String {
    ratio.map_or_else(dash, |ratio| format!("{:.3}", ratio.median))
}

fn median_interval(ratio: Option<Spread>) -> String {
    ratio.map_or_else(dash, |ratio| interval(ratio.median_interval.map(|end| format!("{end:.3}"))))
}

fn interval([low, high]: [String; 2]) -> String {
    format!("{low} to {high}")
}

/// A difference of shares in points, with its sign.
fn points(difference: f64) -> String {
    format!("{:+.1}", 100.0 * difference)
}

fn table(title: String, headings: &[&'static str], rows: impl Iterator<Item = Vec<String>>) -> Table {
    Table { title, headings: headings.to_vec(), rows: rows.collect() }
}

fn probability(p: f64) -> String {
    if p < 0.0001 { "< 0.0001".to_owned() } else { format!("{p:.4}") }
}

fn dash() -> String {
    "–".to_owned()
}
