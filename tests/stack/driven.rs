//! A stack beside a peer that simulates robot and people (`tests/judges/ros2_robot.py`), and what both say of the drive.

use std::path::Path;
use std::process::Command;

use node_runtime::ScopedDomain;
use serde_json::Value;

use crate::command::{Said, at, scratch};
use crate::peer;
use crate::ros2::{interrupt, number, script, stack};

/// How long the robot may take to its goal, s. Alone on a machine it needs ten.
pub(crate) const PATIENCE_S: &str = "90";

/// The peer with its world.
pub(crate) fn robot(python: &Path, domain_id: u32, arguments: &[&str]) -> Command {
    script(python, "ros2_robot.py", domain_id, arguments)
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
    let (domain, folder, domain_id) = (ScopedDomain::new(), scratch(name), peer::domain_id(offset));
    let stack = stack(&domain, &folder, domain_id, config);
    let judged = robot(python, domain_id, peer).output();
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

/// Asserts what a judge outside the stack can see of a good drive.
pub(crate) fn assert_driven(said: &Said, seen: &Value, log: &str) {
    assert!(number(seen, "/reached_s") > 0.0, "{seen}\n{}\n{log}", said.err);
    assert_eq!(at(seen, "/stands"), true, "the robot drives on: {seen}");
    assert!(number(seen, "/min_clearance_m") > 0.0, "somebody was touched: {seen}");
    assert_eq!(said.code, 0, "{}", said.err);
}
