//! What a live graph may send, and what becomes of it.

use std::path::Path;

use messages::DetectionFlags;
use recording::ros2::{
    Detection3D, Detection3DArray, Pose, PoseArray, Quaternion, Time, TrackedObject, TrackedObjects,
    Transform, Vector3,
};

use super::*;

const MS: u64 = 1_000_000;
const S: u64 = 1_000 * MS;
/// The date when the stack clock showed zero.
const EPOCH_NS: u64 = 1_700_000_000 * S;

fn intake() -> Intake {
    let text = include_str!("../../../../config/ground_robot.toml");
    Intake::new(&Settings::parse(text, Path::new("shipped"), Path::new(".")).expect("shipped settings"))
}

fn at(stack_ns: u64) -> Arrival {
    Arrival { stack_ns, wall_ns: EPOCH_NS + stack_ns }
}

fn header(frame: &str, stack_ns: u64) -> Header {
    Header { stamp: Time::from_ns(EPOCH_NS + stack_ns), frame_id: frame.to_owned() }
}

fn odometry(stack_ns: u64, x: f64) -> Odometry {
    let mut message = Odometry { header: header("odom", stack_ns), ..Odometry::default() };
    message.child_frame_id = "base_link".to_owned();
    message.pose.pose.position.x = x;
    message.pose.pose.orientation = Quaternion::from_heading(0.0);
    message.twist.twist.linear.x = 0.5;
    message
}

fn boxes(frame: &str, stack_ns: u64, places: &[[f64; 2]]) -> Detection3DArray {
    let detections = places.iter().map(|[x, y]| {
        let mut detection = Detection3D::default();
        (detection.bbox.center.position.x, detection.bbox.center.position.y) = (*x, *y);
        detection.bbox.size = Vector3 { x: 0.6, y: 0.6, z: 1.8 };
        detection
    });
    Detection3DArray { header: header(frame, stack_ns), detections: detections.collect() }
}

fn transform(parent: &str, child: &str, stack_ns: u64, x: f64) -> TFMessage {
    let transform = Transform {
        translation: Vector3 { x, ..Vector3::default() },
        rotation: Quaternion::from_heading(0.0),
    };
    let header = header(parent, stack_ns);
    TFMessage { transforms: vec![TransformStamped { header, child_frame_id: child.to_owned(), transform }] }
}

fn people(event: Result<BridgeEvent, Reason>) -> Detections {
    match event {
        Ok(BridgeEvent::Detections(frame)) => frame,
        other => panic!("no detections but {other:?}"),
    }
}

#[test]
fn a_robot_state_keeps_its_age_and_its_stamp() {
    let mut intake = intake();
    let event = intake.odometry(&odometry(1_000 * MS, 2.0), at(1_015 * MS));
    let Ok(BridgeEvent::RobotState(state)) = event else { panic!("{event:?}") };
    assert_eq!(state.position_in_odom_m, [2.0, 0.0]);
    let Stamp { sequence, source_ns, valid_at_ns, ingress_ns, published_ns } = state.stamp;
    assert_eq!((sequence, published_ns), (1, 0));
    assert_eq!((source_ns, valid_at_ns, ingress_ns), (EPOCH_NS + 1_000 * MS, 1_000 * MS, 1_015 * MS));
}

