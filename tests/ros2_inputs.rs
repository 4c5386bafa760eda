//! What a ROS 2 robot may say beside odometry, boxes and goals, said by CycloneDDS in Python: paths, commands of its own,
//! simulated time; crowds and garbage; and the bridge that is told late.
//!
//! Single messages are compared field by field in perception_bridge's own tests. Where there is no peer, each test says so and
//! passes.

#[path = "stack/command.rs"]
#[expect(dead_code, reason = "the stack runs beside its peer, never to its end alone")]
mod command;
#[path = "stack/driven.rs"]
mod driven;
#[path = "stack/peer.rs"]
mod peer;
#[path = "stack/ros2.rs"]
#[expect(dead_code, reason = "the settings of these drives name what is heard, not how")]
mod ros2;
#[path = "stack/witness.rs"]
#[expect(dead_code, reason = "the witness of faults knows more ways to wait")]
mod witness;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use command::{Said, at, cncbf, scratch};
use driven::{PATIENCE_S, assert_driven, drive, robot};
use messages::{Detections, MAX_OBSTACLES, Message, ProcessId, Reason, SafetyStatus, SourceStatus};
use node_runtime::{Clock, Node, RealClock, ScopedDomain, Subscriber};
use ros2::{interrupt, number, stack};
use serde_json::Value;
use witness::Witness;

/// The shipped settings with these keys for the place in the graph, and `nominal` as the controller.
fn settings(folder: &Path, keys: &str, nominal: &str) -> PathBuf {
    let graph = format!(
        "[source.ros2]\nnode_name = \"cncbf\"\nnamespace = \"/\"\nobstacles = \"vision_msgs/Detection3DArray\"\n\
         reliability = \"best_effort\"\ncommand_topic = \"cmd_vel\"\ncommand = \"geometry_msgs/Twist\"\n\
         command_period_ms = 10\n{keys}\n\n[simulation]"
    );
    let shipped = include_str!("../config/ground_robot.toml").replacen("[simulation]", &graph, 1);
    let file = folder.join("graph.toml");
    let controller = format!("controller = \"{nominal}\"");
    let mut text = shipped.replacen("controller = \"mpc\"", &controller, 1);
    if nominal == "external" {
        // The peer's own controller circles its goal when it comes to it aside; behind this buffer it comes in straight.
        text = text.replacen("sdf_buffer_m = 0.05", "sdf_buffer_m = 0.25", 1);
    }
    std::fs::write(&file, text).expect("writable");
    file
}

/// A drive with these keys.
fn drive_with(
    name: &str,
    offset: u32,
    keys: &str,
    nominal: &str,
    peer: &[&str],
) -> Option<(Said, Value, String)> {
    let folder = scratch(&format!("{name}_settings"));
    let config = settings(&folder, keys, nominal);
    drive(name, offset, &["--config", config.to_str().expect("a plain path")], peer)
}

/// Whether one line of the log says all of this.
fn says(log: &str, words: &[&str]) -> bool {
    log.lines().any(|line| words.iter().all(|word| line.contains(word)))
}

#[test]
fn a_path_is_followed_around_its_corner_to_its_end() {
    let peer = ["--aim", "path", "--seconds", PATIENCE_S];
    let Some((said, seen, log)) = drive_with("ros2_path", 0, "path_topic = \"/plan\"", "mpc", &peer) else {
        return;
    };
    assert_driven(&said, &seen, &log);
    // The straight way to the end passes the corner by two metres.
    assert!(number(&seen, "/corner_m") < 1.2, "{seen}");
    assert_eq!(at(&said.json(), "/outcome"), "reached");
}

#[test]
fn the_robots_own_commands_are_filtered_and_nobody_speaks_of_a_goal() {
    let keys = "nominal_topic = \"/cmd_vel_smoothed\"";
    let peer = ["--aim", "upstream", "--seconds", PATIENCE_S];
    let Some((said, seen, log)) = drive_with("ros2_upstream", 1, keys, "external", &peer) else { return };
    assert_driven(&said, &seen, &log);
    assert_eq!(at(&said.json(), "/goal_distance_m"), &Value::Null, "{}", said.out);
}

#[test]
fn an_upstream_that_dies_is_braked_for() {
    let Some(python) = peer::python_or_say() else { return };
    let (domain, folder) = (ScopedDomain::new(), scratch("ros2_upstream_dies"));
    let domain_id = peer::domain_id(2);
    let config = settings(&folder, "nominal_topic = \"/cmd_vel_smoothed\"", "external");
    let mut witness = Witness::join(&domain, "cncbf");
    let stack = stack(&domain, &folder, domain_id, &["--config", config.to_str().expect("a plain path")]);
    let peer = ["--aim", "upstream", "--upstream-seconds", "2", "--seconds", "60"];
    let mut peer = robot(python, domain_id, &peer).spawn().expect("the peer starts");
    witness.watch_until_it_drives(0);
    let stopped = SafetyStatus::Stopped.code();
    witness.watch_until("the robot to stand for want of commands", |witness| {
        let last = witness.commands.last();
        last.is_some_and(|last| last.status == stopped && last.reason == Reason::StaleNominalCommand.code())
    });
    let braking = SafetyStatus::Braking.code();
    let silent = Reason::StaleNominalCommand.code();
    let brakes = |command: &&messages::SafeCommand| command.status == braking && command.reason == silent;
    assert!(witness.commands.iter().any(|command| brakes(&command)), "it stood without braking");
    peer.kill().expect("a running peer");
    peer.wait().expect("it ends");
    drop(witness);
    interrupt(&stack);
    Said::of(stack.wait_with_output().expect("the command ends"));
}

