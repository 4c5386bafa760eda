//! `--shadow`: the robot does what it would have done alone, and the recording says what the filter would have done.

#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

#[path = "stack/command.rs"]
mod command;
#[path = "stack/peer.rs"]
mod peer;

use std::path::Path;
use std::process::{Command, Stdio};

use command::{Said, at, cncbf, count, scratch};
use messages::{Controller, NominalCommand, RobotState, SafeCommand, SafetyStatus};
use node_runtime::ScopedDomain;
use recording::{McapReader, SHADOW_KEY, read_wire};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

/// How long the peer may take to its goal, s. Alone on a machine it needs ten.
const PATIENCE_S: &str = "60";
/// |u − u_nom| from which on the filter counts as stepping in, in the units of the control.
const STEPS_IN: f64 = 0.02;

fn recorded<T: messages::Message>(recording: &Path) -> Vec<T> {
    read_wire(recording).unwrap().into_iter().map(|(_, message)| message).collect()
}

/// Whether the metadata of a recording say that the filter only watched.
fn says_shadow(recording: &Path) -> bool {
    let reader = McapReader::open(recording).unwrap();
    reader.summary().metadata["cncbf"].contains_key(SHADOW_KEY)
}

fn number(value: &Value, pointer: &str) -> f64 {
    at(value, pointer).as_f64().unwrap_or_else(|| panic!("{pointer} is no number in {value}"))
}

#[test]
fn the_simulated_robot_does_what_it_would_have_done_without_a_filter() {
    let (domain, folder) = (ScopedDomain::new(), scratch("shadow_sim"));
    // Seed 4 is the demo's: with the filter nobody is touched.
    let said = Said::by(
        cncbf(&domain, &folder),
        &[&"run", &"--shadow", &"--seed", &"4", &"--report", &"report", &"--json"],
    );
    assert_eq!(said.code, 0, "played to its end, whatever became of the robot: {}", said.err);
    let verdict = said.json();
    assert_eq!(at(&verdict, "/outcome"), "collision", "the filter drove: {verdict}");
    assert!(count(&verdict, "/collisions") > 0);
    assert!(number(&verdict, "/shadow/changed_share") > 0.05, "{verdict}");
    assert!(count(&verdict, "/shadow/moments_with_negative_h") > 0, "{verdict}");
    let recording = folder.join("report/run.mcap");
    assert!(says_shadow(&recording));
    let page = std::fs::read_to_string(folder.join("report/report.html")).unwrap();
    assert!(page.contains("the robot drove itself unfiltered") && page.contains("would have changed"));
    // Where the filter would have changed the command, the robot did what the nominal controller wanted.
    let states: Vec<RobotState> = recorded(&recording);
    let (mut judged, mut as_wanted) = (0, 0);
    for command in recorded::<SafeCommand>(&recording) {
        let next =
            states.partition_point(|state| state.stamp.valid_at_ns < command.ledger.filter_published_ns);
        let Some(state) = states.get(next + 1).filter(|_| correction(&command) > 0.2) else { continue };
        let moved = [state.velocity_in_base_mps[0], state.yaw_rate_radps];
        judged += 1;
        as_wanted += u32::from(apart(moved, command.nominal) < apart(moved, command.control));
    }
    assert!(judged > 50, "the filter wanted a change in {judged} cycles only");
    assert!(f64::from(as_wanted) > 0.95 * f64::from(judged), "{as_wanted} of {judged}");
}

/// Distance of two controls, in their units.
fn apart(one: [f64; 2], other: [f64; 2]) -> f64 {
    (one[0] - other[0]).hypot(one[1] - other[1])
}

/// |u − u_nom| where the barrier was evaluated, in the units of the control; else 0.
fn correction(command: &SafeCommand) -> f64 {
    let evaluated = [SafetyStatus::Filtered.code(), SafetyStatus::Relaxed.code()].contains(&command.status);
    if evaluated { apart(command.control, command.nominal) } else { 0.0 }
}

#[test]
fn without_shadow_nothing_says_so() {
    let (domain, folder) = (ScopedDomain::new(), scratch("shadow_without"));
    let said = Said::by(
        cncbf(&domain, &folder),
        &[&"run", &"--people", &"2", &"--duration", &"2", &"--report", &"report", &"--json"],
    );
    assert_eq!(said.json().pointer("/shadow"), None, "{}", said.out);
    assert!(!says_shadow(&folder.join("report/run.mcap")));
}

#[test]
fn a_live_robot_drives_itself_and_sees_no_writer_of_ours_on_its_command_topic() {
    let Some(python) = peer::python_or_say() else { return };
    let (domain, folder) = (ScopedDomain::new(), scratch("shadow_ros2"));
    let domain_id = peer::domain_id(2).to_string();
    let stack = cncbf(&domain, &folder)
        .args(["run", "--source", "ros2", "--shadow", "--report", "report", "--json"])
        .env("ROS_DOMAIN_ID", &domain_id)
        .env("ROS_LOCALHOST_ONLY", "1")
        .env("RUST_LOG", "warn,rustdds=off,ros2_client=off")
        .spawn()
        .unwrap();
    let judged = Command::new(python)
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/judges/ros2_shadow.py"))
        .args(["--domain", &domain_id, "--seconds", PATIENCE_S])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .output()
        .unwrap();
    kill_process(Pid::from_child(&stack), Signal::INT).unwrap();
    let said = Said::of(stack.wait_with_output().unwrap());
    let stderr = String::from_utf8_lossy(&judged.stderr);
    let seen: Value =
        serde_json::from_slice(&judged.stdout).unwrap_or_else(|error| panic!("{error}: {stderr}"));
    let log = std::fs::read_to_string(folder.join("report/bridge.log")).unwrap();
    println!("shadow_ros2: {seen}");
    assert_eq!(at(&seen, "/was_heard"), true, "{seen}\n{}\n{log}", said.err);
    assert_eq!(count(&seen, "/foreign_writers"), 0, "{seen}");
    assert!(count(&seen, "/received") <= count(&seen, "/sent"), "somebody else commanded: {seen}");
    assert!(number(&seen, "/reached_s") > 0.0, "{seen}");
    assert!(number(&seen, "/min_clearance_m") < 0.0, "it was kept from what it wanted: {seen}");
    assert_eq!(said.code, 0, "{}\n{log}", said.err);
    let verdict = said.json();
    assert!(number(&verdict, "/shadow/changed_share") > 0.0, "{verdict}");
    let recording = folder.join("report/run.mcap");
    assert!(says_shadow(&recording));
    let nominal: Vec<NominalCommand> = recorded(&recording);
    assert!(nominal.len() > 50, "{} nominal commands\n{log}", nominal.len());
    assert!(nominal.iter().all(|command| command.controller == Controller::Upstream.code()));
    assert_eq!(at(&verdict, "/commanders/0/name"), "upstream");
    let commands: Vec<SafeCommand> = recorded(&recording);
    let stepped_in = commands.iter().filter(|command| correction(command) > STEPS_IN);
    assert!(stepped_in.count() > 10, "the filter had nothing to object to a person on the way");
}
