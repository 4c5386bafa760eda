//! The life of tracks: appearing, repeated, jumping, missing, vanishing, anonymous, and too many.

mod support;

use messages::{ObstacleClass, ObstacleQuality, Reason};
use obstacle_estimator::{Estimator, FIRST_ANONYMOUS_ID};
use support::{MS, START_NS, close, feed, frame, ids, moving, of, provided, seen, settings};

#[test]
fn of_two_detections_with_one_identity_the_first_is_kept() {
    let mut estimator = Estimator::new(settings());
    let answer = feed(&mut estimator, 0, &[seen(1, [1.0, 0.0]), seen(2, [2.0, 0.0]), seen(1, [9.0, 9.0])]);
    assert_eq!(ids(&answer), [1, 2]);
    assert_eq!(of(&answer, 1).position_in_odom_m, [1.0, 0.0]);
    // The same once the track exists.
    let answer = feed(&mut estimator, 50, &[seen(1, [1.05, 0.0]), seen(1, [9.0, 9.0])]);
    assert!(close(of(&answer, 1).velocity_in_odom_mps[0], 1.0));
    assert_eq!(estimator.counts().detections_duplicate, 2);
    assert_eq!(estimator.counts().detections_used, 3);
    assert_eq!(estimator.last_reason(), Reason::Duplicate);
}

#[test]
fn malformed_detections_are_refused_alone() {
    let mut estimator = Estimator::new(settings());
    let mut detections = [seen(1, [0.0, 0.0]); 8];
    for (index, detection) in detections.iter_mut().enumerate() {
        detection.track_id = index as u64 + 1;
    }
    detections[0].position_in_odom_m[0] = f64::NAN;
    detections[1].position_in_odom_m[1] = f64::NEG_INFINITY;
    detections[2].radius_m = 0.0;
    detections[3].radius_m = -0.3;
    detections[4].radius_m = f64::INFINITY;
    detections[5].radius_m = f64::NAN;
    detections[6].position_in_odom_m[0] = 1e300;
    let answer = feed(&mut estimator, 0, &detections);
    assert_eq!(ids(&answer), [8]);
    assert_eq!((estimator.counts().detections_malformed, estimator.counts().detections_used), (7, 1));
    assert_eq!(estimator.last_reason(), Reason::MalformedInput);
}

#[test]
fn a_malformed_sighting_of_a_known_obstacle_lets_it_coast() {
    let mut estimator = Estimator::new(settings());
    feed(&mut estimator, 0, &[seen(1, [0.0, 0.0])]);
    feed(&mut estimator, 50, &[seen(1, [0.05, 0.0])]);
    let answer = feed(&mut estimator, 100, &[seen(1, [f64::NAN, 0.0])]);
    assert!(close(of(&answer, 1).position_in_odom_m[0], 0.1));
    assert_eq!(of(&answer, 1).quality, ObstacleQuality::Coasting.code());
}

#[test]
fn a_teleport_restarts_the_track_without_a_velocity_from_the_jump() {
    let mut estimator = Estimator::new(settings());
    feed(&mut estimator, 0, &[seen(1, [0.0, 0.0])]);
    feed(&mut estimator, 50, &[seen(1, [0.05, 0.0])]);
    // 0.41 m in 50 ms are 8.2 m/s.
    let jumped = of(&feed(&mut estimator, 100, &[seen(1, [0.46, 0.0])]), 1);
    assert_eq!((jumped.position_in_odom_m, jumped.velocity_in_odom_mps), ([0.46, 0.0], [0.0, 0.0]));
    assert_eq!((jumped.quality, jumped.speed_rate_mps2), (ObstacleQuality::PositionOnly.code(), 0.0));
    let after = of(&feed(&mut estimator, 150, &[seen(1, [0.51, 0.0])]), 1);
    assert!(close(after.velocity_in_odom_mps[0], 1.0));
    assert_eq!(after.quality, ObstacleQuality::Velocity.code());
    assert_eq!(estimator.counts().tracks_teleported, 1);
    assert_eq!(estimator.last_reason(), Reason::Teleport);
}

#[test]
fn fast_but_possible_motion_is_no_teleport() {
    let mut estimator = Estimator::new(settings());
    feed(&mut estimator, 0, &[seen(1, [0.0, 0.0])]);
    let fast = of(&feed(&mut estimator, 50, &[seen(1, [0.39, 0.0])]), 1);
    assert!(close(fast.velocity_in_odom_mps[0], 7.8));
    assert_eq!(estimator.counts().tracks_teleported, 0);
}

