//! What becomes of recorded messages, good and bad.

use std::path::Path;

use super::*;
use recording::ros2::{
    Detection3D, Detection3DArray, Header, Odometry, Point, Pose, PoseArray, PoseStamped, Quaternion,
    TFMessage, Time, Transform, TransformStamped, Vector3,
};
use recording::{RecordedKind, RecordedMessage, WireMessage};

const S: u64 = 1_000_000_000;
const MS: u64 = 1_000_000;
/// When these recordings begin, ns.
const BEGIN_NS: u64 = 1_700_000_000 * S;

fn settings() -> Settings {
    let text = include_str!("../../../config/ground_robot.toml");
    Settings::parse(text, Path::new("ground_robot.toml"), Path::new(".")).expect("shipped settings")
}

fn header(frame: &str, time_ns: u64) -> Header {
    Header { stamp: Time::from_ns(time_ns), frame_id: frame.into() }
}

fn message(topic: &str, log_time_ns: u64, kind: RecordedKind) -> RecordedMessage {
    RecordedMessage { topic: topic.into(), log_time_ns, sequence: 0, kind }
}

fn pose(x: f64, y: f64, heading_rad: f64) -> Pose {
    Pose { position: Point { x, y, z: 0.0 }, orientation: Quaternion::from_heading(heading_rad) }
}

/// Odometry at `at_ns` after the beginning, logged 2 ms later.
fn odometry(frame: &str, at_ns: u64, x: f64) -> RecordedMessage {
    let mut odometry = Odometry {
        header: header(frame, BEGIN_NS + at_ns),
        child_frame_id: "base".into(),
        ..Odometry::default()
    };
    odometry.pose.pose = pose(x, 0.0, 0.0);
    odometry.twist.twist.linear.x = 1.0;
    message("/odom", BEGIN_NS + at_ns + 2 * MS, RecordedKind::Odometry(Box::new(odometry)))
}

/// People at these positions at `at_ns`, logged 30 ms later.
fn people(frame: &str, at_ns: u64, positions: &[[f64; 2]]) -> RecordedMessage {
    let detections = positions.iter().enumerate().map(|(index, [x, y])| {
        let mut person = Detection3D { id: (index + 1).to_string(), ..Detection3D::default() };
        person.bbox.center = pose(*x, *y, 0.0);
        person.bbox.size = Vector3 { x: 0.6, y: 0.6, z: 1.8 };
        person
    });
    let frame =
        Detection3DArray { header: header(frame, BEGIN_NS + at_ns), detections: detections.collect() };
    message("/detections", BEGIN_NS + at_ns + 30 * MS, RecordedKind::Detections(Box::new(frame)))
}

fn transform(topic: &str, parent: &str, child: &str, at_ns: u64, [x, y]: [f64; 2]) -> RecordedMessage {
    let transform =
        Transform { translation: Vector3 { x, y, z: 0.0 }, rotation: Quaternion::from_heading(0.0) };
    let header = header(parent, BEGIN_NS + at_ns);
    let transforms = vec![TransformStamped { header, child_frame_id: child.into(), transform }];
    message(topic, BEGIN_NS + at_ns, RecordedKind::Transforms(Box::new(TFMessage { transforms })))
}

fn decode(
    settings: &Settings,
    messages: &[RecordedMessage],
) -> Result<(Playlist, IntakeReport), SourceError> {
    load::decode_all(messages, Path::new("test.mcap"), settings, IntakeReport::default())
}

fn source(settings: &Settings, messages: &[RecordedMessage], closed_loop: bool) -> McapSource {
    let (playlist, report) = decode(settings, messages).expect("usable");
    McapSource::play(playlist, report, settings, closed_loop).expect("a robot that can stop")
}

