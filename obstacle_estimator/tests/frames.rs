//! Whole frames that cannot be used, the heartbeat, and the stamps of the answer.

mod support;

use messages::Reason;
use obstacle_estimator::Estimator;
use support::{MS, START_NS, close, feed, frame, of, seen, settings};

#[test]
fn an_out_of_order_frame_is_refused_whole() {
    let mut estimator = Estimator::new(settings());
    feed(&mut estimator, 0, &[seen(1, [0.0, 0.0])]);
    feed(&mut estimator, 100, &[seen(1, [0.1, 0.0])]);
    let answer = feed(&mut estimator, 50, &[seen(1, [5.0, 5.0]), seen(2, [3.0, 3.0])]);
    assert_eq!(answer.count, 1);
    assert!(close(of(&answer, 1).velocity_in_odom_mps[0], 1.0));
    assert_eq!(answer.stamp.valid_at_ns, START_NS + 100 * MS);
    assert_eq!((estimator.counts().frames_out_of_order, estimator.counts().frames_used), (1, 2));
    assert_eq!(estimator.last_reason(), Reason::BackwardStamp);
    let next = feed(&mut estimator, 150, &[seen(1, [0.15, 0.0])]);
    assert!(close(of(&next, 1).velocity_in_odom_mps[0], 1.0));
}

#[test]
fn a_frame_with_the_newest_ones_time_is_refused() {
    let mut estimator = Estimator::new(settings());
    feed(&mut estimator, 0, &[seen(1, [0.0, 0.0])]);
    let answer = feed(&mut estimator, 0, &[seen(1, [1.0, 0.0])]);
    assert_eq!(of(&answer, 1).velocity_in_odom_mps, [0.0, 0.0]);
    assert_eq!(estimator.counts().frames_duplicate, 1);
    assert_eq!(estimator.last_reason(), Reason::Duplicate);
}

#[test]
fn a_frame_from_the_future_does_not_lock_out_the_honest_ones() {
    let mut estimator = Estimator::new(settings());
    let mut future = frame(3_600_000, &[seen(9, [0.0, 0.0])]);
    future.stamp.valid_at_ns += 1;
    estimator.step(&future, START_NS);
    assert_eq!(estimator.counts().frames_from_future, 1);
    assert_eq!(estimator.last_reason(), Reason::FutureStamp);
    assert_eq!(feed(&mut estimator, 50, &[seen(1, [0.0, 0.0])]).count, 1);
}

#[test]
fn before_the_first_frame_the_heartbeat_says_that_nothing_was_ever_seen() {
    let mut estimator = Estimator::new(settings());
    let answer = *estimator.heartbeat(START_NS);
    assert_eq!((answer.count, answer.stamp.valid_at_ns, answer.received_ns), (0, 0, 0));
    assert_eq!((answer.stamp.sequence, answer.stamp.published_ns), (1, START_NS));
}

#[test]
fn an_empty_frame_is_news_too() {
    let mut estimator = Estimator::new(settings());
    let answer = feed(&mut estimator, 40, &[]);
    assert_eq!((answer.count, answer.stamp.valid_at_ns), (0, START_NS + 40 * MS));
    assert_eq!(estimator.counts().frames_used, 1);
}

#[test]
fn stamps_lead_back_to_the_newest_used_frame() {
    let mut estimator = Estimator::new(settings());
    let answer = feed(&mut estimator, 20, &[seen(1, [0.0, 0.0])]);
    assert_eq!(answer.stamp.source_ns, 77 + 20 * MS);
    assert_eq!(answer.stamp.ingress_ns, START_NS + 21 * MS);
    assert_eq!(answer.bridge_published_ns, START_NS + 22 * MS);
    assert_eq!(answer.received_ns, START_NS + 23 * MS);
    let beat = *estimator.heartbeat(START_NS + 48 * MS);
    assert_eq!((beat.stamp.sequence, beat.stamp.published_ns), (2, START_NS + 48 * MS));
    assert_eq!((beat.stamp.valid_at_ns, beat.received_ns), (START_NS + 20 * MS, START_NS + 23 * MS));
}

#[test]
fn the_heartbeat_predicts_up_to_the_coasting_time_and_drops_nobody() {
    let mut estimator = Estimator::new(settings());
    feed(&mut estimator, 0, &[seen(1, [0.0, 0.0])]);
    let measured = of(&feed(&mut estimator, 50, &[seen(1, [0.05, 0.0])]), 1);
    let beat = of(estimator.heartbeat(START_NS + 75 * MS), 1);
    assert!(close(beat.position_in_odom_m[0], 0.075));
    assert_eq!((beat.valid_at_ns, beat.measured_at_ns), (START_NS + 75 * MS, START_NS + 50 * MS));
    assert_eq!(beat.quality, measured.quality);
    let late = of(estimator.heartbeat(START_NS + 60_000 * MS), 1);
    assert!(close(late.position_in_odom_m[0], 0.55));
    assert_eq!(late.valid_at_ns, START_NS + 550 * MS);
    // A clock that seems to run backwards predicts nothing.
    assert_eq!(of(estimator.heartbeat(START_NS), 1).valid_at_ns, START_NS + 50 * MS);
    // The next difference starts from the measurement, not from a prediction.
    let next = of(&feed(&mut estimator, 100, &[seen(1, [0.1, 0.0])]), 1);
    assert!(close(next.velocity_in_odom_mps[0], 1.0));
}

#[test]
fn a_count_beyond_the_capacity_is_cut() {
    let mut estimator = Estimator::new(settings());
    let people: Vec<_> = (1..=64).map(|id| seen(id, [id as f64, 0.0])).collect();
    let mut foreign = frame(0, &people);
    foreign.count = u32::MAX;
    foreign.left_out = 936;
    let answer = estimator.step(&foreign, START_NS + MS);
    assert_eq!((answer.count, answer.left_out), (64, 936));
}
