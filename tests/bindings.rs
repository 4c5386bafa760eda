//! A program in Python or C in the nominal controller's place, from the beginning to the goal; and a reader beside it.
//!
//! Python needs `python3` and PyPI for `iceoryx2`, C needs `cc`; where one is missing, its test says so and ends.

#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

#[path = "stack/command.rs"]
mod command;
#[path = "stack/guests.rs"]
mod guests;

use std::path::Path;

use command::{Said, at, cncbf, count, scratch};
use guests::{C_CONTROLLER, Guest, PYTHON_CONTROLLER, c_program, python};
use messages::{Intent, NominalCommand, SafeCommand, SafetyStatus};
use node_runtime::{Domain, ScopedDomain};
use recording::read_wire;

/// Every message of one kind, in the order of the recording.
fn said_in<T: messages::Message>(recording: &Path) -> Vec<T> {
    let stamped = read_wire(recording).expect("a readable recording");
    stamped.into_iter().map(|(_, message)| message).collect()
}

/// Runs the demo without a nominal controller of ours, and asserts that `controller` drove it to its goal.
fn assert_drives_to_the_goal(domain: &Domain, folder: &Path, controller: u32) {
    let said = Said::by(
        cncbf(domain, folder),
        &[&"run", &"--controller", &"external", &"--people", &"4", &"--report", &"report", &"--json"],
    );
    assert_eq!(said.code, 0, "{} {}", said.out, said.err);
    let verdict = said.json();
    assert_eq!(at(&verdict, "/outcome"), "reached", "{verdict}");
    assert_eq!(count(&verdict, "/collisions"), 0);
    assert!(!folder.join("report/nominal.log").exists(), "a nominal process of our own ran");
    let recording = folder.join("report/run.mcap");
    let nominal: Vec<NominalCommand> = said_in(&recording);
    assert!(nominal.len() > 100, "only {} commands", nominal.len());
    assert!(nominal.iter().all(|command| command.controller == controller));
    assert_eq!(nominal.last().map(|command| command.intent), Some(Intent::Stop.code()));
    let safe: Vec<SafeCommand> = said_in(&recording);
    let filtered = safe.iter().filter(|command| command.status == SafetyStatus::Filtered.code()).count();
    assert!(filtered * 2 > safe.len(), "only {filtered} of {} commands rest on it", safe.len());
    let age_ns = nominal.iter().map(|command| command.stamp.published_ns - command.bridge_published_ns);
    println!("median age of the robot state when it was answered: {:.1} ms", median_ms(age_ns.collect()));
}

fn median_ms(mut times_ns: Vec<u64>) -> f64 {
    times_ns.sort_unstable();
    times_ns[times_ns.len() / 2] as f64 * 1e-6
}

#[test]
fn a_python_controller_drives_the_demo_to_its_goal() {
    let Some(python) = python() else { return };
    let domain = ScopedDomain::new();
    let folder = scratch("bindings_python");
    let controller = Guest::python(python, &domain, "pure_pursuit.py", &[]);
    let reader = Guest::python(python, &domain, "watch_filter.py", &["--seconds", "8"]);
    assert_drives_to_the_goal(&domain, &folder, PYTHON_CONTROLLER);
    controller.end();
    let read = reader.ended();
    assert!(read.code == 0 && read.out.contains("filtered (none)"), "{read:?}");
}

#[test]
fn a_c_controller_drives_the_demo_to_its_goal() {
    let Some(program) = c_program() else { return };
    let domain = ScopedDomain::new();
    let folder = scratch("bindings_c");
    let controller = Guest::c(program, &domain);
    assert_drives_to_the_goal(&domain, &folder, C_CONTROLLER);
    controller.end();
}
