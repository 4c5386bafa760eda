//! What the stack tells a ROS 2 graph of itself and of the graph's faults, heard by CycloneDDS in Python.

#[path = "stack/command.rs"]
mod command;
#[path = "stack/peer.rs"]
mod peer;
#[path = "stack/ros2.rs"]
mod ros2;
#[path = "stack/witness.rs"]
#[expect(dead_code, reason = "what the stack does is heard by its peer")]
mod witness;

use std::path::Path;
use std::process::Child;

use command::{Said, at, cncbf, count, scratch};
use node_runtime::{Domain, ScopedDomain};
use peer::{domain_id, python_or_say};
use recording::ros2::{FilterState, Ros2Message};
use ros2::{interrupt, number, script, settings, stack};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use witness::Witness;

/// The peer: a robot that listens.
const LISTENER: &str = "ros2_graph.py";
/// Longest time from a fault of the graph to its name, s.
const NAMED_WITHIN_S: f64 = 2.0;
const MARKER_CYLINDER: i64 = 3;
const MARKER_LINE_LIST: i64 = 5;

fn finished(peer: Child) -> Value {
    let judged = peer.wait_with_output().expect("the peer ends");
    let stderr = String::from_utf8_lossy(&judged.stderr);
    assert!(judged.status.success(), "the peer failed: {stderr}");
    serde_json::from_slice(&judged.stdout).unwrap_or_else(|error| panic!("{error}: {stderr}"))
}

/// The time of day of a line of the log, s.
fn time_of_day_s(line: &str) -> Option<f64> {
    let time = line.split_whitespace().next()?.split_once('T')?.1.strip_suffix('Z')?;
    let mut parts = time.splitn(3, ':').map(str::parse::<f64>);
    Some(parts.next()?.ok()? * 3600.0 + parts.next()?.ok()? * 60.0 + parts.next()?.ok()?)
}

/// How long after `date_s` the log first says something with all of `words`, s.
fn logged_after_s(log: &str, date_s: f64, words: &[&str]) -> Option<f64> {
    const DAY_S: f64 = 86_400.0;
    let lines = log.lines().filter(|line| words.iter().all(|word| line.contains(word)));
    let after = lines.filter_map(time_of_day_s).map(|time_s| (time_s - date_s).rem_euclid(DAY_S));
    // What was said before is nearly a day old.
    after.filter(|after_s| *after_s < DAY_S / 2.0).reduce(f64::min)
}

fn strings(value: &Value) -> Vec<&str> {
    value.as_array().expect("a list").iter().filter_map(Value::as_str).collect()
}

#[test]
fn the_stack_tells_how_it_is_and_names_what_is_wrong_with_the_graph() {
    let Some(python) = python_or_say() else { return };
    let (domain, folder, domain_id) = (ScopedDomain::new(), scratch("ros2_graph"), domain_id(0));
    let config = settings(&folder, "vision_msgs/Detection3DArray", "reliable", "geometry_msgs/Twist");
    let stack = stack(&domain, &folder, domain_id, &["--config", config.to_str().expect("a plain path")]);
    let arguments = ["--node", "/robot/filter", "--faults", "--markers", "--far-goal", "--seconds", "60"];
    let seen = finished(script(python, LISTENER, domain_id, &arguments).spawn().expect("the peer starts"));
    interrupt(&stack);
    let said = Said::of(stack.wait_with_output().expect("the command ends"));
    let log = std::fs::read_to_string(folder.join("report/bridge.log")).expect("the bridge's log");
    println!("{seen}");

    assert_named(&seen, &log, "wrong_type", &["/odom", "another type", "geometry_msgs/PoseStamped"]);
    assert_named(
        &seen,
        &log,
        "wrong_qos",
        &["/detections", "quality of service does not fit", "best_effort"],
    );
    assert_named(&seen, &log, "rival", &["/cmd_vel", "somebody else commands the robot, too"]);
    assert_named(&seen, &log, "silent", &["/detections", "nothing arrives"]);
    // The others are heard all the while, so that these are warnings; a silent input is stale.
    assert_eq!(at(&seen, "/faults/wrong_type/level"), 1);
    assert_eq!(at(&seen, "/faults/silent/level"), 3);
    assert_eq!(at(&seen, "/faults/rival/level"), 2, "the robot obeys whoever spoke last");

    assert_diagnostics(&seen, &said);
    assert_state(&seen);
    assert_shapes(&seen);
    assert_listed(&seen);
}

