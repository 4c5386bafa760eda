//! A stack in a ROS 2 graph of its own, and the scripts that are its peers there.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use node_runtime::Domain;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

use crate::command::{at, cncbf};

/// The shipped settings with a place in the graph that asks for these messages.
pub(crate) fn settings(folder: &Path, obstacles: &str, reliability: &str, command: &str) -> PathBuf {
    let graph = format!(
        "[source.ros2]\nnode_name = \"filter\"\nnamespace = \"/robot\"\nobstacles = \"{obstacles}\"\n\
         reliability = \"{reliability}\"\ncommand_topic = \"/cmd_vel\"\ncommand = \"{command}\"\ncommand_period_ms = 10\n"
    );
    let topics = |text: &str| {
        text.replacen("odometry_topic = \"\"", "odometry_topic = \"/odom\"", 1)
            .replacen("detections_topic = \"\"", "detections_topic = \"/detections\"", 1)
            .replacen("goal_topic = \"\"", "goal_topic = \"/goal_pose\"", 1)
    };
    let shipped = topics(include_str!("../../config/ground_robot.toml"));
    let file = folder.join("graph.toml");
    std::fs::write(&file, shipped.replacen("[simulation]", &(graph + "\n[simulation]"), 1))
        .expect("writable");
    file
}

/// A stack that listens to ROS domain `domain_id`.
pub(crate) fn stack(domain: &Domain, folder: &Path, domain_id: u32, config: &[&str]) -> Child {
    cncbf(domain, folder)
        .args(["run", "--source", "ros2", "--report", "report", "--json"])
        .args(config)
        .env("ROS_DOMAIN_ID", domain_id.to_string())
        .env("ROS_LOCALHOST_ONLY", "1")
        .env("RUST_LOG", "warn,rustdds=off,ros2_client=off")
        .spawn()
        .expect("the command starts")
}

/// The peer whose script in tests/judges this is.
pub(crate) fn script(python: &Path, script: &str, domain_id: u32, arguments: &[&str]) -> Command {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/judges").join(script);
    let mut command = Command::new(python);
    command
        .arg(file)
        .args(["--domain", &domain_id.to_string()])
        .args(arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// Ends a stack as Ctrl+C does.
pub(crate) fn interrupt(child: &Child) {
    kill_process(Pid::from_child(child), Signal::INT).expect("a running stack");
}

/// The number that a JSON pointer names.
pub(crate) fn number(seen: &Value, key: &str) -> f64 {
    at(seen, key).as_f64().unwrap_or_else(|| panic!("{key} is no number in {seen}"))
}
