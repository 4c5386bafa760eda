//! The grid search behind the tuned rows: runs every setting of a method's grid among people of seeds that no table uses
//! and prints a line for each, CSV, the winner marked.
//!
//! `cargo run --release -p evaluation --example tune -- ROBOT [METHOD [FIRST ALL]]`
//!
//! What is tried is in `grids.rs`, how it is judged in `criterion.rs`: the same number of settings, the same runs and the
//! same criterion for every method. Each setting is run in the first FIRST scenarios; the four best of them, and the
//! published one, in ALL, and the best of those wins. Seeds begin at 1001, the tables' end at 100. Nothing printed depends
//! on the machine or on how busy it is. `crates/evaluation/tuning/` keeps what was printed, and a test holds
//! `MethodParameters::tuned` and the settings of `cn_cbf_tuned` against it.

mod criterion;
mod grids;

use evaluation::statistics::Spread;
use evaluation::{Robot, Row, Scenario, Variant, run, short_hash};

use criterion::{Candidate, HEADER, ranking};
use grids::{Grid, grids, people};

/// The first seed of the search.
const FIRST_SEED: u64 = 1001;
/// So many go on from the first scenarios to all.
const FINALISTS: usize = 4;

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let usage = "usage: tune ground|quadrotor [METHOD [FIRST ALL]]";
    let robot =
        Robot::ALL.into_iter().find(|known| arguments.first().is_some_and(|name| name == known.name()));
    let robot = robot.ok_or(usage)?;
    let (first, all) = match &arguments[1..] {
        [] | [_] => (12, 36),
        [_, first, all] => (first.parse()?, all.parse()?),
        [..] => return Err(usage.into()),
    };
    let chosen: Vec<&Grid> = grids(robot)
        .iter()
        .filter(|grid| arguments.get(1).is_none_or(|method| method == grid.method))
        .collect();
    if chosen.is_empty() {
        return Err("this robot has no such method, or it has nothing to tune".into());
    }
    let search = Search::new(robot, all)?;
    println!("# cargo run --release -p evaluation --example tune -- {}", arguments.join(" "));
    println!("{HEADER}");
    for grid in chosen {
        for line in search.through(grid, first)? {
            println!("{line}");
        }
    }
    Ok(())
}

/// The scenarios, and CN-CBF as published in each of them.
struct Search {
    robot: Robot,
    scenarios: Vec<Scenario>,
    reference: Vec<Row>,
}

impl Search {
    fn new(robot: Robot, all: usize) -> Result<Self, Failure> {
        let scenarios = Scenario::random_set(FIRST_SEED, all as u64, &[people(robot)]);
        let reference = rows(&Variant::named(robot, "cn_cbf", &[])?, &scenarios)?;
        Ok(Self { robot, scenarios, reference })
    }

    /// The lines of a method's settings.
    fn through(&self, grid: &Grid, first: usize) -> Result<Vec<String>, Failure> {
        let (early, late) = self.scenarios.split_at(first.min(self.scenarios.len()));
        let variants: Result<Vec<Variant>, _> =
            grid.settings().iter().map(|sets| Variant::named(self.robot, grid.method, sets)).collect();
        let variants = variants?;
        let mut tried: Vec<Vec<Row>> = Vec::new();
        for (variant, sets) in variants.iter().zip(grid.settings()) {
            tried.push(rows(variant, early)?);
            eprintln!("{} {}", grid.method, sets.join(" "));
        }
        let candidates = |tried: &[Vec<Row>]| -> Vec<Candidate> {
            grid.settings().into_iter().zip(tried).map(|(sets, rows)| self.candidate(sets, rows)).collect()
        };
        let mut finalists = ranking(&candidates(&tried));
        finalists.truncate(FINALISTS);
        if !finalists.contains(&0) {
            finalists.push(0);
        }
        for at in finalists {
            tried[at].extend(rows(&variants[at], late)?);
        }
        let judged = candidates(&tried);
        let winner = ranking(&judged).first().copied();
        let line = |(at, candidate): (usize, &Candidate)| {
            let (robot, people) = (self.robot.name(), people(self.robot));
            candidate.line(robot, grid.method, people, FIRST_SEED, Some(at) == winner)
        };
        Ok(judged.iter().enumerate().map(line).collect())
    }

    fn candidate(&self, sets: Vec<String>, rows: &[Row]) -> Candidate {
        let times: Vec<f64> = rows.iter().filter(|row| row.success).map(|row| row.time_s).collect();
        let ratios: Vec<f64> = rows
            .iter()
            .zip(&self.reference)
            .filter(|(row, reference)| row.success && reference.success)
            .map(|(row, reference)| row.time_s / reference.time_s)
            .collect();
        let median = |values: &[f64]| Spread::of(values).map(|spread| spread.median);
        Candidate {
            sets,
            runs: rows.len(),
            successes: times.len(),
            successes_smaller: rows.iter().filter(|row| row.success_smaller).count(),
            time_s: median(&times),
            time_ratio: median(&ratios),
        }
    }
}

/// `variant` in each of `scenarios`.
fn rows(variant: &Variant, scenarios: &[Scenario]) -> Result<Vec<Row>, Failure> {
    let build = short_hash(b"example");
    let mut rows = Vec::with_capacity(scenarios.len());
    for scenario in scenarios {
        rows.extend(run(scenario, variant, &build, &|| false)?);
    }
    Ok(rows)
}