fn events(source: &mut McapSource, step_ns: u64) -> Vec<BridgeEvent> {
    let mut events = Vec::new();
    let mut now_ns = 50 * S;
    while source.next_due_ns().is_some() {
        while let Some(event) = source.poll(now_ns) {
            events.push(event);
        }
        now_ns += step_ns;
    }
    events
}

#[test]
fn header_stamps_rule_and_delays_are_played_back() {
    let messages =
        [odometry("odom", 0, 0.0), people("odom", 0, &[[3.0, 0.0]]), odometry("odom", 100 * MS, 0.1)];
    let mut source = source(&settings(), &messages, false);
    let begin_ns = 50 * S;
    let Some(BridgeEvent::Goal(goal)) = source.poll(begin_ns) else { panic!("the goal is due at once") };
    assert_eq!(goal.position_in_odom_m, [12.0, 0.0], "the default, ahead of the first pose");
    assert_eq!(source.next_due_ns(), Some(begin_ns + 2 * MS));
    assert_eq!(source.poll(begin_ns + MS), None);
    let Some(BridgeEvent::RobotState(state)) = source.poll(begin_ns + 2 * MS) else {
        panic!("odometry is due")
    };
    assert_eq!(state.stamp.valid_at_ns, begin_ns);
    assert_eq!(state.stamp.ingress_ns, begin_ns + 2 * MS);
    assert_eq!(state.stamp.source_ns, BEGIN_NS);
    let Some(BridgeEvent::Detections(frame)) = source.poll(begin_ns + 31 * MS) else {
        panic!("people are due")
    };
    assert_eq!((frame.stamp.valid_at_ns, frame.stamp.ingress_ns), (begin_ns, begin_ns + 31 * MS));
    assert_eq!((frame.count, frame.items[0].track_id, frame.items[0].radius_m), (1, 1, 0.3));
    assert!(source.poll(begin_ns + 200 * MS).is_some());
    assert_eq!((source.poll(begin_ns + 200 * MS), source.next_due_ns()), (None, None));
    assert_eq!(source.status(begin_ns + 300 * MS).finished, 1);
}

#[test]
fn the_rhythm_of_polling_changes_nothing_but_the_ingress() {
    let messages: Vec<_> = (0..40)
        .flat_map(|step| {
            let at_ns = step * 50 * MS;
            [odometry("odom", at_ns, step as f64 * 0.05), people("odom", at_ns, &[[3.0, 0.1 * step as f64]])]
        })
        .collect();
    let mut sorted = messages;
    sorted.sort_by_key(|message| message.log_time_ns);
    for closed_loop in [false, true] {
        let of_rhythm = |step_ns| -> Vec<BridgeEvent> {
            let mut events = events(&mut source(&settings(), &sorted, closed_loop), step_ns);
            for event in &mut events {
                match event {
                    BridgeEvent::RobotState(message) => message.stamp.ingress_ns = 0,
                    BridgeEvent::Detections(message) => message.stamp.ingress_ns = 0,
                    BridgeEvent::Goal(message) => message.stamp.ingress_ns = 0,
                    BridgeEvent::NominalCommand(_) => panic!("a recording commands nobody"),
                }
            }
            events
        };
        assert!(of_rhythm(MS) == of_rhythm(17 * MS + 3));
        assert!(of_rhythm(MS) == of_rhythm(400 * MS));
    }
}

#[test]
fn people_seen_by_a_laser_on_the_driving_robot_stand_still_in_odom() {
    let mut messages = vec![transform("/tf_static", "base", "laser", 0, [0.5, 0.0])];
    for step in 0..10_u64 {
        let x = 0.1 * step as f64;
        messages.push(odometry("odom", step * 100 * MS, x));
        // Halfway between two poses, hence interpolated.
        messages.push(people("/laser", step * 100 * MS + 50 * MS, &[[4.0 - 0.5 - x - 0.05, 1.0]]));
    }
    let (playlist, report) = decode(&settings(), &messages[..messages.len() - 1]).expect("usable");
    assert_eq!((report.used, report.refused_total()), (20, 0));
    for person in &playlist.people {
        let [x, y] = person.position_in_odom_m;
        assert!((x - 4.0).abs() < 1e-9 && (y - 1.0).abs() < 1e-9, "{x} {y}");
    }
}