#[test]
fn future_backward_and_foreign_stamps_are_refused_and_cost_nothing_later() {
    let mut intake = intake();
    assert!(intake.odometry(&odometry(1_000 * MS, 0.0), at(1_001 * MS)).is_ok());
    let refusal = |intake: &mut Intake, stamped_ns, arrived_ns| {
        intake.odometry(&odometry(stamped_ns, 0.0), at(arrived_ns)).err()
    };
    assert_eq!(refusal(&mut intake, 1_400 * MS, 1_020 * MS), Some(Reason::FutureStamp));
    assert_eq!(refusal(&mut intake, 980 * MS, 1_021 * MS), Some(Reason::BackwardStamp));
    let mut simulated = odometry(0, 0.0);
    simulated.header.stamp = Time::from_ns(77 * S);
    assert_eq!(intake.odometry(&simulated, at(1_022 * MS)).err(), Some(Reason::ForeignClock));
    assert_eq!(refusal(&mut intake, 1_040 * MS, 1_041 * MS), None);
    // The date jumps back by an hour, for publisher and stack alike: one message is refused, then the new date holds.
    let hour_ns = 3_600 * S;
    let mut later = odometry(1_060 * MS, 0.0);
    later.header.stamp = Time::from_ns(EPOCH_NS + 1_060 * MS - hour_ns);
    let jumped = Arrival { stack_ns: 1_061 * MS, wall_ns: EPOCH_NS + 1_061 * MS - hour_ns };
    assert_eq!(intake.odometry(&later, jumped).err(), Some(Reason::ClockJump));
    let event = intake.odometry(&later, jumped);
    assert!(matches!(event, Ok(BridgeEvent::RobotState(state)) if state.stamp.valid_at_ns == 1_060 * MS));
    // One that was under way meanwhile bears the old date.
    assert_eq!(intake.odometry(&odometry(1_062 * MS, 0.0), jumped).err(), Some(Reason::FutureStamp));
}

#[test]
fn obstacles_need_a_frame_that_leads_to_odom_whatever_the_settings_assume_of_recordings() {
    let mut intake = intake();
    let frame = boxes("laser", 1_000 * MS, &[[2.0, 0.0]]);
    assert_eq!(intake.obstacles(&frame, at(1_001 * MS)).err(), Some(Reason::NoTransform));
    let laser = transform("base_link", "laser", 0, 0.5);
    assert_eq!(intake.transforms(&laser, true, at(1_002 * MS)), Ok(()));
    assert_eq!(intake.obstacles(&frame, at(1_003 * MS)).err(), Some(Reason::NoTransform));
    intake.odometry(&odometry(1_000 * MS, 10.0), at(1_004 * MS)).expect("sound");
    let found = people(intake.obstacles(&frame, at(1_005 * MS)));
    assert_eq!(found.as_slice()[0].position_in_odom_m, [12.5, 0.0]);
    // Where the robot is was last said too long ago.
    let late = boxes("laser", 1_600 * MS, &[[2.0, 0.0]]);
    assert_eq!(intake.obstacles(&late, at(1_601 * MS)).err(), Some(Reason::NoTransform));
    let in_odom = boxes("odom", 1_600 * MS, &[[2.0, 0.0]]);
    assert_eq!(people(intake.obstacles(&in_odom, at(1_602 * MS))).count, 1, "needs no transform");
}

#[test]
fn where_tf_places_the_robot_odometry_does_not() {
    let mut intake = intake();
    intake.odometry(&odometry(1_000 * MS, 10.0), at(1_000 * MS)).expect("sound");
    // As robots with a footprint frame say it: another parent than odometry's.
    for (parent, child, x) in [("odom", "base_footprint", 20.0), ("base_footprint", "base_link", 0.0)] {
        assert_eq!(
            intake.transforms(&transform(parent, child, 1_010 * MS, x), false, at(1_011 * MS)),
            Ok(())
        );
    }
    intake.odometry(&odometry(1_020 * MS, 11.0), at(1_020 * MS)).expect("sound");
    let found = people(intake.obstacles(&boxes("base_link", 1_020 * MS, &[[1.0, 0.0]]), at(1_021 * MS)));
    assert_eq!(found.as_slice()[0].position_in_odom_m, [21.0, 0.0]);
}

#[test]
fn a_crowd_beyond_capacity_keeps_the_nearest_and_unsound_ones_do_not_cost_the_others() {
    let mut intake = intake();
    intake.odometry(&odometry(1_000 * MS, 100.0), at(1_000 * MS)).expect("sound");
    let mut places: Vec<_> = (0..400).map(|index| [f64::from(index), 0.0]).collect();
    places[7][0] = f64::NAN;
    let frame = people(intake.obstacles(&boxes("odom", 1_000 * MS, &places), at(1_001 * MS)));
    assert_eq!((frame.count as usize, frame.left_out as usize), (MAX_OBSTACLES, 399 - MAX_OBSTACLES));
    assert_eq!(frame.as_slice()[0].position_in_odom_m, [100.0, 0.0]);
    assert_eq!(intake.refused_detections(), 1);
}

