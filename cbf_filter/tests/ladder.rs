//! Every rung of the safety ladder, reached on purpose.

mod scene;

use messages::{ControlKind, Intent, Reason, SafeCommand, SafetyStatus};
use scene::{MS, START_NS, Scene, filter, person};

fn status(command: &SafeCommand) -> (SafetyStatus, Reason) {
    (command.status.try_into().expect("a known status"), command.reason.try_into().expect("a known reason"))
}

#[test]
fn nothing_received_means_standing_still() {
    let scene = Scene { robot_state: None, obstacles: None, nominal: None, goal: None };
    let command = scene.step(&mut filter(), START_NS);
    assert_eq!(status(&command), (SafetyStatus::Stopped, Reason::NoRobotState));
    assert_eq!(command.control, [0.0; 2]);
}

#[test]
fn a_free_way_leaves_the_nominal_command_alone() {
    let command = Scene::fresh(&[], START_NS).step(&mut filter(), START_NS);
    assert_eq!(status(&command), (SafetyStatus::Filtered, Reason::None));
    assert_eq!(command.control, [0.8, 0.1]);
    assert_eq!((command.h_m, command.obstacle_count), (f64::INFINITY, 0));
}

#[test]
fn a_person_far_away_leaves_the_nominal_command_alone() {
    let people = [person(7, [5.5, 3.0], [0.0, 0.5], START_NS)];
    let command = Scene::fresh(&people, START_NS).step(&mut filter(), START_NS);
    assert_eq!(status(&command), (SafetyStatus::Filtered, Reason::None));
    assert_eq!(command.control, [0.8, 0.1]);
    assert_eq!((command.critical_track_id, command.obstacle_count), (7, 1));
}

#[test]
fn a_person_ahead_changes_the_command_until_the_condition_holds() {
    let people = [person(7, [2.7, 0.3], [-0.8, 0.0], START_NS), person(8, [0.0, 4.0], [0.0, 1.0], START_NS)];
    let command = Scene::fresh(&people, START_NS).step(&mut filter(), START_NS);
    assert_eq!(status(&command).0, SafetyStatus::Filtered);
    assert_ne!(command.control, [0.8, 0.1], "{command:?}");
    assert_eq!(command.critical_track_id, 7);
    let [a_v, a_w] = command.lg_h;
    let condition = command.drift_mps
        + a_v * command.control[0]
        + a_w * command.control[1]
        + command.alpha_per_s * command.h_m;
    assert!(condition >= -command.slack_mps - 1e-9, "{condition} {command:?}");
    assert!(command.hard_margin_mps >= 0.0);
}

#[test]
fn people_who_leave_no_way_out_relax_the_condition_and_say_so() {
    let people = [
        person(1, [0.75, 0.0], [-1.2, 0.0], START_NS),
        person(2, [0.4, 0.8], [-0.3, -1.2], START_NS),
        person(3, [0.4, -0.8], [-0.3, 1.2], START_NS),
    ];
    let command = Scene::fresh(&people, START_NS).step(&mut filter(), START_NS);
    assert_eq!(status(&command), (SafetyStatus::Relaxed, Reason::SlackNeeded));
    assert!(command.slack_mps > 0.0 && command.hard_margin_mps < 0.0);
}

#[test]
fn an_old_measurement_makes_a_larger_obstacle() {
    let mut values = Vec::new();
    for age_ns in [0, 100 * MS, 200 * MS] {
        let mut standing = person(1, [2.0, 0.0], [0.0, 0.0], START_NS);
        standing.measured_at_ns = START_NS - age_ns;
        values.push(Scene::fresh(&[standing], START_NS).step(&mut filter(), START_NS).h_m);
    }
    let per_step = 0.35 * 0.1;
    assert!((values[0] - values[1] - per_step).abs() < 1e-9, "{values:?}");
    assert!((values[1] - values[2] - per_step).abs() < 1e-9, "{values:?}");
}

/// One way to spoil a fresh scene.
type Spoil = fn(&mut Scene);

