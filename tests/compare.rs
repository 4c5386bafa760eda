//! `cncbf compare`: two nominal controllers in the same world.

#[path = "stack/command.rs"]
mod command;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use command::{Said, at, cncbf, count, scratch};
use node_runtime::{Domain, ScopedDomain};
use serde_json::Value;

/// The project's own recording.
fn demo() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("recordings/demo_crowd.mcap")
}

/// What the command says of two controllers.
fn compare(arguments: &[&dyn AsRef<OsStr>]) -> Said {
    let mut all: Vec<&dyn AsRef<OsStr>> = vec![&"compare"];
    all.extend(arguments);
    Said::by(cncbf(&Domain::isolated(), &scratch("compare")), &all)
}

fn figures(arguments: &[&dyn AsRef<OsStr>]) -> Value {
    let said = compare(arguments);
    assert_eq!(said.code, 0, "{}", said.err);
    said.json()
}

fn number(figures: &Value, pointer: &str) -> f64 {
    at(figures, pointer).as_f64().unwrap_or_else(|| panic!("{pointer} is no number in {figures}"))
}

#[test]
fn a_controller_beside_itself_has_the_same_figures_to_the_last_byte() {
    let recording = demo();
    let figures = figures(&[&"mpc", &"mpc", &"--on", &recording, &"--json"]);
    assert_eq!(at(&figures, "/first"), at(&figures, "/second"));
    assert_eq!(at(&figures, "/identical"), true);
    assert_eq!(at(&figures, "/mode"), "lockstep");
}

#[test]
fn two_controllers_differ_where_they_must() {
    let recording = demo();
    let figures = figures(&[&"pure_pursuit", &"hold", &"--on", &recording, &"--json"]);
    assert_eq!(at(&figures, "/identical"), false);
    assert!(number(&figures, "/first/path_length_m") > 3.0);
    assert!(number(&figures, "/second/path_length_m") < 0.1);
    assert!(count(&figures, "/first/interventions") > 0);
    assert_eq!(count(&figures, "/second/interventions"), 0);
    assert!(number(&figures, "/first/mean_correction") > 0.0);
    assert_eq!(at(&figures, "/second/mean_correction"), &Value::Null, "nothing was ever corrected");
    assert!(number(&figures, "/second/braking_share") > 0.99);
    assert!(number(&figures, "/first/smoothness_per_s/0") > number(&figures, "/second/smoothness_per_s/0"));
}

#[test]
fn the_simulated_crowd_is_a_world_too_and_its_seed_matters() {
    let on = |seed: &str| {
        figures(&[&"mpc", &"pure_pursuit", &"--on", &format!("sim:{seed}"), &"--duration", &"8", &"--json"])
    };
    let (fourth, again, fifth) = (on("4"), on("4"), on("5"));
    assert_eq!(fourth, again);
    assert_ne!(at(&fourth, "/first/commands_sha256"), at(&fifth, "/first/commands_sha256"));
    assert_eq!(at(&fourth, "/identical"), false);
    let table = compare(&[&"mpc", &"pure_pursuit", &"--on", &"sim:4", &"--duration", &"8"]).out;
    for word in ["difference", "smoothness", "mean |u - u_nom|", "infeasible", "pure_pursuit", "lockstep"] {
        assert!(table.contains(word), "{word} is missing:\n{table}");
    }
}

#[test]
fn a_program_of_somebody_elses_is_driven_in_real_time() {
    let (domain, folder) = (ScopedDomain::new(), scratch("compare_program"));
    let program = format!("cmd:{} nominal --controller hold", env!("CARGO_BIN_EXE_cncbf"));
    let recording = demo();
    let said = Said::by(
        cncbf(&domain, &folder),
        &[&"compare", &"pure_pursuit", &program, &"--on", &recording, &"--duration", &"4", &"--json"],
    );
    assert_eq!(said.code, 0, "{}", said.err);
    let figures = said.json();
    assert_eq!(at(&figures, "/mode"), "real time");
    assert!(number(&figures, "/first/path_length_m") > 1.0, "{figures}");
    assert!(number(&figures, "/second/path_length_m") < 0.1, "{figures}");
    assert_eq!(figures.pointer("/identical"), None);
}

#[test]
fn a_program_that_says_nothing_is_named() {
    let (domain, folder) = (ScopedDomain::new(), scratch("compare_silent"));
    let recording = demo();
    let said = Said::by(
        cncbf(&domain, &folder),
        &[&"compare", &"cmd:sleep 30", &"hold", &"--on", &recording, &"--duration", &"1"],
    );
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.err.contains("sleep 30") && said.err.contains("check-controller"), "{}", said.err);
}

#[test]
fn a_program_that_cannot_start_is_found_out_before_anybody_drives() {
    let said = compare(&[&"mpc", &"cmd:./nowhere", &"--on", &"sim"]);
    assert_eq!(said.code, 2, "{said:?}");
    for words in ["ended by itself before the drive", "It printed:"] {
        assert!(said.err.contains(words), "{words}: {}", said.err);
    }
    assert!(!said.err.contains("driving with"), "{}", said.err);
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let recording = demo();
    for (arguments, word) in [
        ([&"mpc" as &dyn AsRef<OsStr>, &"external", &"--on", &recording], "cmd:"),
        ([&"mpc", &"pid", &"--on", &recording], "pure_pursuit"),
        ([&"mpc", &"lqr", &"--on", &recording], "nominal.controller"),
        ([&"mpc", &"hold", &"--on", &"sim:x"], "seed"),
        ([&"mpc", &"hold", &"--on", &"/nowhere.mcap"], "/nowhere.mcap"),
    ] {
        let said = compare(&arguments);
        assert_eq!(said.code, 2, "{said:?}");
        assert!(said.err.contains(word), "{word}: {}", said.err);
    }
}