fn assert_named(seen: &Value, log: &str, fault: &str, words: &[&str]) {
    let after_s = at(seen, &format!("/faults/{fault}/after_s")).as_f64();
    assert!(
        after_s.is_some_and(|s| s <= NAMED_WITHIN_S),
        "{fault} in /diagnostics after {after_s:?} s: {seen}"
    );
    let logged_s = logged_after_s(log, number(seen, &format!("/faults/{fault}/date_s")), words);
    println!("{fault}: in /diagnostics after {after_s:?} s, in the log after {logged_s:?} s");
    assert!(logged_s.is_some_and(|s| s <= NAMED_WITHIN_S), "{fault} in the log after {logged_s:?} s: {log}");
}

fn assert_diagnostics(seen: &Value, said: &Said) {
    assert_eq!(strings(at(seen, "/hardware")), ["cncbf"]);
    assert!(number(seen, "/arrays") >= number(seen, "/elapsed_s") - 3.0, "once a second at least: {seen}");
    assert!(number(seen, "/diagnostics_age_max_s") < 1.0, "stamped with the date");
    let status = |part: &str| at(seen, &format!("/statuses/{}", part.replace('/', "~1"))).clone();
    let value = |part: &str, key: &str| {
        let text = at(&status(part), &format!("/values/{key}")).as_str().expect("text").to_owned();
        text.parse::<f64>().unwrap_or_else(|_| panic!("{part} {key} is {text}"))
    };
    assert!(value("filter", "rate_hz") > 100.0, "{}", status("filter"));
    assert_eq!(at(&status("filter"), "/values/obstacles"), "2");
    assert_eq!(at(&status("command sink"), "/message"), "follows the filter");
    assert!(value("input /odom", "rate_hz") > 20.0, "{}", status("input /odom"));
    assert_eq!(at(&status("input /odom"), "/values/type"), "nav_msgs/Odometry");
    assert!(value("output /cmd_vel", "rate_hz") > 50.0, "{}", status("output /cmd_vel"));
    assert_eq!(at(&status("output /cmd_vel"), "/values/subscribers"), "1");
    for process in ["bridge", "estimator", "nominal", "filter"] {
        assert!(value(&format!("process {process}"), "cycles_hz") > 5.0, "{process}: {}", said.err);
    }
    let history = at(seen, "/history/filter").as_array().expect("what it said");
    let brakes = |entry: &Value| at(entry, "/1") == "braking: stale_detections" && at(entry, "/0") == 2;
    assert!(history.iter().any(brakes), "while nobody was seen the filter said so: {history:?}");
}

fn assert_state(seen: &Value) {
    let state = at(seen, "/state");
    assert_eq!((at(state, "/frame"), at(state, "/obstacle_count")), (&"odom".into(), &2.into()), "{state}");
    let rate_hz = number(seen, "/state_hz");
    assert!((20.0..=51.0).contains(&rate_hz), "50 Hz at most, and not much less: {rate_hz}");
    let h = number(state, "/h");
    assert!(h.is_finite() && h < number(state, "/sdf") + 1e-9, "h is never above the distance: {state}");
    assert_eq!(number(seen, "/counts/h"), number(seen, "/counts/sdf"));
    assert!(number(seen, "/counts/h") >= 0.9 * number(seen, "/counts/states"));
    let [control, nominal] =
        ["/control", "/nominal"].map(|key| [0, 1].map(|i| number(state, &format!("{key}/{i}"))));
    let moved = (control[0] - nominal[0]).hypot(control[1] - nominal[1]);
    assert!((moved - number(state, "/intervention")).abs() < 1e-9, "{state}");
    let off_m = (number(state, "/x") - number(seen, "/robot/0"))
        .hypot(number(state, "/y") - number(seen, "/robot/1"));
    assert!(off_m < 1.0, "the robot is where it is: {off_m} m off");
}

fn assert_shapes(seen: &Value) {
    let markers = at(seen, "/markers").as_array().expect("shapes");
    let people: Vec<_> = markers.iter().filter(|marker| at(marker, "/type") == MARKER_CYLINDER).collect();
    let places: Vec<_> =
        people.iter().filter(|marker| at(marker, "/ns") == "discs").map(|disc| at(disc, "/at")).collect();
    assert_eq!(places.len(), 2, "{markers:?}");
    for wanted in [[3.0, 2.5], [5.0, -2.5]] {
        let near =
            |at_m: &&Value| (number(at_m, "/0") - wanted[0]).hypot(number(at_m, "/1") - wanted[1]) < 0.2;
        assert!(places.iter().any(near), "somebody at {wanted:?}: {places:?}");
    }
    let curve = markers.iter().find(|marker| at(marker, "/type") == MARKER_LINE_LIST).expect("h = 0");
    assert_eq!((at(curve, "/ns"), at(curve, "/frame")), (&"h = 0".into(), &"odom".into()));
}