#[test]
fn an_unknown_frame_is_taken_for_odom_only_if_the_settings_say_so() {
    let messages = [odometry("map", 0, 0.0), people("map", 0, &[[3.0, 0.0]])];
    let mut settings = settings();
    assert!(decode(&settings, &messages).is_ok());
    settings.source.assume_odom_frame = false;
    let refused = decode(&settings, &messages).expect_err("no transform").to_string();
    assert!(refused.contains("no_transform") && refused.contains("assume_odom_frame"), "{refused}");
    // A connected frame whose transform is too old is never assumed to be odom.
    settings.source.assume_odom_frame = true;
    let messages = [
        odometry("odom", 0, 0.0),
        transform("/tf", "odom", "camera", 0, [1.0, 0.0]),
        people("camera", 100 * MS, &[[3.0, 0.0]]),
        people("camera", 2 * S, &[[3.0, 0.0]]),
    ];
    let (playlist, report) = decode(&settings, &messages).expect("usable");
    assert_eq!(playlist.people[0].position_in_odom_m, [4.0, 0.0]);
    assert_eq!(report.refused.get(&Reason::NoTransform), Some(&1));
}

#[test]
fn nothing_is_assumed_of_a_recording_with_transforms() {
    let static_elsewhere = transform("/tf_static", "base", "laser", 0, [0.5, 0.0]);
    let messages = [
        static_elsewhere,
        odometry("odom", 0, 0.0),
        people("camera", 0, &[[3.0, 0.0]]),
        people("odom", 50 * MS, &[[3.0, 0.0]]),
    ];
    let (playlist, report) = decode(&settings(), &messages).expect("usable");
    assert_eq!((playlist.people.len(), report.assumed_odom), (1, 0));
    assert_eq!(report.refused.get(&Reason::NoTransform), Some(&1), "camera is not known to be odom");

    let (playlist, report) = decode(&settings(), &messages[1..]).expect("usable");
    assert_eq!((playlist.people.len(), report.assumed_odom), (2, 1), "without any transform it is assumed");
}

#[test]
fn a_frame_seen_once_under_another_parent_keeps_its_place() {
    let messages = [
        odometry("odom", 0, 0.0),
        transform("/tf", "odom", "laser", 0, [1.0, 0.0]),
        transform("/tf", "map", "laser", 10 * MS, [7.0, 0.0]),
        transform("/tf_static", "odom", "laser", 20 * MS, [8.0, 0.0]),
        people("laser", 20 * MS, &[[3.0, 0.0]]),
    ];
    let (playlist, report) = decode(&settings(), &messages).expect("usable");
    assert_eq!(playlist.people[0].position_in_odom_m, [4.0, 0.0]);
    assert_eq!(report.refused_transforms.get(&Reason::MalformedInput), Some(&2));
}

