//! The backward difference: what a regular and an irregular sequence of sightings yields.

mod support;

use messages::ObstacleQuality;
use obstacle_estimator::Estimator;
use settings::EstimatorSettings;
use support::{MS, START_NS, close, feed, moving, of, provided, seen, settings};

#[test]
fn knowledge_grows_with_each_sighting() {
    let mut estimator = Estimator::new(settings());
    let first = of(&feed(&mut estimator, 0, &[seen(5, [1.0, 2.0])]), 5);
    assert_eq!(first.quality, ObstacleQuality::PositionOnly.code());
    assert_eq!((first.velocity_in_odom_mps, first.speed_mps), ([0.0, 0.0], 0.0));
    assert_eq!((first.radius_m, first.class), (0.3, 1));
    let second = of(&feed(&mut estimator, 50, &[seen(5, [1.05, 2.0])]), 5);
    assert_eq!(second.quality, ObstacleQuality::Velocity.code());
    assert!(close(second.velocity_in_odom_mps[0], 1.0) && close(second.speed_mps, 1.0));
    assert_eq!((second.speed_rate_mps2, second.acceleration_in_odom_mps2), (0.0, [0.0, 0.0]));
    let third = of(&feed(&mut estimator, 100, &[seen(5, [1.101, 2.0])]), 5);
    assert_eq!(third.quality, ObstacleQuality::Full.code());
    // 1.02 m/s after 1.00 m/s within 50 ms.
    assert!(close(third.speed_rate_mps2, 0.4) && close(third.acceleration_in_odom_mps2[0], 0.4));
}

#[test]
fn jitter_does_not_disturb_a_constant_velocity() {
    let mut estimator = Estimator::new(settings());
    for at_ms in [0, 31, 50, 113, 114, 171, 250, 262, 400] {
        let s = at_ms as f64 * 1e-3;
        let now = of(&feed(&mut estimator, at_ms, &[seen(1, [1.2 * s, -0.5 * s])]), 1);
        assert_eq!(now.measured_at_ns, START_NS + at_ms * MS);
        if at_ms > 0 {
            assert!(close(now.velocity_in_odom_mps[0], 1.2) && close(now.velocity_in_odom_mps[1], -0.5));
            assert!(now.heading_rate_radps.abs() < 1e-6 && now.speed_rate_mps2.abs() < 1e-6, "{now:?}");
        }
    }
}

#[test]
fn walking_on_a_circle_shows_its_turn_rate_across_the_seam_at_pi() {
    let mut estimator = Estimator::new(settings());
    let (turn_radps, radius_m) = (0.3, 4.0);
    let mut full = 0;
    for k in 0..1000_u32 {
        let angle = turn_radps * 0.05 * f64::from(k);
        let at = [radius_m * angle.cos(), radius_m * angle.sin()];
        let now = of(&feed(&mut estimator, u64::from(k) * 50, &[seen(1, at)]), 1);
        assert!((-std::f64::consts::PI..std::f64::consts::PI).contains(&now.heading_rad));
        if now.quality == ObstacleQuality::Full.code() {
            full += 1;
            assert!((now.heading_rate_radps - turn_radps).abs() < 1e-6, "{now:?}");
            // The chord is a little shorter than the arc.
            assert!((now.speed_mps - 1.2).abs() < 1e-4 && now.speed_rate_mps2.abs() < 1e-6);
        }
    }
    assert_eq!(full, 998);
}

#[test]
fn rates_beyond_the_bounds_are_clipped() {
    let mut estimator = Estimator::new(settings());
    feed(&mut estimator, 0, &[seen(1, [0.0, 0.0])]);
    feed(&mut estimator, 50, &[seen(1, [0.05, 0.0])]);
    let now = of(&feed(&mut estimator, 100, &[seen(1, [0.05, 0.1])]), 1);
    assert!(close(now.heading_rate_radps, 0.35) && close(now.speed_rate_mps2, 1.0));
    assert!(close(now.acceleration_in_odom_mps2[0], -1.0) && close(now.acceleration_in_odom_mps2[1], 1.0));
}

