//! Summaries as tables of words, and those as Markdown. Pages take the same tables.

use core::fmt::Write as _;

use super::{ComputeTime, Line, Pair, Radius, Summary};
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
            let lines = summary.lines.iter().filter(|line| line.robot == robot && line.radius == radius);
            tables.push(results(title.clone(), lines));
            let pairs = summary.pairs.iter().filter(|pair| pair.robot == robot && pair.radius == radius);
            tables.push(paired(format!("{title}: on the same scenarios"), pairs));
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
            "causes",
        ],
        lines.map(|line| {
            let percent = |share: f64| format!("{:.1}", share * 100.0);
            let mean =
                |spread: &Option<Spread>| spread.map_or_else(dash, |spread| format!("{:.2}", spread.mean));
            let causes: Vec<_> = line.causes.iter().map(|(name, count)| format!("{name} {count}")).collect();
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
                if causes.is_empty() { dash() } else { causes.join(", ") },
            ]
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
            "p (McNemar)",
            "time ratio, median",
            "95 % interval",
        ],
        pairs.map(|pair| {
            let ratio = pair.time_ratio;
            vec![
                pair.people.to_string(),
                pair.method.clone(),
                pair.reference.clone(),
                pair.scenarios.to_string(),
                pair.only_reference.to_string(),
                pair.only_method.to_string(),
                probability(pair.p),
                ratio.map_or_else(dash, |ratio| format!("{:.3}", ratio.median)),
                ratio.map_or_else(dash, |ratio| {
                    let [low, high] = ratio.median_interval;
                    format!("{low:.3} to {high:.3}")
                }),
            ]
        }),
    )
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