#[test]
fn bad_messages_are_counted_and_the_good_ones_pass() {
    let mut no_orientation = odometry("odom", 100 * MS, 0.0);
    if let RecordedKind::Odometry(odometry) = &mut no_orientation.kind {
        odometry.pose.pose.orientation = Quaternion::default();
    }
    let mut infinite = odometry("odom", 110 * MS, 0.0);
    if let RecordedKind::Odometry(odometry) = &mut infinite.kind {
        odometry.twist.twist.linear.x = f64::INFINITY;
    }
    let mut unstamped = odometry("odom", 400 * MS, 0.4);
    if let RecordedKind::Odometry(odometry) = &mut unstamped.kind {
        odometry.header.stamp = Time::default();
    }
    let messages = [
        odometry("odom", 0, 0.0),
        no_orientation,
        infinite,
        people("odom", 150 * MS, &[[f64::NAN, 0.0], [2.0, 0.0]]),
        odometry("odom", 200 * MS, 0.2),
        odometry("odom", 190 * MS, 0.19),
        unstamped,
        people("odom", 140 * MS, &[[2.0, 0.0]]),
        odometry("odom", 500 * MS, 0.5),
    ];
    let (playlist, report) = decode(&settings(), &messages).expect("usable");
    assert_eq!(playlist.states.len(), 4);
    assert_eq!((playlist.people.len(), report.refused_detections), (1, 1));
    assert_eq!(report.refused.get(&Reason::MalformedInput), Some(&1));
    assert_eq!(report.refused.get(&Reason::NonFiniteRobotState), Some(&1));
    assert_eq!(report.refused.get(&Reason::BackwardStamp), Some(&2));
    assert_eq!(report.restamped, 1);
    assert_eq!(report.used + report.refused_total(), messages.len() as u64);
}

#[test]
fn a_stamp_ahead_of_its_log_time_locks_nothing_out() {
    let mut ahead = odometry("odom", 100 * MS, 0.1);
    if let RecordedKind::Odometry(odometry) = &mut ahead.kind {
        odometry.header.stamp = Time::from_ns(BEGIN_NS + 5 * S);
    }
    let mut messages = vec![odometry("odom", 0, 0.0), people("odom", 0, &[[3.0, 0.0]]), ahead];
    messages.extend((2..20).map(|step| odometry("odom", step * 100 * MS, 0.0)));
    let (playlist, report) = decode(&settings(), &messages).expect("usable");
    assert_eq!((playlist.states.len(), report.refused_total(), report.restamped), (20, 0, 1));
    assert_eq!(playlist.entries[2].valid_ns, 102 * MS, "the log time");
}

/// A robot state as this stack records it: logged when published.
fn wire_state(log_time_ns: u64, published_ns: u64, valid_at_ns: u64) -> RecordedMessage {
    let stamp = Stamp { published_ns, valid_at_ns, ..Stamp::zeroed() };
    let state = RobotState { stamp, ..RobotState::zeroed() };
    let kind = RecordedKind::Wire(Box::new(WireMessage::RobotState(state)));
    message("/cncbf/wire/robot_state", log_time_ns, kind)
}

#[test]
fn absurd_stamps_of_wire_messages_are_refused_and_lock_nothing_out() {
    let messages = [
        people("odom", 0, &[[3.0, 0.0]]),
        wire_state(BEGIN_NS + 40 * MS, BEGIN_NS + 40 * MS, BEGIN_NS + 35 * MS),
        wire_state(BEGIN_NS + 50 * MS, BEGIN_NS + 50 * MS, u64::MAX),
        wire_state(BEGIN_NS + 60 * MS, u64::MAX, BEGIN_NS + 55 * MS),
        wire_state(BEGIN_NS + 70 * MS, BEGIN_NS + 70 * MS, BEGIN_NS + 5 * S),
        wire_state(BEGIN_NS + 80 * MS, 1, 1),
        wire_state(BEGIN_NS + 90 * MS, 0, 0),
    ];
    let (playlist, report) = decode(&settings(), &messages).expect("usable");
    assert_eq!((playlist.states.len(), report.restamped), (2, 1));
    assert_eq!(report.refused.get(&Reason::FutureStamp), Some(&3));
    assert_eq!(report.refused.get(&Reason::MalformedInput), Some(&1), "too old");
    assert_eq!(playlist.length_ns, 90 * MS);
    events(&mut source(&settings(), &messages, false), 10 * MS);
}