#[test]
fn a_slow_obstacle_keeps_its_heading_and_does_not_turn() {
    let mut estimator = Estimator::new(settings());
    feed(&mut estimator, 0, &[seen(1, [0.0, 0.0])]);
    let walking = of(&feed(&mut estimator, 50, &[seen(1, [0.0, 0.05])]), 1);
    assert!(close(walking.heading_rad, std::f64::consts::FRAC_PI_2));
    // 0.1 m/s sideways: too slow to tell a direction.
    let standing = of(&feed(&mut estimator, 100, &[seen(1, [0.005, 0.05])]), 1);
    assert!(close(standing.heading_rad, std::f64::consts::FRAC_PI_2) && standing.heading_rate_radps == 0.0);
    assert!(close(standing.speed_mps, 0.1) && close(standing.speed_rate_mps2, -1.0));
    // Walks off to the right: a new heading, yet no turn that was observed.
    let leaving = of(&feed(&mut estimator, 150, &[seen(1, [0.055, 0.05])]), 1);
    assert!(close(leaving.heading_rad, 0.0) && leaving.heading_rate_radps == 0.0);
}

#[test]
fn provided_velocities_pass_through_and_are_differenced_for_the_rates() {
    let mut estimator = Estimator::new(provided());
    // Positions disagree on purpose.
    let first = of(&feed(&mut estimator, 0, &[moving(1, [0.0, 0.0], [0.0, 1.0])]), 1);
    assert_eq!(first.velocity_in_odom_mps, [0.0, 1.0]);
    assert_eq!(first.quality, ObstacleQuality::Velocity.code());
    let second = of(&feed(&mut estimator, 50, &[moving(1, [0.1, 0.0], [-0.01, 1.02])]), 1);
    assert_eq!(second.velocity_in_odom_mps, [-0.01, 1.02]);
    assert_eq!(second.quality, ObstacleQuality::Full.code());
    assert!((second.acceleration_in_odom_mps2[1] - 0.4).abs() < 1e-9);
    assert!((second.heading_rate_radps - (0.01_f64 / 1.02).atan() / 0.05).abs() < 1e-9);
    assert_eq!(estimator.counts().velocities_missing, 0);
}

#[test]
fn a_missing_or_impossible_provided_velocity_is_counted_and_replaced_by_a_difference() {
    let mut estimator = Estimator::new(provided());
    feed(&mut estimator, 0, &[moving(1, [0.0, 0.0], [1.0, 0.0])]);
    let absent = of(&feed(&mut estimator, 50, &[seen(1, [0.06, 0.0])]), 1);
    assert!(close(absent.velocity_in_odom_mps[0], 1.2));
    let broken = of(&feed(&mut estimator, 100, &[moving(1, [0.11, 0.0], [f64::NAN, 0.0])]), 1);
    assert!(close(broken.velocity_in_odom_mps[0], 1.0));
    let absurd = of(&feed(&mut estimator, 150, &[moving(1, [0.17, 0.0], [1e9, 0.0])]), 1);
    assert!(close(absurd.velocity_in_odom_mps[0], 1.2));
    assert_eq!(estimator.counts().velocities_missing, 3);
    assert_eq!(estimator.counts().refused(), 0);
}

#[test]
fn measured_velocities_are_ignored_by_the_backward_difference() {
    let mut estimator = Estimator::new(settings());
    let first = of(&feed(&mut estimator, 0, &[moving(1, [0.0, 0.0], [3.0, 0.0])]), 1);
    assert_eq!(first.velocity_in_odom_mps, [0.0, 0.0]);
    let second = of(&feed(&mut estimator, 50, &[moving(1, [0.05, 0.0], [3.0, 0.0])]), 1);
    assert!(close(second.velocity_in_odom_mps[0], 1.0));
}

#[test]
fn too_long_an_interval_begins_the_velocity_anew() {
    let mut estimator = Estimator::new(EstimatorSettings { coast_ms: 5_000, ..settings() });
    feed(&mut estimator, 0, &[seen(1, [0.0, 0.0])]);
    feed(&mut estimator, 50, &[seen(1, [0.05, 0.0])]);
    let limit = of(&feed(&mut estimator, 350, &[seen(1, [0.35, 0.0])]), 1);
    assert!(close(limit.velocity_in_odom_mps[0], 1.0), "300 ms is still short enough");
    let beyond = of(&feed(&mut estimator, 651, &[seen(1, [0.651, 0.0])]), 1);
    assert_eq!(beyond.velocity_in_odom_mps, [0.0, 0.0]);
    assert_eq!(beyond.quality, ObstacleQuality::PositionOnly.code());
    let after = of(&feed(&mut estimator, 701, &[seen(1, [0.701, 0.0])]), 1);
    assert!(close(after.velocity_in_odom_mps[0], 1.0));
    assert_eq!(after.quality, ObstacleQuality::Velocity.code());
    assert_eq!(estimator.counts().tracks_interrupted, 1);
}