fn assert_listed(seen: &Value) {
    let publishers = strings(at(seen, "/publishers"));
    for topic in [
        "rt/cmd_vel geometry_msgs::msg::dds_::Twist_",
        "rt/diagnostics diagnostic_msgs::msg::dds_::DiagnosticArray_",
        "rt/robot/filter/filter_state cncbf_msgs::msg::dds_::FilterState_",
        "rt/robot/filter/h std_msgs::msg::dds_::Float64_",
        "rt/robot/filter/sdf std_msgs::msg::dds_::Float64_",
        "rt/robot/filter/markers visualization_msgs::msg::dds_::MarkerArray_",
    ] {
        assert!(publishers.contains(&topic), "{topic} is not among {publishers:?}");
    }
    let subscriptions = strings(at(seen, "/subscriptions"));
    for topic in [
        "rt/odom nav_msgs::msg::dds_::Odometry_",
        "rt/detections vision_msgs::msg::dds_::Detection3DArray_",
        "rt/goal_pose geometry_msgs::msg::dds_::PoseStamped_",
        "rt/tf tf2_msgs::msg::dds_::TFMessage_",
        "rt/tf_static tf2_msgs::msg::dds_::TFMessage_",
    ] {
        assert!(subscriptions.contains(&topic), "{topic} is not among {subscriptions:?}");
    }
}

/// Speeds commanded, m/s, in order.
fn speeds(seen: &Value) -> Vec<f64> {
    at(seen, "/commands").as_array().expect("commands").iter().map(|command| number(command, "/1")).collect()
}

#[test]
fn a_stack_that_is_told_to_end_leaves_a_standing_robot() {
    let Some(python) = python_or_say() else { return };
    for (offset, signal) in [(1, Signal::INT), (2, Signal::TERM)] {
        let (domain, folder, domain_id) = (ScopedDomain::new(), scratch("ros2_end"), domain_id(offset));
        let mut witness = Witness::join(&domain, "cncbf");
        let stack = stack(&domain, &folder, domain_id, &[]);
        let arguments = ["--far-goal", "--until", "silence", "--seconds", "60"];
        let peer = script(python, LISTENER, domain_id, &arguments).spawn().expect("the peer starts");
        witness.watch_until_it_drives(0);
        drop(witness);
        kill_process(Pid::from_child(&stack), signal).expect("a running stack");
        let said = Said::of(stack.wait_with_output().expect("the command ends"));
        let seen = finished(peer);
        let speeds = speeds(&seen);
        let last = at(&seen, "/commands").as_array().and_then(|all| all.last()).expect("commands");
        assert_eq!((number(last, "/1"), number(last, "/2")), (0.0, 0.0), "{signal:?}: {}", said.err);
        assert!(speeds.iter().any(|speed| *speed > 0.5), "it drove: {speeds:?}");
    }
}

/// The four processes, each on its own, so that nobody starts one again.
fn processes(domain: &Domain, folder: &Path, domain_id: u32) -> [Child; 4] {
    [&["filter"][..], &["estimator"], &["nominal"], &["bridge", "--source", "ros2"]].map(|arguments| {
        let mut command = cncbf(domain, folder);
        command.args(arguments).env("ROS_DOMAIN_ID", domain_id.to_string()).env("ROS_LOCALHOST_ONLY", "1");
        // Nobody reads what they say, and RustDDS has much to say.
        command.env("RUST_LOG", "off");
        command.spawn().expect("the command starts")
    })
}

#[test]
fn a_filter_that_is_killed_leaves_a_robot_that_brakes_to_a_halt() {
    let Some(python) = python_or_say() else { return };
    let (domain, folder, domain_id) = (ScopedDomain::new(), scratch("ros2_filter_killed"), domain_id(3));
    let mut witness = Witness::join(&domain, "cncbf");
    let [mut filter, others @ ..] = processes(&domain, &folder, domain_id);
    let arguments = ["--far-goal", "--until", "standstill", "--seconds", "60"];
    let peer = script(python, LISTENER, domain_id, &arguments).spawn().expect("the peer starts");
    witness.watch_until_it_drives(0);
    drop(witness);
    filter.kill().expect("a running filter");
    filter.wait().expect("it ends");
    let seen = finished(peer);
    for process in &others {
        kill_process(Pid::from_child(process), Signal::TERM).expect("a running process");
    }
    for process in others {
        let said = Said::of(process.wait_with_output().expect("it ends"));
        assert_eq!(said.code, 0, "{}", said.err);
    }
    let speeds = speeds(&seen);
    let fastest = speeds.iter().rposition(|speed| *speed > 0.5).expect("it drove");
    let braking = &speeds[fastest..];
    assert!(braking.is_sorted_by(|before, after| after <= before), "slower and slower: {braking:?}");
    assert_eq!(braking.last(), Some(&0.0));
    let sink = at(&seen, "/history/command sink").as_array().expect("what it said");
    let brakes = |entry: &Value| at(entry, "/1") == "brakes by itself: silent_filter" && at(entry, "/0") == 2;
    assert!(sink.iter().any(brakes), "{sink:?}");
}

