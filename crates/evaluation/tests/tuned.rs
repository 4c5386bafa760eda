//! The tuned rows against the stored tables of the grid search: what is tried, what won, and what the methods are.
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

#[path = "../examples/tune/criterion.rs"]
mod criterion;
#[path = "../examples/tune/grids.rs"]
mod grids;

use std::path::Path;

use baselines::{MethodKind, MethodParameters};
use criterion::{Candidate, HEADER, ranking};
use evaluation::{Robot, Variant};
use grids::{Grid, grids, people};

/// The lines of `method` in the stored table of `robot`, without the two that head it.
fn stored(robot: Robot, method: &str) -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tuning");
    let text = std::fs::read_to_string(folder.join(format!("{}_{method}.csv", robot.name()))).unwrap();
    let mut lines = text.lines();
    let command = format!("# cargo run --release -p evaluation --example tune -- {} {method}", robot.name());
    assert!(lines.next().unwrap().starts_with(&command), "{method}: {text}");
    assert_eq!(lines.next().unwrap(), HEADER);
    lines.map(str::to_owned).collect()
}

fn candidate(line: &str) -> Candidate {
    let columns: Vec<&str> = line.split(',').collect();
    assert_eq!(columns.len(), HEADER.split(',').count(), "{line}");
    Candidate {
        sets: columns[4].split(' ').map(str::to_owned).collect(),
        runs: columns[5].parse().unwrap(),
        successes: columns[6].parse().unwrap(),
        successes_smaller: columns[7].parse().unwrap(),
        time_s: columns[8].parse().ok(),
        time_ratio: columns[9].parse().ok(),
    }
}

fn every_grid() -> impl Iterator<Item = (Robot, &'static Grid)> {
    Robot::ALL.into_iter().flat_map(|robot| grids(robot).iter().map(move |grid| (robot, grid)))
}

/// The grids of methods that have a tuned row.
fn searched() -> impl Iterator<Item = (Robot, &'static Grid)> {
    every_grid()
        .filter(|(robot, grid)| Variant::names(*robot).contains(&format!("{}_tuned", grid.method).as_str()))
}

fn hash(robot: Robot, name: &str, sets: &[String]) -> String {
    Variant::named(robot, name, sets).unwrap().settings_hash().to_owned()
}

#[test]
fn the_tuned_methods_are_the_winners_of_the_stored_search() {
    for (robot, grid) in searched() {
        let lines = stored(robot, grid.method);
        let candidates: Vec<Candidate> = lines.iter().map(|line| candidate(line)).collect();
        let winner = ranking(&candidates)[0];
        for (at, (line, candidate)) in lines.iter().zip(&candidates).enumerate() {
            // The line says everything, the mark of the winner included.
            assert_eq!(*line, candidate.line(robot.name(), grid.method, people(robot), 1001, at == winner));
        }
        let tuned = hash(robot, &format!("{}_tuned", grid.method), &[]);
        let sets = &candidates[winner].sets;
        assert_eq!(tuned, hash(robot, grid.method, sets), "{}: {sets:?}", grid.method);
    }
}

#[test]
fn every_method_was_given_the_same_search() {
    let runs = |robot, grid: &Grid| -> Vec<usize> {
        let mut runs: Vec<usize> =
            stored(robot, grid.method).iter().map(|line| candidate(line).runs).collect();
        runs.sort_unstable();
        // Whether the published setting is among the finalists or joins them makes one setting's difference.
        runs.dedup();
        runs
    };
    for (robot, grid) in every_grid() {
        let settings = grid.settings().len();
        assert_eq!(settings, grids(robot)[0].settings().len(), "{}", grid.method);
    }
    for (robot, grid) in searched() {
        let settings = grid.settings();
        let stored_sets: Vec<Vec<String>> =
            stored(robot, grid.method).iter().map(|line| candidate(line).sets).collect();
        assert_eq!(stored_sets, settings, "{}", grid.method);
        assert_eq!(runs(robot, grid), runs(robot, &grids(robot)[0]), "{}", grid.method);
    }
}

#[test]
fn the_published_settings_begin_each_grid() {
    for (robot, grid) in every_grid() {
        let published = hash(robot, grid.method, &[]);
        let settings = grid.settings();
        assert_eq!(hash(robot, grid.method, &settings[0]), published, "{}", grid.method);
        for sets in &settings[1..] {
            assert_ne!(hash(robot, grid.method, sets), published, "{sets:?}");
        }
    }
}

#[test]
fn whatever_was_searched_for_is_a_row_and_nothing_else() {
    for kind in MethodKind::ALL {
        assert_eq!(kind.tuned_name(), format!("{kind}_tuned"));
        assert_eq!(MethodParameters::tuned(kind).kind(), kind);
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tuning");
    for (robot, grid) in every_grid() {
        let tuned = format!("{}_tuned", grid.method);
        let is_stored = folder.join(format!("{}_{}.csv", robot.name(), grid.method)).exists();
        assert!(Variant::names(robot).contains(&grid.method));
        assert_eq!(Variant::names(robot).contains(&tuned.as_str()), is_stored, "{tuned}");
        assert_eq!(Variant::named(robot, &tuned, &[]).is_ok(), is_stored, "{tuned}");
    }
}

#[test]
fn parameters_of_a_method_can_be_set_and_are_checked() {
    let named = |method: &str, set: &str| Variant::named(Robot::Quadrotor, method, &[set.to_owned()]);
    assert_eq!(
        named("c3bf", "method.k_per_s=3").unwrap().settings_hash(),
        hash(Robot::Quadrotor, "c3bf", &[]),
        "the published value changes nothing"
    );
    for (method, set) in [
        ("c3bf", "method.k1_per_s=3.0"),
        ("c3bf", "method.filter.nonsense=3.0"),
        ("c3bf", "method.k_per_s=fast"),
        ("c3bf", "method.method=\"ho_cbf\""),
        ("cn_cbf", "method.k_per_s=3.0"),
    ] {
        assert!(named(method, set).is_err(), "{method} {set}");
    }
}

#[test]
fn the_criterion_wants_success_among_those_that_are_fast_enough() {
    let of = |successes, ratio: f64, runs| Candidate {
        sets: Vec::new(),
        runs,
        successes,
        successes_smaller: successes,
        time_s: Some(10.0),
        time_ratio: Some(ratio),
    };
    let best = |candidates: &[Candidate]| ranking(candidates)[0];
    // More successes win, unless too slow; what was dropped early does not count.
    assert_eq!(best(&[of(5, 1.0, 10), of(7, 1.09, 10), of(9, 1.2, 10), of(4, 1.0, 4)]), 1);
    // A method that is slow as published may be as slow as that.
    assert_eq!(best(&[of(5, 1.3, 10), of(7, 1.25, 10), of(9, 1.31, 10)]), 1);
    // Of equals the faster, then the earlier.
    assert_eq!(best(&[of(5, 1.0, 10), of(7, 1.05, 10), of(7, 1.02, 10), of(7, 1.02, 10)]), 2);
    // What never came along with CN-CBF is not known to be fast.
    let unknown = Candidate { time_ratio: None, ..of(8, 1.0, 10) };
    assert_eq!(best(&[of(5, 1.0, 10), unknown]), 0);
}