#[test]
fn positions_and_tracks_are_obstacles_too() {
    let mut intake = intake();
    let pose = Pose { orientation: Quaternion::from_heading(0.0), ..Pose::default() };
    let poses = PoseArray { header: header("odom", 1_000 * MS), poses: vec![pose; 3] };
    assert_eq!(people(intake.obstacles(&poses, at(1_000 * MS))).count, 3);
    let mut object = TrackedObject::default();
    object.kinematics.is_stationary = true;
    let tracks = TrackedObjects { header: header("odom", 1_050 * MS), objects: vec![object] };
    let frame = people(intake.obstacles(&tracks, at(1_051 * MS)));
    assert_eq!(frame.as_slice()[0].flags, DetectionFlags::HAS_VELOCITY);
    assert_eq!(frame.stamp.sequence, 2);
}

#[test]
fn a_goal_holds_from_its_arrival_on() {
    let mut intake = intake();
    let pose = Pose { orientation: Quaternion::from_heading(1.0), ..Pose::default() };
    let mut goal = PoseStamped { header: header("map", 0), pose };
    assert_eq!(intake.goal(&goal, at(60 * S)).err(), Some(Reason::NoTransform));
    intake.transforms(&transform("map", "odom", 60 * S, 5.0), false, at(60 * S)).expect("sound");
    let event = intake.goal(&goal, at(60 * S + MS));
    let Ok(BridgeEvent::Goal(found)) = event else { panic!("{event:?}") };
    assert_eq!((found.position_in_odom_m, found.stamp.valid_at_ns), ([-5.0, 0.0], 60 * S + MS));
    goal.pose.orientation = Quaternion::default();
    assert_eq!(intake.goal(&goal, at(61 * S)).err(), Some(Reason::NoTransform), "/tf fell silent");
    goal.header.frame_id = "odom".to_owned();
    assert_eq!(intake.goal(&goal, at(61 * S)).err(), Some(Reason::MalformedInput), "no orientation");
}

fn clock(sim_ns: u64) -> Clock {
    Clock { clock: Time::from_ns(sim_ns) }
}

/// An intake whose place in the graph `change` has changed.
fn intake_with(change: impl FnOnce(&mut Ros2Settings)) -> Intake {
    let text = include_str!("../../../../config/ground_robot.toml");
    let settings = Settings::parse(text, Path::new("shipped"), Path::new("."));
    let mut settings = settings.expect("shipped settings");
    let mut ros2 = Ros2Settings::customary();
    change(&mut ros2);
    settings.source.ros2 = Some(ros2);
    Intake::new(&settings)
}

fn simulated(sim_ns: u64, x: f64) -> Odometry {
    let mut message = odometry(0, x);
    message.header.stamp = Time::from_ns(sim_ns);
    message
}

#[test]
fn a_simulation_that_begins_anew_is_followed_into_its_new_time() {
    let mut intake = intake_with(|ros2| ros2.use_sim_time = Some(true));
    assert_eq!(intake.odometry(&simulated(5 * S, 0.0), at(50 * S)).err(), Some(Reason::ForeignClock));
    intake.transforms(&transform("base_link", "laser", 0, 0.5), true, at(50 * S)).expect("static");
    assert_eq!(intake.clock(&clock(5 * S), at(50 * S)), Ok(()));
    let event = intake.odometry(&simulated(5 * S - 20 * MS, 3.0), at(50 * S));
    assert!(
        matches!(event, Ok(BridgeEvent::RobotState(state)) if state.stamp.valid_at_ns == 50 * S - 20 * MS)
    );
    assert_eq!(intake.odometry(&odometry(50 * S, 3.0), at(50 * S)).err(), Some(Reason::ForeignClock));
    assert!(intake.upstream(&Twist::default(), None, at(50 * S)).is_ok());
    // Reset: what was known of moving frames and of the robot is of another time.
    assert_eq!(intake.clock(&clock(S / 10), at(50 * S + 30 * MS)), Err(Reason::ClockJump));
    let mut frame = boxes("laser", 0, &[[2.0, 0.0]]);
    frame.header.stamp = Time::from_ns(S / 10);
    assert_eq!(intake.obstacles(&frame, at(50 * S + 31 * MS)).err(), Some(Reason::NoTransform));
    let answer = intake.upstream(&Twist::default(), None, at(50 * S + 31 * MS));
    assert_eq!(answer.err(), Some(Reason::NoRobotState));
    assert_eq!(
        intake.odometry(&simulated(5 * S, 3.0), at(50 * S + 32 * MS)).err(),
        Some(Reason::FutureStamp)
    );
    assert!(intake.odometry(&simulated(S / 10, 0.0), at(50 * S + 33 * MS)).is_ok());
    let found = people(intake.obstacles(&frame, at(50 * S + 34 * MS)));
    assert_eq!(found.as_slice()[0].position_in_odom_m, [2.5, 0.0]);
}

