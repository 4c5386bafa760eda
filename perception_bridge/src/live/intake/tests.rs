//! What a live graph may send, and what becomes of it.

use std::path::Path;

use messages::DetectionFlags;
use recording::ros2::{Detection3D, Pose, Quaternion, Time, TrackedObject, Transform, Vector3};

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
    assert_eq!(intake.odometry(&simulated, at(1_022 * MS)).err(), Some(Reason::MalformedInput));
    assert_eq!(refusal(&mut intake, 1_040 * MS, 1_041 * MS), None);
    // The date jumps back by an hour, for publisher and stack alike: the stack clock does not notice.
    let hour_ns = 3_600 * S;
    let mut later = odometry(1_060 * MS, 0.0);
    later.header.stamp = Time::from_ns(EPOCH_NS + 1_060 * MS - hour_ns);
    let jumped = Arrival { stack_ns: 1_061 * MS, wall_ns: EPOCH_NS + 1_061 * MS - hour_ns };
    let event = intake.odometry(&later, jumped);
    assert!(matches!(event, Ok(BridgeEvent::RobotState(state)) if state.stamp.valid_at_ns == 1_060 * MS));
    // One that was under way meanwhile bears the old date.
    assert_eq!(intake.odometry(&odometry(1_062 * MS, 0.0), jumped).err(), Some(Reason::FutureStamp));
}

#[test]
fn obstacles_need_a_frame_that_leads_to_odom_whatever_the_settings_assume_of_recordings() {
    let mut intake = intake();
    let frame = boxes("laser", 1_000 * MS, &[[2.0, 0.0]]);
    assert_eq!(intake.boxes(&frame, at(1_001 * MS)).err(), Some(Reason::NoTransform));
    let laser = transform("base_link", "laser", 0, 0.5);
    assert_eq!(intake.transforms(&laser, true, at(1_002 * MS)), Ok(()));
    assert_eq!(intake.boxes(&frame, at(1_003 * MS)).err(), Some(Reason::NoTransform));
    intake.odometry(&odometry(1_000 * MS, 10.0), at(1_004 * MS)).expect("sound");
    let found = people(intake.boxes(&frame, at(1_005 * MS)));
    assert_eq!(found.as_slice()[0].position_in_odom_m, [12.5, 0.0]);
    // Where the robot is was last said too long ago.
    let late = boxes("laser", 1_600 * MS, &[[2.0, 0.0]]);
    assert_eq!(intake.boxes(&late, at(1_601 * MS)).err(), Some(Reason::NoTransform));
    let in_odom = boxes("odom", 1_600 * MS, &[[2.0, 0.0]]);
    assert_eq!(people(intake.boxes(&in_odom, at(1_602 * MS))).count, 1, "needs no transform");
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
    let found = people(intake.boxes(&boxes("base_link", 1_020 * MS, &[[1.0, 0.0]]), at(1_021 * MS)));
    assert_eq!(found.as_slice()[0].position_in_odom_m, [21.0, 0.0]);
}

#[test]
fn a_crowd_beyond_capacity_keeps_the_nearest_and_unsound_ones_do_not_cost_the_others() {
    let mut intake = intake();
    intake.odometry(&odometry(1_000 * MS, 100.0), at(1_000 * MS)).expect("sound");
    let mut places: Vec<_> = (0..400).map(|index| [f64::from(index), 0.0]).collect();
    places[7][0] = f64::NAN;
    let frame = people(intake.boxes(&boxes("odom", 1_000 * MS, &places), at(1_001 * MS)));
    assert_eq!((frame.count as usize, frame.left_out as usize), (MAX_OBSTACLES, 399 - MAX_OBSTACLES));
    assert_eq!(frame.as_slice()[0].position_in_odom_m, [100.0, 0.0]);
    assert_eq!(intake.refused_detections(), 1);
}

#[test]
fn positions_and_tracks_are_obstacles_too() {
    let mut intake = intake();
    let pose = Pose { orientation: Quaternion::from_heading(0.0), ..Pose::default() };
    let poses = PoseArray { header: header("odom", 1_000 * MS), poses: vec![pose; 3] };
    assert_eq!(people(intake.poses(&poses, at(1_000 * MS))).count, 3);
    let mut object = TrackedObject::default();
    object.kinematics.is_stationary = true;
    let tracks = TrackedObjects { header: header("odom", 1_050 * MS), objects: vec![object] };
    let frame = people(intake.tracks(&tracks, at(1_051 * MS)));
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
