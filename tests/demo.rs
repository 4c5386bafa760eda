//! `cncbf run` and the real-time `cncbf replay` as whole programs: what they leave, how they end, what they survive.

#[path = "stack/command.rs"]
mod command;
#[path = "stack/witness.rs"]
mod witness;

use std::path::Path;
use std::process::Child;

use command::{Said, at, cncbf, count, scratch};
use node_runtime::{Domain, ScopedDomain, leftovers, members};
use rustix::process::{Pid, Signal, kill_process};
use witness::Witness;

/// Name of a stack that nobody names.
const INSTANCE: &str = "cncbf";

/// How long a run drives before it is interrupted, ns.
const DRIVE_NS: u64 = 2_000_000_000;

/// Asserts that nothing of the domain is left in shared memory.
fn assert_clean(domain: &Domain) {
    assert_eq!(leftovers(domain).expect("a readable /dev/shm"), [], "the stack left something behind");
}

/// Asserts that a run left its report, its pictures and its logs in `folder`.
fn assert_complete(folder: &Path) {
    let size = |name: &str| std::fs::metadata(folder.join(name)).map_or(0, |metadata| metadata.len());
    for name in ["report.html", "birds_eye.svg", "settings.toml", "run.mcap"] {
        assert!(size(name) > 1000, "{name} has {} bytes", size(name));
    }
    for process in ["bridge", "estimator", "nominal", "filter", "recorder"] {
        let log = folder.join(format!("{process}.log"));
        let text = std::fs::read_to_string(&log).unwrap_or_else(|error| panic!("{}: {error}", log.display()));
        assert!(!text.contains("panicked"), "{process}: {text}");
    }
    let page = std::fs::read_to_string(folder.join("report.html")).expect("a report");
    assert!(page.contains("<svg") && page.contains("</html>"), "the report is incomplete");
    assert!(
        !page.contains("src=\"http") && !page.contains("href=\"http"),
        "the report is not self-contained"
    );
}

/// Asserts that a recording is undamaged and that a moment of it can be explained.
fn assert_readable(domain: &Domain, recording: &Path) {
    let inspected = Said::by(cncbf(domain, Path::new(".")), &[&"inspect", &recording, &"--json"]);
    assert_eq!(inspected.code, 0, "{}", inspected.err);
    assert_eq!(at(&inspected.json(), "/damage").as_array().map(Vec::len), Some(0), "{}", inspected.out);
    assert!(count(&inspected.json(), "/messages") > 100, "{}", inspected.out);
    let explained = Said::by(cncbf(domain, Path::new(".")), &[&"why", &recording, &"0.5"]);
    assert_eq!(explained.code, 0, "{}", explained.err);
}

/// Sends a signal to a process of this test.
fn signal(child: &Child, signal: Signal) {
    kill_process(Pid::from_child(child), signal).expect("a running process");
}

#[test]
fn a_short_run_leaves_everything_and_ends_with_the_documented_code() {
    let domain = ScopedDomain::new();
    let folder = scratch("demo_short");
    let report = folder.join("report");
    let said = Said::by(
        cncbf(&domain, &folder),
        &[&"run", &"--people", &"2", &"--duration", &"6", &"--report", &report, &"--json"],
    );
    // Six seconds are too short for fifteen metres: measured, and not reached.
    assert_eq!(said.code, 1, "{}", said.err);
    let verdict = said.json();
    assert_eq!(at(&verdict, "/outcome"), "not_reached", "{verdict}");
    assert_eq!(count(&verdict, "/collisions"), 0);
    assert!(count(&verdict, "/latency/cycles") > 250, "{verdict}");
    assert!(at(&verdict, "/path_length_m").as_f64().is_some_and(|length_m| length_m > 1.0), "{verdict}");
    assert_complete(&report);
    assert_readable(&domain, &report.join("run.mcap"));
    assert_clean(&domain);
}

#[test]
fn an_interrupted_run_ends_cleanly_with_a_readable_recording() {
    let domain = ScopedDomain::new();
    let folder = scratch("demo_interrupted");
    let mut witness = Witness::join(&domain, INSTANCE);
    let run = cncbf(&domain, &folder)
        .args(["run", "--people", "2", "--report", "report", "--json"])
        .spawn()
        .expect("the command starts");
    let since_ns = witness.watch_until_it_drives(0);
    witness.watch_until_a_cycle_after(since_ns + DRIVE_NS);
    drop(witness);
    signal(&run, Signal::INT);
    let said = Said::of(run.wait_with_output().expect("the command ends"));
    assert_eq!(said.code, 1, "{}", said.err);
    assert!(said.err.contains("interrupted"), "{}", said.err);
    assert_eq!(at(&said.json(), "/outcome"), "not_reached");
    assert_complete(&folder.join("report"));
    assert_readable(&domain, &folder.join("report/run.mcap"));
    assert_clean(&domain);
}

#[test]
fn a_run_survives_the_death_of_its_filter() {
    let domain = ScopedDomain::new();
    let folder = scratch("demo_killed");
    let mut witness = Witness::join(&domain, INSTANCE);
    let run = cncbf(&domain, &folder)
        .args(["run", "--people", "2", "--report", "report", "--json"])
        .spawn()
        .expect("the command starts");
    witness.watch_until_it_drives(0);
    let members = members(&domain).expect("a readable domain");
    let filter = members.iter().find(|member| member.alive && member.name == "cncbf/filter");
    let filter = filter.unwrap_or_else(|| panic!("no filter among {members:?}"));
    let before = *witness.commands.last().expect("commands");
    let pid = i32::try_from(filter.pid).ok().and_then(Pid::from_raw).expect("a process id");
    kill_process(pid, Signal::KILL).expect("a running filter");
    let mut restarted_ns = 0;
    witness.watch_until("the next filter's commands", |witness| {
        // A new process counts from the beginning.
        let first = witness.commands.iter().rev().find(|command| {
            command.sequence < before.sequence && command.ledger.filter_woke_ns > before.ledger.filter_woke_ns
        });
        restarted_ns = first.map_or(0, |command| command.ledger.filter_woke_ns);
        first.is_some()
    });
    let since_ns = witness.watch_until_it_drives(restarted_ns);
    witness.watch_until_a_cycle_after(since_ns + DRIVE_NS);
    drop(witness);
    signal(&run, Signal::INT);
    let said = Said::of(run.wait_with_output().expect("the command ends"));
    assert_eq!(said.code, 1, "{}", said.err);
    assert!(said.err.contains("ended unexpectedly"), "{}", said.err);
    assert_eq!(count(&said.json(), "/latency/restarts"), 1, "{}", said.out);
    assert_eq!(count(&said.json(), "/collisions"), 0);
    assert_readable(&domain, &folder.join("report/run.mcap"));
    assert_clean(&domain);
}

#[test]
fn a_recording_plays_through_four_processes() {
    let domain = ScopedDomain::new();
    let folder = scratch("demo_replay");
    let recording = Path::new(env!("CARGO_MANIFEST_DIR")).join("recordings/demo_crowd.mcap");
    let said = Said::by(cncbf(&domain, &folder), &[&"replay", &recording, &"--report", &"report", &"--json"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let figures = said.json();
    assert_eq!(at(&figures, "/mode"), "real time");
    assert_eq!(count(&figures, "/verdict/refused_inputs"), 0, "{figures}");
    assert_eq!(count(&figures, "/verdict/latency/lost_commands"), 0, "{figures}");
    assert_complete(&folder.join("report"));
    assert_readable(&domain, &folder.join("report/run.mcap"));
    assert_clean(&domain);
}