#[test]
fn log_times_at_the_ends_of_the_clock_are_played_without_overflow() {
    let mut frame = people("odom", 0, &[[3.0, 0.0]]);
    frame.log_time_ns = u64::MAX;
    let messages = [wire_state(1, 1, 1), frame];
    let mut source = source(&settings(), &messages, false);
    while source.poll(50 * S).is_some() {}
    // Spares the repetitions of the goal in between.
    source.next_goal_ns = u64::MAX;
    assert_eq!(source.next_due_ns(), Some(u64::MAX));
    let Some(BridgeEvent::Detections(frame)) = source.poll(u64::MAX) else { panic!("the frame is due") };
    assert_eq!(frame.stamp.valid_at_ns, u64::MAX);
    assert_eq!(source.status(u64::MAX).finished, 1);
}

#[test]
fn of_a_thousand_people_the_nearest_are_kept_and_the_others_counted() {
    let crowd: Vec<[f64; 2]> =
        (0..1000).map(|index| [f64::from(index * 7 % 1000) * 0.1 + 1.0, 0.0]).collect();
    for (count, left_out) in [(64, 0), (65, 1), (1000, 936)] {
        let messages = [odometry("odom", 0, 0.0), people("odom", 0, &crowd[..count])];
        let found = events(&mut source(&settings(), &messages, false), 10 * MS);
        let frame = found.iter().find_map(|event| match event {
            BridgeEvent::Detections(frame) => Some(frame),
            BridgeEvent::RobotState(_) | BridgeEvent::Goal(_) | BridgeEvent::NominalCommand(_) => None,
        });
        let frame = frame.expect("a frame");
        assert_eq!((frame.count, frame.left_out), (64, left_out));
        let kept: Vec<_> = frame.as_slice().iter().map(|person| person.position_in_odom_m[0]).collect();
        let mut nearest: Vec<_> = crowd[..count].iter().map(|[x, _]| *x).collect();
        nearest.sort_by(f64::total_cmp);
        assert_eq!(kept, nearest[..64]);
    }
}

#[test]
fn poses_are_anonymous_and_a_recorded_goal_is_driven_to() {
    let poses = PoseArray { header: header("odom", BEGIN_NS), poses: vec![pose(3.0, 1.0, 0.0)] };
    let goal = PoseStamped { header: header("odom", 0), pose: pose(0.2, 0.0, 1.0) };
    let messages = [
        odometry("odom", 0, 0.0),
        message("/people", BEGIN_NS + 3 * MS, RecordedKind::Poses(Box::new(poses))),
        message("/goal_pose", BEGIN_NS + 4 * MS, RecordedKind::Pose(Box::new(goal))),
        odometry("odom", 100 * MS, 0.1),
    ];
    let mut source = source(&settings(), &messages, false);
    let found = events(&mut source, MS);
    assert!(found.iter().any(|event| matches!(event, BridgeEvent::Detections(frame)
        if frame.items[0].track_id == 0 && frame.items[0].radius_m == 0.35)));
    let goals = found.iter().filter_map(|event| match event {
        BridgeEvent::Goal(goal) => Some((goal.position_in_odom_m, goal.heading_rad)),
        BridgeEvent::RobotState(_) | BridgeEvent::Detections(_) | BridgeEvent::NominalCommand(_) => None,
    });
    assert!(
        goals.into_iter().all(|(position, heading)| position == [0.2, 0.0] && (heading - 1.0).abs() < 1e-12)
    );
    assert_eq!(source.status(60 * S).goal_reached, 1);
}

#[test]
fn a_goal_said_again_stays_reached_and_another_one_does_not() {
    let goal = |at_ns: u64, x: f64| {
        let goal = PoseStamped { header: header("odom", BEGIN_NS + at_ns), pose: pose(x, 0.0, 0.0) };
        message("/goal_pose", BEGIN_NS + at_ns, RecordedKind::Pose(Box::new(goal)))
    };
    let reached = |last_x: f64| {
        let messages = [
            people("odom", 0, &[[3.0, 0.0]]),
            goal(0, 0.2),
            odometry("odom", 100 * MS, 0.1),
            goal(200 * MS, last_x),
        ];
        let mut source = source(&settings(), &messages, false);
        events(&mut source, MS);
        source.status(60 * S).goal_reached
    };
    assert_eq!((reached(0.2), reached(5.0)), (1, 0));
}

