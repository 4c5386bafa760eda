//! What `cncbf evaluate` shows of a table: one line per method on the terminal, and a folder of tables and figures.

use core::fmt::Write as _;
use std::path::Path;

use anyhow::Context;
use evaluation::Row;
use evaluation::statistics::Spread;
use evaluation::summary::{
    Line, Radius, Summary, Table, compute_times, markdown, summarise, tables, time_table,
};
use report::{DensityFigure, DensitySeries, EvaluationPage, EvaluationTable, density_svg, evaluation_html};

use super::pooled::pooled;

/// Names of the methods as they were ordered on the command line, without the files of one's own.
fn order(methods: &[String]) -> Vec<String> {
    methods.iter().map(|name| name.split('=').next().unwrap_or_default().to_owned()).collect()
}

/// What is said of the lines over a whole file of scenarios.
const POOLED: &str = "All scenarios of the file; the column of people has their mean";

/// One line per robot, crowd size and method, and for scenarios of a file the same over all crowd sizes.
pub(super) fn overview(rows: &[Row], methods: &[String]) -> String {
    let mut text = lines(rows, methods);
    if let Some(rows) = pooled(rows) {
        let _ = write!(text, "\n{POOLED}:\n{}", lines(&rows, methods));
    }
    text
}

fn lines(rows: &[Row], methods: &[String]) -> String {
    let summary = summarise(rows, &order(methods));
    let longest = summary.lines.iter().map(|line| line.method.chars().count()).max().unwrap_or(0);
    let width = longest.max("method".len());
    let mut text = format!(
        "{:<10} {:>6}  {:<width$} {:>5}  {:>9} {:>15}  {:>9}  {:>7} {:>7}\n",
        "robot", "people", "method", "runs", "success %", "95 % interval", "5 cm less", "time s", "path m"
    );
    for pair in summary.lines.chunks_exact(2) {
        let [full, smaller] = pair else { continue };
        let percent = |line: &Line| 100.0 * line.successes as f64 / line.runs.max(1) as f64;
        let mean =
            |spread: &Option<Spread>| spread.map_or_else(|| "–".to_owned(), |of| format!("{:.2}", of.mean));
        let interval = format!("{:.1} to {:.1}", 100.0 * full.interval[0], 100.0 * full.interval[1]);
        let _ = writeln!(
            text,
            "{:<10} {:>6}  {:<width$} {:>5}  {:>9.1} {interval:>15}  {:>9.1}  {:>7} {:>7}",
            full.robot,
            full.people,
            full.method,
            full.runs,
            percent(full),
            percent(smaller),
            mean(&full.time_s),
            mean(&full.path_length_m)
        );
    }
    text
}

/// Writes `tables.md`, `summary.json`, the figures and `evaluation.html` into `folder`.
pub(super) fn write(rows: &[Row], methods: &[String], folder: &Path, command: &str) -> anyhow::Result<()> {
    let put = |name: &str, text: &str| {
        std::fs::write(folder.join(name), text)
            .with_context(|| format!("cannot write {name} into {}", folder.display()))
    };
    let summary = summarise(rows, &order(methods));
    let of_runs = tables(&summary);
    let of_file: Vec<Table> = pooled(rows)
        .iter()
        .flat_map(|rows| tables(&summarise(rows, &order(methods))))
        .map(|table| Table { title: format!("{POOLED}: {}", table.title), ..table })
        .collect();
    let of_runs: Vec<Table> = of_file.into_iter().chain(of_runs).collect();
    put("tables.md", &markdown(&of_runs))?;
    put("summary.json", &(serde_json::to_string_pretty(&summary)? + "\n"))?;
    let figures = figures(&summary);
    for (name, figure) in &figures {
        put(name, &density_svg(figure)?)?;
    }
    let times = time_table(&compute_times(rows));
    put("times.md", &markdown(std::slice::from_ref(&times)))?;
    let shown: Vec<EvaluationTable> = of_runs.into_iter().chain([times]).map(page_table).collect();
    let figures: Vec<DensityFigure> = figures.into_iter().map(|(_, figure)| figure).collect();
    let page = EvaluationPage {
        title: command,
        subtitle: &format!("{} runs, cncbf {}", rows.len(), env!("CARGO_PKG_VERSION")),
        figures: &figures,
        tables: &shown,
    };
    put("evaluation.html", &evaluation_html(&page)?)
}

fn page_table(table: Table) -> EvaluationTable {
    EvaluationTable {
        title: table.title,
        headings: table.headings.into_iter().map(str::to_owned).collect(),
        rows: table.rows,
    }
}

/// The paper's three figures for each robot, the first for both radii.
fn figures(summary: &Summary) -> Vec<(String, DensityFigure)> {
    let mut robots: Vec<&str> = summary.lines.iter().map(|line| line.robot.as_str()).collect();
    robots.dedup();
    let percent = |line: &Line| {
        let share = line.successes as f64 / line.runs.max(1) as f64;
        Some((100.0 * share, line.interval.map(|bound| 100.0 * bound)))
    };
    let spread = |of: Option<Spread>| of.map(|spread| (spread.median, spread.median_interval));
    robots
        .into_iter()
        .flat_map(|robot| {
            let draw = |name: &str, what: &str, radius, range, value: &dyn Fn(&Line) -> _| {
                let figure = figure(summary, robot, radius, format!("{robot}: {what}"), range, value);
                (format!("{robot}_{name}.svg"), figure)
            };
            let whole = Some([0.0, 100.0]);
            [
                draw("success", "success, %", Radius::Full, whole, &percent),
                draw(
                    "success_5cm",
                    "success, %, collision radius 5 cm smaller",
                    Radius::Smaller,
                    whole,
                    &percent,
                ),
                draw("path_length", "path length, median of successes, m", Radius::Full, None, &|line| {
                    spread(line.path_length_m)
                }),
                draw("time", "time to goal, median of successes, s", Radius::Full, None, &|line| {
                    spread(line.time_s)
                }),
            ]
        })
        .collect()
}

fn figure(
    summary: &Summary,
    robot: &str,
    radius: Radius,
    title: String,
    range: Option<[f64; 2]>,
    value: &dyn Fn(&Line) -> Option<report::Bounded>,
) -> DensityFigure {
    let lines: Vec<&Line> =
        summary.lines.iter().filter(|line| line.robot == robot && line.radius == radius).collect();
    let mut people: Vec<u32> = lines.iter().map(|line| line.people).collect();
    people.dedup();
    let mut methods: Vec<&str> = Vec::new();
    for line in &lines {
        if !methods.contains(&line.method.as_str()) {
            methods.push(&line.method);
        }
    }
    let series = methods
        .into_iter()
        .map(|method| DensitySeries {
            name: method.to_owned(),
            values: people
                .iter()
                .map(|&people| {
                    lines
                        .iter()
                        .find(|line| line.method == method && line.people == people)
                        .and_then(|line| value(line))
                })
                .collect(),
        })
        .collect();
    DensityFigure { title, people, series, range }
}