#[test]
fn an_upstream_command_answers_the_newest_robot_state() {
    let mut intake = intake_with(|ros2| ros2.nominal_topic = Some("cmd_vel_smoothed".to_owned()));
    let mut twist = Twist::default();
    (twist.linear.x, twist.linear.y, twist.angular.z) = (0.4, 9.0, -0.2);
    assert_eq!(intake.upstream(&twist, None, at(999 * MS)).err(), Some(Reason::NoRobotState));
    let Ok(BridgeEvent::RobotState(state)) = intake.odometry(&odometry(1_000 * MS, 2.0), at(1_002 * MS))
    else {
        panic!("refused")
    };
    let Ok(BridgeEvent::NominalCommand(command)) = intake.upstream(&twist, None, at(1_010 * MS)) else {
        panic!("refused")
    };
    assert_eq!(command.stamp, Stamp { sequence: 1, ..state.stamp });
    assert_eq!((command.control, command.received_ns), ([0.4, -0.2], 1_010 * MS));
    let codes = (command.control_kind, command.intent, command.controller);
    assert_eq!(codes, (ControlKind::Unicycle.code(), Intent::Drive.code(), Controller::Upstream.code()));
    for slow_mps in [0.0, 0.2, -0.4] {
        twist.linear.x = slow_mps;
        let event = intake.upstream(&twist, None, at(1_010 * MS));
        let stops = |command: &NominalCommand| command.intent == Intent::Stop.code();
        assert!(matches!(&event, Ok(BridgeEvent::NominalCommand(command)) if stops(command)), "{event:?}");
    }
    // With stamps, age and order count.
    let old = header("base_link", 1_000 * MS);
    assert!(intake.upstream(&twist, Some(&old), at(1_080 * MS)).is_err(), "older than one without a stamp");
    let late = header("base_link", 1_011 * MS);
    assert_eq!(intake.upstream(&twist, Some(&late), at(1_200 * MS)).err(), Some(Reason::StaleNominalCommand));
    let fresh = header("base_link", 1_190 * MS);
    assert!(intake.upstream(&twist, Some(&fresh), at(1_200 * MS)).is_ok());
    twist.angular.z = f64::NAN;
    let refused = intake.upstream(&twist, None, at(1_210 * MS)).err();
    assert_eq!(refused, Some(Reason::NonFiniteNominalCommand));
}

#[test]
fn zeros_mean_to_stop_for_every_robot() {
    let text = include_str!("../../../../config/ground_robot.toml");
    let settings = Settings::parse(text, Path::new("shipped"), Path::new("."));
    let mut settings = settings.expect("shipped settings");
    settings.robot.control_min[0] = -0.5;
    let mut intake = Intake::new(&settings);
    intake.odometry(&odometry(S, 2.0), at(S)).expect("sound");
    let mut intent = |speed_mps: f64, yaw_rate_radps: f64| {
        let mut twist = Twist::default();
        (twist.linear.x, twist.angular.z) = (speed_mps, yaw_rate_radps);
        match intake.upstream(&twist, None, at(S)) {
            Ok(BridgeEvent::NominalCommand(command)) => command.intent,
            other => panic!("no command but {other:?}"),
        }
    };
    assert_eq!((intent(0.0, 0.0), intent(-0.0, 0.0)), (Intent::Stop.code(), Intent::Stop.code()));
    for (speed_mps, yaw_rate_radps) in [(0.0, 0.3), (-0.2, 0.0), (0.1, 0.0)] {
        assert_eq!(intent(speed_mps, yaw_rate_radps), Intent::Drive.code());
    }
}

