//! The stack in a ROS 2 graph whose other end is CycloneDDS in Python: robot, people and judge are nobody's here.
//!
//! The package comes from PyPI into a virtual environment of this test; where that cannot be made, the tests say so and pass.

#[path = "stack/command.rs"]
mod command;
#[path = "stack/driven.rs"]
mod driven;
#[path = "stack/peer.rs"]
mod peer;
#[path = "stack/ros2.rs"]
mod ros2;
#[path = "stack/witness.rs"]
mod witness;

use std::path::Path;

use command::{Said, at, cncbf, count, scratch};
use driven::{PATIENCE_S, assert_driven, drive, robot};
use messages::{Reason, SafetyStatus};
use node_runtime::{Clock, RealClock, ScopedDomain};
use ros2::{interrupt, number, settings, stack};
use serde_json::Value;
use witness::Witness;

/// From the death of the robot's peer on, no cycle that begins later than this may do anything but brake, ns.
const LIMIT_NS: u64 = 100_000_000;

/// Asserts what a judge outside the stack can see of a good drive.
fn assert_reached(said: &Said, seen: &Value, log: &str) {
    assert_driven(said, seen, log);
    assert_eq!(at(&said.json(), "/outcome"), "reached");
    assert_eq!(count(&said.json(), "/refused_inputs"), 0, "{log}");
}

#[test]
fn a_robot_that_knows_ros_alone_is_driven_to_its_goal() {
    let Some((said, seen, log)) = drive("ros2_customary", 0, &[], &["--seconds", PATIENCE_S]) else { return };
    assert_reached(&said, &seen, &log);
    assert_eq!(at(&seen, "/nodes/0"), "/cncbf", "the stack's node in the ROS graph");
}

#[test]
fn tracks_in_a_frame_of_their_own_are_driven_around_with_stamped_commands() {
    let folder = scratch("ros2_tracks_settings");
    let config = settings(
        &folder,
        "autoware_perception_msgs/TrackedObjects",
        "best_effort",
        "geometry_msgs/TwistStamped",
    );
    let config = config.to_str().expect("a plain path");
    let peer = ["--obstacles", "tracks", "--command", "twist_stamped", "--best-effort", "--frame", "camera"];
    let peer = [&peer[..], &["--seconds", PATIENCE_S]].concat();
    let Some((said, seen, log)) = drive("ros2_tracks", 1, &["--config", config], &peer) else { return };
    assert_reached(&said, &seen, &log);
    assert_eq!(at(&seen, "/nodes/0"), "/robot/filter");
}

#[test]
fn a_quality_of_service_that_does_not_fit_is_named_and_the_robot_kept_standing() {
    let folder = scratch("ros2_quality_settings");
    let config = settings(&folder, "geometry_msgs/PoseArray", "reliable", "geometry_msgs/Twist");
    let config = config.to_str().expect("a plain path");
    let peer = ["--obstacles", "poses", "--best-effort", "--seconds", "8"];
    let Some((said, seen, log)) = drive("ros2_quality", 2, &["--config", config], &peer) else { return };
    // Nothing to judge: not one robot state was heard.
    assert_eq!(said.code, 2, "{}", said.err);
    assert_eq!(at(&seen, "/moved_s"), &Value::Null, "driven without odometry: {seen}");
    assert!(number(&seen, "/commands") > 0.0, "a standstill is commanded all the same: {seen}");
    for topic in ["/odom", "/detections"] {
        let names = |what: &str| log.lines().any(|line| line.contains(topic) && line.contains(what));
        assert!(names("quality of service does not fit"), "{topic}: {log}");
        assert!(names("nothing arrives"), "{topic}: {log}");
    }
}

#[test]
fn a_peer_that_is_killed_is_braked_for_and_its_successor_driven_to_the_goal() {
    let Some(python) = peer::python_or_say() else { return };
    let (domain, folder, domain_id) = (ScopedDomain::new(), scratch("ros2_killed"), peer::domain_id(3));
    let mut witness = Witness::join(&domain, "cncbf");
    let stack = stack(&domain, &folder, domain_id, &[]);
    let mut peer = robot(python, domain_id, &["--seconds", PATIENCE_S]).spawn().expect("the peer starts");
    witness.watch_until_it_drives(0);
    peer.kill().expect("a running peer");
    let killed_ns = RealClock.now_ns();
    peer.wait().expect("it ends");
    witness.watch_until_a_cycle_after(killed_ns + 1_000_000_000);
    let after: Vec<_> = witness
        .commands
        .iter()
        .filter(|command| command.ledger.filter_woke_ns > killed_ns + LIMIT_NS)
        .collect();
    assert!(after.len() > 100, "the filter goes on");
    for command in after {
        let brakes = [SafetyStatus::Braking.code(), SafetyStatus::Stopped.code()].contains(&command.status);
        assert!(brakes && command.reason == Reason::StaleRobotState.code(), "{command:?}");
    }
    // It begins anew where the other one began; DDS will miss the dead one ten seconds from now.
    let judged = robot(python, domain_id, &["--seconds", PATIENCE_S]).output().expect("the peer starts");
    drop(witness);
    interrupt(&stack);
    let said = Said::of(stack.wait_with_output().expect("the command ends"));
    let seen: Value = serde_json::from_slice(&judged.stdout)
        .unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(&judged.stderr)));
    println!("ros2_killed: {seen}");
    assert!(number(&seen, "/reached_s") > 0.0, "{seen}\n{}", said.err);
    assert!(number(&seen, "/min_clearance_m") > 0.0, "somebody was touched: {seen}");
    assert_eq!(said.code, 0, "{}", said.err);
}

#[test]
fn an_environment_that_names_no_domain_is_refused() {
    let domain = ScopedDomain::new();
    let mut bridge = cncbf(&domain, Path::new("."));
    bridge.env("ROS_DOMAIN_ID", "233");
    let said = Said::by(bridge, &[&"bridge", &"--source", &"ros2"]);
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.err.contains("ROS_DOMAIN_ID=`233`") && said.err.contains("0 to 232"), "{}", said.err);
}

#[test]
fn a_whole_run_is_refused_for_it_before_any_process_starts() {
    let (domain, folder) = (ScopedDomain::new(), scratch("ros2_no_domain"));
    let mut run = cncbf(&domain, &folder);
    run.env("ROS_DOMAIN_ID", "abc");
    let said = Said::by(run, &[&"run", &"--source", &"ros2", &"--report", &"report"]);
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.err.contains("ROS_DOMAIN_ID=`abc`"), "{}", said.err);
    assert!(!folder.join("report").exists(), "a run folder for nothing");
}