#[test]
fn a_simulation_that_begins_anew_is_driven_to_its_goal() {
    let peer = ["--sim-time", "--reset-after", "2", "--seconds", PATIENCE_S];
    let Some((said, seen, log)) = drive_with("ros2_sim", 3, "use_sim_time = true", "mpc", &peer) else {
        return;
    };
    assert_driven(&said, &seen, &log);
    assert_eq!(at(&seen, "/resets"), 1, "{seen}");
    assert!(says(&log, &["/clock", "clock_jump", "count=1"]), "{log}");
}

#[test]
fn the_date_is_foreign_to_a_simulation_and_the_other_way_round() {
    for (name, offset, keys, peer) in [
        ("ros2_no_clock", 4, "use_sim_time = true", &[][..]),
        ("ros2_sim_unasked", 5, "", &["--sim-time"][..]),
    ] {
        let peer = [peer, &["--seconds", "6"]].concat();
        let Some((said, seen, log)) = drive_with(name, offset, keys, "mpc", &peer) else { return };
        assert_eq!(said.code, 2, "{}", said.err);
        assert_eq!(at(&seen, "/moved_s"), &Value::Null, "driven all the same: {seen}");
        for topic in ["/odom", "/detections"] {
            assert!(says(&log, &[topic, "foreign_clock"]), "{topic}: {log}");
        }
        let is_missed = says(&log, &["/clock", "nothing arrives"]);
        assert_eq!(is_missed, name == "ros2_no_clock", "{log}");
    }
}

/// Takes messages until `met`.
fn watch<M: Message>(port: &mut Subscriber<M>, what: &str, mut met: impl FnMut(&M) -> bool) -> M {
    let give_up_ns = RealClock.now_ns() + 40_000_000_000;
    loop {
        if let Some(message) = port.newest()
            && met(&message)
        {
            return message;
        }
        assert!(RealClock.now_ns() < give_up_ns, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn a_bridge_that_joins_late_takes_the_nearest_of_a_crowd_and_survives_garbage() {
    let Some(python) = peer::python_or_say() else { return };
    let (domain, folder) = (ScopedDomain::new(), scratch("ros2_crowd"));
    let domain_id = peer::domain_id(6).to_string();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/judges/ros2_crowd.py");
    let mut peer = Command::new(python)
        .arg(script)
        .args(["--domain", &domain_id, "--seconds", "80"])
        .stdout(Stdio::piped())
        .spawn()
        .expect("the peer starts");
    // It has said where its camera is, once, before anybody listens.
    let mut first = [0; 6];
    std::io::Read::read_exact(peer.stdout.as_mut().expect("piped"), &mut first).expect("it begins");
    assert_eq!(&first, b"begun\n");
    let bridge = cncbf(&domain, &folder)
        .args(["bridge", "--source", "ros2"])
        .env("ROS_DOMAIN_ID", &domain_id)
        .env("ROS_LOCALHOST_ONLY", "1")
        .env("RUST_LOG", "warn,rustdds=off,ros2_client=off")
        .spawn()
        .expect("the command starts");
    let node = Node::open_in(&domain, "cncbf", ProcessId::Launcher).expect("a node");
    let mut frames: Subscriber<Detections> = node.subscriber().expect("a reader of detections");
    let mut status: Subscriber<SourceStatus> = node.subscriber().expect("a reader of the status");

    let frame = watch(&mut frames, "a frame of the crowd near the robot", |frame| frame.stamp.sequence > 3);
    assert_eq!((frame.count as usize, frame.left_out as usize), (MAX_OBSTACLES, 400 - MAX_OBSTACLES));
    // The camera lies one metre ahead of odom's origin, turned left by a quarter; the crowd stands along its x axis.
    for (index, found) in frame.as_slice().iter().enumerate() {
        let expected = [1.0, 3.0 + 0.05 * index as f64];
        for (found, expected) in found.position_in_odom_m.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9, "{index}: {found} is not {expected}");
        }
    }
    // The garbage comes on both topics, in the middle of good messages.
    let refused = watch(&mut status, "the garbage to be counted", |status| status.refused >= 40);
    let before = frame.stamp.sequence;
    watch(&mut frames, "frames after the garbage", |frame| frame.stamp.sequence > before + 20);
    peer.kill().expect("a running peer");
    peer.wait().expect("it ends");
    drop((frames, status, node));
    interrupt(&bridge);
    let said = Said::of(bridge.wait_with_output().expect("the command ends"));
    println!("ros2_crowd: {} refused\n{}", refused.refused, said.err);
    assert_eq!(said.code, 0, "{}", said.err);
    for topic in ["/odom", "/detections"] {
        assert!(says(&said.err, &[topic, "malformed_input"]), "{topic}: {}", said.err);
    }
}