#[test]
fn a_velocity_in_a_frame_in_which_the_robot_moves_is_refused() {
    let mut intake = intake();
    intake.transforms(&transform("base_link", "plate", 0, 0.1), true, at(S)).expect("static");
    intake.transforms(&transform("map", "odom", S, 0.0), false, at(S)).expect("sound");
    intake.odometry(&odometry(S, 2.0), at(S)).expect("sound");
    let twist = Twist { linear: Vector3 { x: 0.5, ..Vector3::default() }, ..Twist::default() };
    let mut refusal = |frame: &str| intake.upstream(&twist, Some(&header(frame, S)), at(S)).err();
    for inside in ["", "base_link", "/base_link", "plate", "never_heard_of"] {
        assert_eq!(refusal(inside), None, "{inside}");
    }
    for outside in ["odom", "/odom", "map"] {
        assert_eq!(refusal(outside), Some(Reason::NoTransform), "{outside}");
    }
    // Nor where odometry does not name the robot's frame.
    let mut intake = self::intake();
    let nameless = Odometry { child_frame_id: String::new(), ..odometry(S, 2.0) };
    intake.odometry(&nameless, at(S)).expect("sound");
    assert!(intake.upstream(&twist, Some(&header("odom", S)), at(S)).is_err());
}

fn path(places: &[[f64; 2]]) -> recording::ros2::Path {
    let poses = places.iter().map(|[x, y]| {
        let mut pose = PoseStamped::default();
        (pose.pose.position.x, pose.pose.position.y) = (*x, *y);
        pose
    });
    recording::ros2::Path { header: header("odom", 0), poses: poses.collect() }
}

fn place(event: Option<BridgeEvent>) -> Option<[f64; 2]> {
    match event {
        Some(BridgeEvent::Goal(goal)) => Some(goal.position_in_odom_m),
        Some(other) => panic!("no goal but {other:?}"),
        None => None,
    }
}

#[test]
fn whichever_of_goal_and_path_spoke_last_rules() {
    let mut intake = intake();
    let straight = path(&[[0.0, 0.0], [10.0, 0.0]]);
    assert_eq!(intake.path(&straight, at(S)), Ok(None), "where is the robot?");
    intake.odometry(&odometry(S, 1.0), at(S)).expect("sound");
    assert_eq!(place(intake.next_waypoint(at(S))), Some([2.5, 0.0]));
    assert_eq!(intake.path(&straight, at(S)), Ok(None), "the same path again");
    intake.odometry(&odometry(2 * S, 3.0), at(2 * S)).expect("sound");
    assert_eq!(place(intake.next_waypoint(at(2 * S))), Some([4.5, 0.0]));
    let up = intake.path(&path(&[[3.0, 0.0], [3.0, 9.0]]), at(2 * S)).expect("sound");
    assert_eq!(place(up), Some([3.0, 1.5]));
    let broken = intake.path(&path(&[[3.0, f64::NAN]]), at(2 * S));
    assert_eq!(broken, Err(Reason::MalformedInput));
    let pose = Pose { orientation: Quaternion::from_heading(1.0), ..Pose::default() };
    let goal = PoseStamped { header: header("odom", 2 * S), pose };
    assert!(intake.goal(&goal, at(2 * S)).is_ok());
    assert_eq!(intake.next_waypoint(at(2 * S)), None, "the goal rules");
    let resumed = intake.path(&straight, at(2 * S)).expect("sound");
    assert_eq!(place(resumed), Some([4.5, 0.0]));
    // A planner that has no path any more.
    let halt = intake.path(&path(&[]), at(2 * S)).expect("sound");
    assert_eq!(place(halt), Some([3.0, 0.0]));
    assert_eq!(intake.next_waypoint(at(2 * S)), None);
    // The same figures in another frame are another path.
    intake.transforms(&transform("map", "odom", 2 * S, 5.0), false, at(2 * S)).expect("sound");
    let resumed = intake.path(&straight, at(2 * S)).expect("sound");
    assert_eq!(place(resumed), Some([4.5, 0.0]));
    let mut elsewhere = straight;
    elsewhere.header.frame_id = "map".to_owned();
    assert_eq!(place(intake.path(&elsewhere, at(2 * S)).expect("sound")), Some([4.5, 0.0]));
    assert_eq!(place(intake.path(&path(&[]), at(2 * S)).expect("sound")), Some([3.0, 0.0]));
}