#[test]
fn in_a_closed_loop_the_robot_obeys_and_runs_into_those_who_stand_in_its_way() {
    let standing: Vec<_> = (0..60)
        .flat_map(|step| {
            [
                odometry("odom", step * 100 * MS, 9.0),
                people("odom", step * 100 * MS, &[[10.0, 0.0], [9.5, 3.0]]),
            ]
        })
        .collect();
    let mut sorted = standing;
    sorted.sort_by_key(|message| message.log_time_ns);
    let mut command = SafeCommand {
        control: [0.5, 0.0],
        control_kind: messages::ControlKind::Unicycle.code(),
        ..SafeCommand::zeroed()
    };
    let mut source = source(&settings(), &sorted, true);
    let mut states = Vec::new();
    for tick in 0..500_u64 {
        let now_ns = 50 * S + tick * 4 * MS;
        while let Some(event) = source.poll(now_ns) {
            if let BridgeEvent::RobotState(state) = event {
                states.push(state);
            }
        }
        command.ledger.filter_woke_ns = now_ns;
        source.command(&command, now_ns);
    }
    let last = states.last().expect("states");
    assert!(states.len().abs_diff(200) <= 1, "every 10 ms, not the recorded 100 ms: {}", states.len());
    assert!((last.position_in_odom_m[0] - (9.0 + 0.5 * 1.99)).abs() < 0.02, "{last:?}");
    let status = source.status(52 * S);
    // Discs of 0.35 m and 0.3 m meet 0.65 m before the first person's centre.
    assert_eq!(status.collisions, 1);
    assert!(status.min_clearance_m < 0.0 && (status.path_length_m - 0.99).abs() < 0.02, "{status:?}");
    assert_eq!(source.report().replaced, 60);

    // The filter dies: after five periods the robot brakes by itself and stands.
    for tick in 0..200_u64 {
        while let Some(event) = source.poll(52 * S + tick * 10 * MS) {
            if let BridgeEvent::RobotState(state) = event {
                states.push(state);
            }
        }
    }
    assert_eq!(source.sink_state(), Some(SinkState::Braking(Reason::SilentFilter)));
    assert_eq!(states.last().map(|state| state.velocity_in_base_mps), Some([0.0, 0.0]));
}

#[test]
fn clearance_between_frames_is_that_of_people_who_walk_on() {
    // A person crosses from y = 1 to y = -1 between two frames, straight through the standing robot.
    let messages = [
        odometry("odom", 0, 0.0),
        people("odom", 0, &[[0.0, 1.0]]),
        odometry("odom", 200 * MS, 0.0),
        people("odom", 400 * MS, &[[0.0, -1.0]]),
        odometry("odom", 500 * MS, 0.0),
    ];
    let mut sorted = messages.to_vec();
    sorted.sort_by_key(|message| message.log_time_ns);
    let mut source = source(&settings(), &sorted, false);
    events(&mut source, MS);
    let status = source.status(60 * S);
    assert!((status.min_clearance_m + 0.65).abs() < 1e-9, "{status:?}");
    assert_eq!(status.collisions, 1);
}

/// Ten robot states and ten frames in one second.
fn one_second() -> Vec<RecordedMessage> {
    let mut messages: Vec<_> = (0..10)
        .flat_map(|step| {
            let at_ns = step * 100 * MS;
            [odometry("odom", at_ns, step as f64 * 0.05), people("odom", at_ns, &[[3.0, 0.1 * step as f64]])]
        })
        .collect();
    messages.sort_by_key(|message| message.log_time_ns);
    messages
}