#[test]
fn a_teleport_with_a_measured_velocity_keeps_that() {
    let mut estimator = Estimator::new(provided());
    feed(&mut estimator, 0, &[moving(1, [0.0, 0.0], [1.0, 0.0])]);
    let jumped = of(&feed(&mut estimator, 50, &[moving(1, [7.0, 0.0], [1.1, 0.0])]), 1);
    assert_eq!((jumped.velocity_in_odom_mps, jumped.speed_rate_mps2), ([1.1, 0.0], 0.0));
    assert_eq!(estimator.counts().tracks_teleported, 1);
}

#[test]
fn a_missing_obstacle_coasts_and_its_next_difference_spans_the_gap() {
    let mut estimator = Estimator::new(settings());
    feed(&mut estimator, 0, &[seen(1, [0.0, 0.0])]);
    feed(&mut estimator, 50, &[seen(1, [0.05, 0.0])]);
    feed(&mut estimator, 100, &[seen(1, [0.102, 0.0])]);
    for at_ms in [150, 200, 250] {
        let coasting = of(&feed(&mut estimator, at_ms, &[]), 1);
        assert_eq!(coasting.quality, ObstacleQuality::Coasting.code());
        assert!(close(coasting.position_in_odom_m[0], 0.102 + 1.04 * (at_ms - 100) as f64 * 1e-3));
        assert!(close(coasting.speed_mps, 1.04));
        assert_eq!((coasting.speed_rate_mps2, coasting.acceleration_in_odom_mps2), (0.0, [0.0, 0.0]));
        assert_eq!(coasting.valid_at_ns - coasting.measured_at_ns, (at_ms - 100) * MS);
    }
    let back = of(&feed(&mut estimator, 300, &[seen(1, [0.302, 0.0])]), 1);
    assert!(close(back.velocity_in_odom_mps[0], 1.0), "{back:?}");
    assert!(close(back.speed_rate_mps2, -0.2));
    assert_eq!(back.quality, ObstacleQuality::Full.code());
    assert_eq!(estimator.counts().tracks_coasted, 3);
}

#[test]
fn who_stays_away_is_dropped_after_the_coasting_time_and_starts_afresh_on_return() {
    let mut estimator = Estimator::new(settings());
    feed(&mut estimator, 0, &[seen(1, [0.0, 0.0]), seen(2, [5.0, 0.0])]);
    feed(&mut estimator, 50, &[seen(1, [0.05, 0.0]), seen(2, [5.0, 0.05])]);
    for at_ms in (100..=550).step_by(50) {
        assert_eq!(ids(&feed(&mut estimator, at_ms, &[seen(2, [5.0, at_ms as f64 * 1e-3])])), [1, 2]);
    }
    let answer = feed(&mut estimator, 600, &[seen(2, [5.0, 0.6])]);
    assert_eq!(ids(&answer), [2]);
    assert!(
        answer.items[1].track_id == 0 && answer.items[1].radius_m == 0.0,
        "entries beyond the count are zero"
    );
    let back = feed(&mut estimator, 650, &[seen(1, [0.65, 0.0]), seen(2, [5.0, 0.65])]);
    assert_eq!(of(&back, 1).quality, ObstacleQuality::PositionOnly.code());
    assert_eq!((estimator.counts().tracks_dropped, estimator.counts().tracks_started), (1, 3));
}

#[test]
fn anonymous_detections_get_identities_of_their_own_and_keep_them() {
    let mut estimator = Estimator::new(settings());
    let first = feed(&mut estimator, 0, &[seen(0, [0.0, 0.0]), seen(0, [0.0, 2.0]), seen(4, [4.0, 0.0])]);
    assert_eq!(ids(&first), [4, FIRST_ANONYMOUS_ID, FIRST_ANONYMOUS_ID + 1]);
    // Listed the other way round in the next frame, and moved.
    let second = feed(&mut estimator, 50, &[seen(0, [0.0, 1.95]), seen(4, [4.0, 0.0]), seen(0, [0.05, 0.0])]);
    assert_eq!(ids(&second), [4, FIRST_ANONYMOUS_ID, FIRST_ANONYMOUS_ID + 1]);
    assert!(close(of(&second, FIRST_ANONYMOUS_ID).velocity_in_odom_mps[0], 1.0));
    assert!(close(of(&second, FIRST_ANONYMOUS_ID + 1).velocity_in_odom_mps[1], -1.0));
}