#[test]
fn a_path_that_is_taken_back_while_nobody_knows_where_the_robot_is_halts_it_later() {
    let mut intake = intake_with(|ros2| ros2.use_sim_time = Some(true));
    assert_eq!(intake.clock(&clock(5 * S), at(50 * S)), Ok(()));
    intake.odometry(&simulated(5 * S, 1.0), at(50 * S)).expect("sound");
    let led = intake.path(&path(&[[0.0, 0.0], [10.0, 0.0]]), at(50 * S)).expect("sound");
    assert_eq!(place(led), Some([2.5, 0.0]));
    assert_eq!(intake.clock(&clock(S), at(50 * S + MS)), Err(Reason::ClockJump));
    assert_eq!(intake.path(&path(&[]), at(50 * S + MS)), Ok(None), "where is the robot?");
    intake.odometry(&simulated(S, 1.2), at(50 * S + MS)).expect("sound");
    assert_eq!(place(intake.next_waypoint(at(50 * S + MS))), Some([1.2, 0.0]));
    assert_eq!(intake.next_waypoint(at(50 * S + MS)), None);
}

#[test]
fn every_obstacle_message_reaches_the_same_frame() {
    use recording::ros2::{
        Agent, Agents, Marker, MarkerArray, Object, ObjectArray, Obstacle, ObstacleArray, People, Person,
    };
    let mut intake = intake();
    let header = header("odom", S);
    let velocity = Vector3 { x: 0.5, ..Vector3::default() };
    let mut object = Object { detection_level: Object::TRACKED, ..Object::default() };
    object.twist.linear = velocity.clone();
    let mut agent = Agent::default();
    agent.velocity.linear = velocity.clone();
    let mut old_agent = recording::ros2::hunav1::Agent::default();
    old_agent.velocity.linear = velocity.clone();
    let person = Person { velocity: recording::ros2::Point { x: 0.5, y: 0.0, z: 0.0 }, ..Person::default() };
    let obstacle = Obstacle { velocity, ..Obstacle::default() };
    let messages: [Box<dyn ObstacleFrame>; 5] = [
        Box::new(People { header: header.clone(), people: vec![person; 2] }),
        Box::new(ObjectArray { header: header.clone(), objects: vec![object; 2] }),
        Box::new(Agents { header: header.clone(), agents: vec![agent; 2] }),
        Box::new(recording::ros2::hunav1::Agents { header: header.clone(), agents: vec![old_agent; 2] }),
        Box::new(ObstacleArray { header: header.clone(), obstacles: vec![obstacle; 2] }),
    ];
    for message in messages {
        let frame = people(intake.obstacles(&*message, at(S)));
        assert_eq!(frame.count, 2);
        for found in frame.as_slice() {
            assert_eq!((found.flags, found.velocity_in_odom_mps), (DetectionFlags::HAS_VELOCITY, [0.5, 0.0]));
        }
    }
    let mut marker = Marker { header, r#type: Marker::CYLINDER, ..Marker::default() };
    marker.scale.x = 0.8;
    let frame = people(intake.obstacles(&MarkerArray { markers: vec![marker] }, at(S)));
    assert_eq!((frame.count, frame.as_slice()[0].radius_m), (1, 0.4));
    let frame = people(intake.obstacles(&MarkerArray::default(), at(S)));
    assert_eq!(frame.count, 1, "what was drawn still holds");
}

#[test]
fn objects_in_frames_of_their_own_need_those() {
    use recording::ros2::{Object, ObjectArray};
    let mut intake = intake();
    let mut objects = ObjectArray { header: header("odom", S), objects: vec![Object::default(); 2] };
    objects.objects[1].header = header("radar", S);
    assert_eq!(intake.obstacles(&objects, at(S)).err(), Some(Reason::NoTransform));
    intake.transforms(&transform("odom", "radar", 0, 7.0), true, at(S)).expect("sound");
    let frame = people(intake.obstacles(&objects, at(S)));
    let places: Vec<_> = frame.as_slice().iter().map(|found| found.position_in_odom_m[0]).collect();
    assert_eq!(places, [0.0, 7.0]);
}