#[test]
fn the_shipped_message_definition_is_the_one_that_is_spoken() {
    let shipped = include_str!("../bindings/ros2/cncbf_msgs/msg/FilterState.msg");
    let fields: Vec<_> = shipped.lines().filter(|line| !line.is_empty() && !line.starts_with('#')).collect();
    let spoken = FilterState::definition();
    let spoken: Vec<_> = spoken.lines().take_while(|line| !line.starts_with('=')).collect();
    assert_eq!(fields, spoken);
    assert_eq!(FilterState::NAME, "cncbf_msgs/FilterState");
}

/// What `cncbf doctor` says of domain `domain_id`.
fn doctor(folder: &Path, domain_id: &str, arguments: &[&str]) -> Said {
    let domain = ScopedDomain::new();
    let mut command = cncbf(&domain, folder);
    command.args(["doctor", "--seconds", "0.1"]).args(arguments);
    command.env("ROS_DOMAIN_ID", domain_id).env("ROS_LOCALHOST_ONLY", "1").env("RUST_LOG", "off");
    Said::by(command, &[])
}

#[test]
fn the_doctor_lists_peers_topics_and_clocks() {
    let Some(python) = python_or_say() else { return };
    let (folder, domain_id) = (scratch("ros2_doctor"), domain_id(4));
    let mut peer = script(python, LISTENER, domain_id, &["--seconds", "60"]);
    let mut peer = peer.spawn().expect("the peer starts");
    // It takes the peer a moment to import its types.
    let looked = (0..5).map(|_| doctor(&folder, &domain_id.to_string(), &["--json"]).json());
    let found = looked.into_iter().find(|found| count(found, "/ros2/participants") > 0);
    peer.kill().expect("a running peer");
    peer.wait().expect("it ends");
    let found = found.expect("a peer that is seen");
    let graph = at(&found, "/ros2");
    assert!(["jazzy", "humble"].contains(&at(graph, "/distribution").as_str().expect("text")), "{graph}");
    assert_eq!((at(graph, "/localhost_only"), at(graph, "/has_clock")), (&true.into(), &false.into()));
    assert!(number(graph, "/odometry_ahead_ms").abs() < 1_000.0, "both ends have one clock: {graph}");
    let topics = at(graph, "/topics").as_array().expect("topics");
    let of = |name: &str| topics.iter().find(|topic| topic["topic"] == name).expect(name);
    assert_eq!(at(of("/odom"), "/matched"), 1);
    assert_eq!(at(of("/odom"), "/quality"), "best_effort, volatile");
    assert_eq!(
        (at(of("/cmd_vel"), "/direction"), at(of("/cmd_vel"), "/matched")),
        (&"output".into(), &1.into())
    );
}

#[test]
fn the_doctor_says_so_where_nobody_is_or_the_environment_is_unusable() {
    let folder = scratch("ros2_doctor_alone");
    let alone = doctor(&folder, &(domain_id(5)).to_string(), &[]);
    assert!(alone.code < 2 && alone.out.contains("peers      none"), "{alone:?}");
    let refused = doctor(&folder, "233", &[]);
    assert!(
        refused.code < 2 && refused.out.contains("cannot be joined") && refused.out.contains("ROS_DOMAIN_ID")
    );
}

#[test]
fn a_run_that_hears_no_robot_names_the_topics_that_are_silent() {
    let (domain, folder) = (ScopedDomain::new(), scratch("ros2_unheard"));
    let config = settings(&folder, "geometry_msgs/PoseArray", "best_effort", "geometry_msgs/Twist");
    let mut run = cncbf(&domain, &folder);
    run.args(["run", "--source", "ros2", "--duration", "1", "--report", "report", "--config"]).arg(config);
    run.env("ROS_DOMAIN_ID", domain_id(6).to_string()).env("ROS_LOCALHOST_ONLY", "1").env("RUST_LOG", "off");
    let said = Said::by(run, &[]);
    assert_eq!(said.code, 2, "{said:?}");
    for expected in ["/odom, /detections, /goal_pose", "cncbf doctor", "report/bridge.log"] {
        assert!(said.err.contains(expected), "no `{expected}` in {}", said.err);
    }
}