#[test]
fn crossing_anonymous_obstacles_are_told_apart_by_their_predicted_positions() {
    let mut estimator = Estimator::new(settings());
    // At 5 Hz they walk 0.24 m a frame: when they meet, each is closer to where the other one was.
    let frame_of = |k: u64| {
        let x_m = 0.24 * k as f64;
        [seen(0, [x_m, 0.0]), seen(0, [2.28 - x_m, 0.1])]
    };
    for k in 0..10 {
        feed(&mut estimator, 200 * k, &frame_of(k));
    }
    let answer = feed(&mut estimator, 2000, &frame_of(10));
    assert!(close(of(&answer, FIRST_ANONYMOUS_ID).position_in_odom_m[0], 2.4));
    assert!(close(of(&answer, FIRST_ANONYMOUS_ID + 1).position_in_odom_m[0], -0.12));
    assert_eq!(estimator.counts().tracks_started, 2);
}

#[test]
fn an_anonymous_detection_outside_the_gate_is_somebody_else() {
    let mut estimator = Estimator::new(settings());
    feed(&mut estimator, 0, &[seen(0, [0.0, 0.0])]);
    let answer = feed(&mut estimator, 200, &[seen(0, [0.8, 0.0])]);
    assert_eq!(ids(&answer), [FIRST_ANONYMOUS_ID, FIRST_ANONYMOUS_ID + 1]);
    // Inside the gate, but 12 m/s away.
    let answer = feed(&mut estimator, 250, &[seen(0, [1.4, 0.0])]);
    assert_eq!(answer.count, 3);
    assert_eq!(estimator.counts().tracks_teleported, 0);
}

#[test]
fn anonymous_detections_never_take_over_a_named_track() {
    let mut estimator = Estimator::new(settings());
    feed(&mut estimator, 0, &[seen(3, [0.0, 0.0])]);
    assert_eq!(ids(&feed(&mut estimator, 50, &[seen(0, [0.0, 0.0])])), [3, FIRST_ANONYMOUS_ID]);
}

#[test]
fn identities_stay_unique_when_perception_uses_the_anonymous_range() {
    let mut estimator = Estimator::new(settings());
    let answer = feed(&mut estimator, 0, &[seen(0, [0.0, 0.0]), seen(FIRST_ANONYMOUS_ID, [4.0, 0.0])]);
    assert_eq!(ids(&answer), [FIRST_ANONYMOUS_ID, FIRST_ANONYMOUS_ID + 1]);
    assert_eq!(of(&answer, FIRST_ANONYMOUS_ID).position_in_odom_m, [4.0, 0.0]);
    // Perception names an identity that was given to an anonymous track: the track becomes a named one.
    let answer = feed(&mut estimator, 50, &[seen(FIRST_ANONYMOUS_ID + 1, [0.05, 0.0])]);
    assert!(close(of(&answer, FIRST_ANONYMOUS_ID + 1).velocity_in_odom_mps[0], 1.0));
    assert_eq!(answer.count, 2);
    let answer = feed(&mut estimator, 100, &[seen(0, [0.1, 0.0])]);
    assert_eq!(answer.count, 3);
}

#[test]
fn at_capacity_measured_obstacles_displace_the_longest_unseen() {
    let mut estimator = Estimator::new(settings());
    let people =
        |ids: std::ops::RangeInclusive<u64>| -> Vec<_> { ids.map(|id| seen(id, [id as f64, 0.0])).collect() };
    feed(&mut estimator, 0, &people(1..=64));
    // 1 to 10 are missing, but there is nobody to displace them.
    assert_eq!(feed(&mut estimator, 50, &people(11..=64)).count, 64);
    // 11 is now missing too, for a shorter time; five newcomers push out five of 1 to 10.
    let mut frame_items = people(12..=64);
    frame_items.extend(people(101..=105));
    let mut full = frame(100, &frame_items);
    full.left_out = 3;
    let answer = *estimator.step(&full, START_NS + 103 * MS);
    assert_eq!((answer.count, answer.left_out), (64, 8));
    assert!((101..=105).chain(12..=64).all(|id| ids(&answer).contains(&id)));
    assert!(ids(&answer).contains(&11));
    assert_eq!(estimator.counts().tracks_evicted, 5);
    assert_eq!(estimator.last_reason(), Reason::CapacityExceeded);
    // A whole frame of strangers leaves room for nobody else.
    assert_eq!(ids(&feed(&mut estimator, 150, &people(201..=264))), (201..=264).collect::<Vec<_>>());
}

#[test]
fn an_unknown_class_becomes_unknown() {
    let mut estimator = Estimator::new(settings());
    let mut odd = seen(1, [0.0, 0.0]);
    odd.class = 4711;
    assert_eq!(of(&feed(&mut estimator, 0, &[odd]), 1).class, ObstacleClass::Unknown.code());
}
