//! The stack in a ROS 2 graph whose other end is Fast DDS in C++, the middleware that most ROS 2 robots run.
//!
//! Needs a C++ compiler and Debian's `libfastrtps-dev`; where they are absent, the test says so and passes.

#[path = "stack/command.rs"]
#[expect(dead_code, reason = "the stack runs beside its peer, never to its end alone")]
mod command;

use std::path::{Path, PathBuf};
use std::process::Command;

use command::{Said, at, cncbf, count, scratch};
use node_runtime::ScopedDomain;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

/// Where Debian puts Fast DDS.
const HEADER: &str = "/usr/include/fastdds/dds/domain/DomainParticipant.hpp";
/// How long the robot may take to its goal, s. Alone on a machine it needs ten.
const PATIENCE_S: &str = "90";

/// Builds the peer; `None` where Fast DDS is absent.
fn robot(folder: &Path) -> Option<PathBuf> {
    let compiles = Command::new("c++").arg("--version").output().is_ok_and(|output| output.status.success());
    if !compiles || !Path::new(HEADER).exists() {
        println!("skipped: no C++ compiler with Fast DDS (Debian: apt-get install g++ libfastrtps-dev)");
        return None;
    }
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/judges/ros2_fastdds_robot.cpp");
    let program = folder.join("robot");
    let build = Command::new("c++")
        .args(["-std=c++17", "-O1", "-Wall", "-Wextra", source, "-lfastrtps", "-lfastcdr", "-o"])
        .arg(&program)
        .output()
        .expect("the compiler starts");
    assert!(build.status.success(), "{}", String::from_utf8_lossy(&build.stderr));
    Some(program)
}

#[test]
fn a_robot_on_fast_dds_is_driven_to_its_goal() {
    let (domain, folder) = (ScopedDomain::new(), scratch("ros2_fastdds"));
    let Some(robot) = robot(&folder) else { return };
    let settings = folder.join("graph.toml");
    let table = "[source.ros2]\nnode_name = \"filter\"\nnamespace = \"/\"\nobstacles = \"geometry_msgs/PoseArray\"\n\
                 reliability = \"reliable\"\ncommand_topic = \"cmd_vel\"\ncommand = \"geometry_msgs/Twist\"\n\
                 command_period_ms = 10\n\n[simulation]";
    let shipped = include_str!("../config/ground_robot.toml");
    std::fs::write(&settings, shipped.replacen("[simulation]", table, 1)).expect("writable");
    let domain_id = (100 + std::process::id() % 20).to_string();
    let stack = cncbf(&domain, &folder)
        .args(["run", "--source", "ros2", "--config", "graph.toml", "--report", "report", "--json"])
        .env("ROS_DOMAIN_ID", &domain_id)
        .env("ROS_LOCALHOST_ONLY", "1")
        .env("RUST_LOG", "warn,rustdds=off,ros2_client=off")
        .spawn()
        .expect("the command starts");
    let judged = Command::new(robot).args([&domain_id, PATIENCE_S]).output().expect("the peer starts");
    kill_process(Pid::from_child(&stack), Signal::INT).expect("a running stack");
    let said = Said::of(stack.wait_with_output().expect("the command ends"));
    let seen: Value = serde_json::from_slice(&judged.stdout)
        .unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(&judged.stderr)));
    println!("Fast DDS: {seen}");
    let log = std::fs::read_to_string(folder.join("report/bridge.log")).expect("the bridge's log");
    let number = |pointer: &str| at(&seen, pointer).as_f64().expect("a number");
    assert!(number("/reached_s") > 0.0, "{seen}\n{}\n{log}", said.err);
    assert_eq!(at(&seen, "/stands"), true, "the robot drives on: {seen}");
    assert!(number("/min_clearance_m") > 0.0, "somebody was touched: {seen}");
    assert_eq!(count(&seen, "/unusable_commands"), 0);
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(at(&said.json(), "/outcome"), "reached");
    assert_eq!(count(&said.json(), "/refused_inputs"), 0, "{log}");
}