#[test]
fn every_untrustworthy_input_brakes_for_its_own_reason() {
    let now_ns = START_NS;
    let cases: [(&str, Spoil, Reason); 16] = [
        ("no robot state", |s| s.robot_state = None, Reason::NoRobotState),
        (
            "old robot state",
            |s| edit(&mut s.robot_state).stamp.valid_at_ns -= 61 * MS,
            Reason::StaleRobotState,
        ),
        (
            "early robot state",
            |s| edit(&mut s.robot_state).stamp.valid_at_ns += 101 * MS,
            Reason::FutureStamp,
        ),
        ("NaN heading", |s| edit(&mut s.robot_state).heading_rad = f64::NAN, Reason::NonFiniteRobotState),
        ("no obstacles", |s| s.obstacles = None, Reason::NoObstacles),
        ("dead estimator", |s| edit(&mut s.obstacles).stamp.published_ns -= 76 * MS, Reason::SilentEstimator),
        (
            "blind perception",
            |s| edit(&mut s.obstacles).stamp.valid_at_ns -= 401 * MS,
            Reason::StaleDetections,
        ),
        ("early detections", |s| edit(&mut s.obstacles).stamp.valid_at_ns += 101 * MS, Reason::FutureStamp),
        (
            "infinite position",
            |s| edit(&mut s.obstacles).items[0].position_in_odom_m[1] = f64::INFINITY,
            Reason::UnsoundObstacle,
        ),
        (
            "an obstacle of long ago",
            |s| edit(&mut s.obstacles).items[0].valid_at_ns = 0,
            Reason::StaleDetections,
        ),
        ("negative radius", |s| edit(&mut s.obstacles).items[0].radius_m = -0.1, Reason::UnsoundObstacle),
        ("no nominal command", |s| s.nominal = None, Reason::NoNominalCommand),
        (
            "dead controller",
            |s| edit(&mut s.nominal).stamp.published_ns -= 86 * MS,
            Reason::StaleNominalCommand,
        ),
        ("NaN command", |s| edit(&mut s.nominal).control[0] = f64::NAN, Reason::NonFiniteNominalCommand),
        (
            "command for another robot",
            |s| edit(&mut s.nominal).control_kind = ControlKind::DoubleIntegrator.code(),
            Reason::WrongControlKind,
        ),
        ("unknown intent", |s| edit(&mut s.nominal).intent = 77, Reason::WrongControlKind),
    ];
    for (what, spoil, reason) in cases {
        let mut filter = filter();
        let people = [person(1, [4.0, 0.0], [0.0, 0.3], now_ns)];
        Scene::fresh(&people, now_ns).step(&mut filter, now_ns);
        let mut scene = Scene::fresh(&people, now_ns);
        spoil(&mut scene);
        let command = scene.step(&mut filter, now_ns);
        assert_eq!(status(&command), (SafetyStatus::Braking, reason), "{what}");
        assert!(command.control[0] < 0.8 && command.control[1] == 0.0, "{what}: {:?}", command.control);
    }
}

fn edit<T>(message: &mut Option<T>) -> &mut T {
    message.as_mut().expect("the scene is complete")
}

#[test]
fn a_robot_state_from_the_past_is_not_believed_again() {
    let mut filter = filter();
    Scene::fresh(&[], START_NS + 20 * MS).step(&mut filter, START_NS + 20 * MS);
    let command = Scene::fresh(&[], START_NS).step(&mut filter, START_NS + 24 * MS);
    assert_eq!(status(&command), (SafetyStatus::Braking, Reason::BackwardStamp));
}

#[test]
fn one_wild_stamp_does_not_lock_out_the_good_ones() {
    let mut filter = filter();
    let mut scene = Scene::fresh(&[], START_NS);
    edit(&mut scene.robot_state).stamp.valid_at_ns = u64::MAX;
    assert_eq!(status(&scene.step(&mut filter, START_NS)).1, Reason::FutureStamp);
    let command = Scene::fresh(&[], START_NS).step(&mut filter, START_NS);
    assert_eq!(status(&command), (SafetyStatus::Filtered, Reason::None));
}

#[test]
fn braking_ends_in_standing_and_fresh_inputs_end_both() {
    let mut filter = filter();
    let first = Scene::fresh(&[], START_NS).step(&mut filter, START_NS);
    let mut scene = Scene::fresh(&[], START_NS);
    scene.nominal = None;
    let (mut now_ns, mut speed, mut cycles) = (START_NS, first.control[0], 0);
    loop {
        now_ns += 4 * MS;
        let command = scene.step(&mut filter, now_ns);
        assert!(command.control[0] <= speed && command.control[0] >= 0.0, "{:?}", command.control);
        speed = command.control[0];
        cycles += 1;
        assert!(cycles < 1000, "never stands");
        if status(&command).0 == SafetyStatus::Stopped {
            break;
        }
    }
    // 0.8 m/s at 1.5 m/s² and 4 ms a cycle.
    assert_eq!(cycles, 134);
    let again = Scene::fresh(&[], now_ns).step(&mut filter, now_ns);
    assert_eq!(status(&again), (SafetyStatus::Filtered, Reason::None));
}

#[test]
fn a_filter_that_starts_while_the_robot_moves_brakes_from_its_measured_speed() {
    let mut filter = filter();
    let mut scene = Scene::fresh(&[], START_NS);
    scene.nominal = None;
    let command = scene.step(&mut filter, START_NS);
    assert_eq!(status(&command), (SafetyStatus::Braking, Reason::NoNominalCommand));
    // 0.8 m/s, one cycle of 4 ms at 1.5 m/s² later.
    assert!((command.control[0] - 0.794).abs() < 1e-12, "{:?}", command.control);
}

#[test]
fn a_wish_to_stop_is_granted() {
    let mut filter = filter();
    Scene::fresh(&[], START_NS).step(&mut filter, START_NS);
    let mut scene = Scene::fresh(&[], START_NS + 4 * MS);
    edit(&mut scene.nominal).intent = Intent::Stop.code();
    let command = scene.step(&mut filter, START_NS + 4 * MS);
    assert_eq!(status(&command), (SafetyStatus::Braking, Reason::StopRequested));
}
