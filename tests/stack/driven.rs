//! A stack beside a peer that simulates robot and people (`tests/judges/ros2_robot.py`), and what both say of the drive.

use std::path::Path;
use std::process::{Child, Command, Stdio};

use node_runtime::{Domain, ScopedDomain};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

use crate::command::{Said, at, cncbf, scratch};
use crate::peer;

/// How long the robot may take to its goal, s. Alone on a machine it needs ten.
pub(crate) const PATIENCE_S: &str = "90";

/// A stack that listens to ROS domain `domain_id`.
pub(crate) fn stack(domain: &Domain, folder: &Path, domain_id: &str, config: &[&str]) -> Child {
    cncbf(domain, folder)
        .args(["run", "--source", "ros2", "--report", "report", "--json"])
        .args(config)
        .env("ROS_DOMAIN_ID", domain_id)
        .env("ROS_LOCALHOST_ONLY", "1")
        .env("RUST_LOG", "warn,rustdds=off,ros2_client=off")
        .spawn()
        .expect("the command starts")
}

/// The peer with its world.
pub(crate) fn robot(python: &Path, domain_id: &str, arguments: &[&str]) -> Command {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/judges/ros2_robot.py");
    let mut command = Command::new(python);
    command
        .arg(script)
        .args(["--domain", domain_id])
        .args(arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// A stack beside a peer: starts the stack, runs the peer to its end, interrupts the stack. What both said, and the
/// bridge's log; `None` where there is no peer.
pub(crate) fn drive(
    name: &str,
    offset: u32,
    config: &[&str],
    peer: &[&str],
) -> Option<(Said, Value, String)> {
    let python = peer::python_or_say()?;
    let (domain, folder, domain_id) =
        (ScopedDomain::new(), scratch(name), peer::domain_id(offset).to_string());
    let stack = stack(&domain, &folder, &domain_id, config);
    let judged = robot(python, &domain_id, peer).output();
    let judged = judged.expect("the peer starts");
    interrupt(&stack);
    let said = Said::of(stack.wait_with_output().expect("the command ends"));
    let stderr = String::from_utf8_lossy(&judged.stderr);
    assert!(judged.status.success(), "the peer failed: {stderr}");
    let seen = serde_json::from_slice(&judged.stdout).unwrap_or_else(|error| panic!("{error}: {stderr}"));
    println!("{name}: {seen}");
    let log = std::fs::read_to_string(folder.join("report/bridge.log")).expect("the bridge's log");
    Some((said, seen, log))
}

/// Asks a running stack to end.
pub(crate) fn interrupt(child: &Child) {
    kill_process(Pid::from_child(child), Signal::INT).expect("a running stack");
}

/// A number that the peer said.
pub(crate) fn number(seen: &Value, key: &str) -> f64 {
    at(seen, key).as_f64().unwrap_or_else(|| panic!("{key} is no number in {seen}"))
}

/// Asserts what a judge outside the stack can see of a good drive.
pub(crate) fn assert_driven(said: &Said, seen: &Value, log: &str) {
    assert!(number(seen, "/reached_s") > 0.0, "{seen}\n{}\n{log}", said.err);
    assert_eq!(at(seen, "/stands"), true, "the robot drives on: {seen}");
    assert!(number(seen, "/min_clearance_m") > 0.0, "somebody was touched: {seen}");
    assert_eq!(said.code, 0, "{}", said.err);
}