/// Plays [`one_second`] and returns what came, without the goals, each with its time of validity since the beginning, ns.
fn played(rate: f64, passes: u32) -> (McapSource, Vec<(u64, BridgeEvent)>) {
    let playback = Playback::new(rate, passes).expect("a useful rate");
    let mut source = source(&settings(), &one_second(), false).played(playback).expect("a short recording");
    let mut found = events(&mut source, MS);
    found.retain(|event| !matches!(event, BridgeEvent::Goal(_)));
    let valid_ns = |event: &BridgeEvent| match event {
        BridgeEvent::RobotState(message) => message.stamp.valid_at_ns - 50 * S,
        BridgeEvent::Detections(message) => message.stamp.valid_at_ns - 50 * S,
        BridgeEvent::Goal(message) => message.stamp.valid_at_ns - 50 * S,
        BridgeEvent::NominalCommand(_) => panic!("a recording commands nobody"),
    };
    (source, found.into_iter().map(|event| (valid_ns(&event), event)).collect())
}

#[test]
fn a_rate_compresses_every_time_and_loses_no_message() {
    let (slow, as_recorded) = played(1.0, 1);
    let (fast, hurried) = played(4.0, 1);
    assert_eq!((as_recorded.len(), hurried.len()), (20, 20));
    assert_eq!(fast.length_ns(), slow.length_ns() / 4);
    for ((slow_ns, _), (fast_ns, _)) in as_recorded.iter().zip(&hurried) {
        assert_eq!(slow_ns / 4, *fast_ns);
    }
    // What is measured stays as it was recorded, the robot's velocity included.
    for (_, event) in &hurried {
        if let BridgeEvent::RobotState(state) = event {
            assert_eq!(state.velocity_in_base_mps, [1.0, 0.0]);
        }
    }
}

#[test]
fn passes_follow_each_other_as_one_recording() {
    let (once, first) = played(2.0, 1);
    let (thrice, found) = played(2.0, 3);
    assert_eq!(found.len(), 3 * first.len());
    assert!(found.is_sorted_by_key(|(valid_ns, _)| *valid_ns));
    assert!(thrice.length_ns() > 3 * once.length_ns());
    assert_eq!(thrice.status(60 * S).finished, 1);
    assert_eq!(once.counts(), PlaybackCounts { robot_states: 10, frames: 10, people: 10 });
    assert_eq!(thrice.counts(), PlaybackCounts { robot_states: 30, frames: 30, people: 30 });
    let sequences = found.iter().filter_map(|(_, event)| match event {
        BridgeEvent::Detections(frame) => Some((frame.stamp.sequence, frame.stamp.source_ns)),
        BridgeEvent::RobotState(_) | BridgeEvent::Goal(_) | BridgeEvent::NominalCommand(_) => None,
    });
    let (counted, sensor_ns): (Vec<u64>, Vec<u64>) = sequences.unzip();
    assert_eq!(counted, (1..=30).collect::<Vec<_>>());
    assert!(sensor_ns.is_sorted(), "the sensor's clock runs on");
    // The same place again, one pass later.
    let of_pass = |pass: usize| &found[pass * first.len()..][..first.len()];
    for ((_, before), (_, after)) in of_pass(0).iter().zip(of_pass(2)) {
        match (before, after) {
            (BridgeEvent::RobotState(before), BridgeEvent::RobotState(after)) => {
                assert_eq!(before.position_in_odom_m, after.position_in_odom_m);
            }
            (BridgeEvent::Detections(before), BridgeEvent::Detections(after)) => {
                assert_eq!(before.items[0], after.items[0]);
            }
            pair => panic!("another order in another pass: {pair:?}"),
        }
    }
}

#[test]
fn passes_that_fit_no_memory_are_refused() {
    let playback = Playback::new(1.0, u32::MAX).expect("any number of passes");
    let refused = source(&settings(), &one_second(), false).played(playback).err().expect("too long");
    assert!(refused.to_string().contains("shorter time"), "{refused}");
}
