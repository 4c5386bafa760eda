//! Tracks that a Kalman filter follows: what of a belief reaches the robot, and when a belief ends.

mod support;

use messages::{Detection, DetectionFlags, Obstacle, ObstacleQuality};
use obstacle_estimator::Estimator;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use settings::{EstimatorSettings, NoiseSettings};
use support::{MS, NOISE, START_NS, close, feed, frame, ids, imm, kalman, of, seen};

/// Kalman settings whose radius grows by `radius_sds`.
fn growing(radius_sds: f64) -> EstimatorSettings {
    EstimatorSettings { noise: Some(NoiseSettings { radius_sds, ..NOISE }), ..kalman() }
}

#[test]
fn somebody_new_is_there_at_once_and_confirmed_by_the_third_sighting() {
    for settings in [kalman(), imm()] {
        let mut estimator = Estimator::new(settings);
        let first = of(&feed(&mut estimator, 0, &[seen(1, [2.0, 1.0])]), 1);
        assert_eq!((first.position_in_odom_m, first.velocity_in_odom_mps), ([2.0, 1.0], [0.0, 0.0]));
        let qualities: Vec<_> =
            (1..4).map(|k| of(&feed(&mut estimator, 50 * k, &[seen(1, [2.0, 1.0])]), 1).quality).collect();
        let expected = [ObstacleQuality::Velocity, ObstacleQuality::Full, ObstacleQuality::Full];
        assert_eq!(first.quality, ObstacleQuality::PositionOnly.code());
        assert_eq!(qualities, expected.map(ObstacleQuality::code));
    }
}

#[test]
fn who_is_seen_in_every_third_frame_is_never_hidden_and_never_confirmed() {
    let mut estimator = Estimator::new(kalman());
    for k in 0..30 {
        let sighting = [seen(1, [1.0, 0.0])];
        let present: &[Detection] = if k % 3 == 0 { &sighting } else { &[] };
        let quality = of(&feed(&mut estimator, 50 * k, present), 1).quality;
        assert_ne!(quality, ObstacleQuality::Full.code());
    }
    assert_eq!(estimator.counts().tracks_started, 1);
}

/// Standard deviation of the position of somebody first seen `age_s` ago.
fn sd_m(age_s: f64) -> f64 {
    let q = kalman().kalman.expect("kalman settings").acceleration_sd_mps2;
    let speed = NOISE.initial_speed_sd_mps * age_s;
    (NOISE.position_sd_m.powi(2) + speed * speed + (q * age_s * age_s / 2.0).powi(2)).sqrt()
}

#[test]
fn the_radius_grows_with_what_is_uncertain_when_the_answer_is_published() {
    let mut estimator = Estimator::new(growing(2.0));
    let sighting = frame(0, &[seen(1, [0.0, 0.0])]);
    let late = of(estimator.step(&sighting, START_NS + 100 * MS), 1);
    assert_eq!(late.valid_at_ns, START_NS, "the delay itself is made up for by the filter");
    assert!(close(late.radius_m, 0.3 + 2.0 * sd_m(0.1)), "{late:?}");
    for (now_ms, age_s) in [(300, 0.3), (500, 0.5), (900, 0.5)] {
        let predicted = of(estimator.heartbeat(START_NS + now_ms * MS), 1);
        assert!(close(predicted.radius_m, 0.3 + 2.0 * sd_m(age_s)), "at {now_ms} ms: {predicted:?}");
    }
    let mut unchanged = Estimator::new(growing(0.0));
    assert_eq!(of(unchanged.step(&sighting, START_NS + 100 * MS), 1).radius_m, 0.3);
}

#[test]
fn a_measured_covariance_is_believed_if_it_can_be() {
    let radius_m = |covariance: [f64; 3], flags: u32| {
        let measured = Detection { position_covariance_m2: covariance, flags, ..seen(1, [0.0, 0.0]) };
        of(Estimator::new(growing(1.0)).step(&frame(0, &[measured]), START_NS), 1).radius_m
    };
    let has = DetectionFlags::HAS_COVARIANCE;
    assert!(close(radius_m([0.01, 0.0, 0.04], has), 0.3 + 0.2));
    // Standard deviations of 0.2 m and 0.1 m along the diagonals.
    assert!(close(radius_m([0.025, 0.015, 0.025], has), 0.3 + 0.2));
    let usual_m = 0.3 + NOISE.position_sd_m;
    assert!(close(radius_m([0.01, 0.0, 0.04], 0), usual_m));
    for slip in
        [[f64::NAN, 0.0, 0.04], [0.0, 0.0, 0.0], [0.01, 0.02, 0.01], [-0.01, 0.0, 0.01], [1e5, 0.0, 0.01]]
    {
        assert!(close(radius_m(slip, has), usual_m), "{slip:?}");
    }
}

#[test]
fn noise_is_no_jump_and_a_jump_begins_anew() {
    let noise = NoiseSettings { position_sd_m: 0.15, ..NOISE };
    for base in [kalman(), imm()] {
        let mut estimator = Estimator::new(EstimatorSettings { noise: Some(noise), ..base });
        let mut random = Pcg64::new(4, 4);
        for k in 0..400 {
            let people: Vec<_> = (1..=64)
                .map(|id| {
                    let [x, y]: [f64; 2] = [(); 2].map(|()| StandardNormal.sample(&mut random));
                    seen(id, [id as f64 + 0.15 * x, 0.15 * y])
                })
                .collect();
            feed(&mut estimator, 50 * k, &people);
        }
        assert_eq!(estimator.counts().tracks_teleported, 0);
        let jumped = of(&feed(&mut estimator, 50 * 400, &[seen(1, [1.0, 3.0])]), 1);
        assert_eq!(estimator.counts().tracks_teleported, 1);
        assert_eq!((jumped.position_in_odom_m, jumped.velocity_in_odom_mps), ([1.0, 3.0], [0.0, 0.0]));
        assert_eq!(jumped.quality, ObstacleQuality::PositionOnly.code());
    }
}

/// Somebody on a circle, seen without noise 20 times a second, after 5 s.
fn on_a_circle(settings: EstimatorSettings, turn_radps: f64) -> Obstacle {
    let mut estimator = Estimator::new(settings);
    let mut newest = None;
    for k in 0..100 {
        let angle = turn_radps * 0.05 * k as f64;
        let at = [1.2 / turn_radps * angle.cos(), 1.2 / turn_radps * angle.sin()];
        newest = Some(of(&feed(&mut estimator, 50 * k, &[seen(1, at)]), 1));
    }
    newest.expect("somebody was seen")
}

#[test]
fn rates_are_those_of_the_believed_acceleration_within_the_bounds() {
    let unbounded = EstimatorSettings { max_heading_rate_radps: 9.0, max_speed_rate_mps2: 9.0, ..imm() };
    let turning = on_a_circle(unbounded, 0.3);
    let ([vx, vy], [ax, ay]) = (turning.velocity_in_odom_mps, turning.acceleration_in_odom_mps2);
    let speed2 = vx * vx + vy * vy;
    assert!(close(turning.heading_rate_radps, (vx * ay - vy * ax) / speed2));
    assert!(close(turning.speed_rate_mps2, (vx * ax + vy * ay) / speed2.sqrt()));
    assert!((turning.speed_mps - 1.2).abs() < 0.05, "{turning:?}");
    // A gentle turn passes for a disturbance of a straight walk: most of it is not believed, none is made up.
    assert!(turning.heading_rate_radps > 0.0 && turning.heading_rate_radps < 0.3, "{turning:?}");
    let bounded = on_a_circle(imm(), 1.5);
    assert_eq!(bounded.heading_rate_radps, 0.35);
    assert!(bounded.acceleration_in_odom_mps2.iter().all(|component| component.abs() <= 1.0));
    // One filter of constant velocity believes in no acceleration.
    let walking = on_a_circle(kalman(), 0.3);
    assert_eq!((walking.heading_rate_radps, walking.acceleration_in_odom_mps2), (0.0, [0.0, 0.0]));
}

#[test]
fn an_unseen_track_coasts_and_is_carried_on_across_a_gap_that_is_not_too_long() {
    let walk = |ms: u64| [seen(1, [ms as f64 * 1e-3, 0.0])];
    let mut estimator = Estimator::new(imm());
    for k in 0..40 {
        feed(&mut estimator, 50 * k, &walk(50 * k));
    }
    let coasting = of(&feed(&mut estimator, 2_150, &[]), 1);
    assert_eq!(coasting.quality, ObstacleQuality::Coasting.code());
    assert!((coasting.position_in_odom_m[0] - 2.15).abs() < 0.02, "{coasting:?}");
    assert_eq!((coasting.heading_rate_radps, coasting.acceleration_in_odom_mps2), (0.0, [0.0, 0.0]));
    // 400 ms after the last sighting: too long for a difference, not for a belief.
    let back = of(&feed(&mut estimator, 2_350, &walk(2_350)), 1);
    assert!((back.speed_mps - 1.0).abs() < 0.05, "{back:?}");
    assert_eq!(estimator.counts().tracks_interrupted, 0);
    // Perception was silent for longer than anybody coasts.
    let anew = of(&feed(&mut estimator, 2_900, &walk(2_900)), 1);
    assert_eq!((anew.speed_mps, anew.quality), (0.0, ObstacleQuality::PositionOnly.code()));
    assert_eq!(estimator.counts().tracks_interrupted, 1);
}

#[test]
fn a_belief_is_its_owners_however_many_come_and_go() {
    let mut random = Pcg64::new(8, 8);
    let mut together = Estimator::new(imm());
    let mut alone: Vec<_> = (0..60).map(|_| Estimator::new(imm())).collect();
    for k in 0..600_u64 {
        let at_ms = 50 * k;
        let mut people = Vec::new();
        for (person, estimator) in alone.iter_mut().enumerate() {
            let id = person as u64 + 1;
            // Present for two thirds of 6 s, then gone long enough to be forgotten, each at another time.
            let present = (k + 7 * id) % 120 < 80 && random.random::<f64>() > 0.1;
            let at = [id as f64 + at_ms as f64 * 1e-3, random.random_range(-0.1..0.1)];
            let own: &[Detection] = if present { &[seen(id, at)] } else { &[] };
            feed(estimator, at_ms, own);
            people.extend_from_slice(own);
        }
        let answer = feed(&mut together, at_ms, &people);
        for (person, estimator) in alone.iter_mut().enumerate() {
            let expected = *estimator.heartbeat(START_NS + (at_ms + 3) * MS);
            let found = answer.as_slice().iter().find(|found| found.track_id == person as u64 + 1);
            assert_eq!(
                found.map(|found| (found.velocity_in_odom_mps, found.quality)),
                expected.as_slice().first().map(|expected| (expected.velocity_in_odom_mps, expected.quality))
            );
        }
    }
    assert!(together.counts().tracks_dropped > 200, "{:?}", together.counts());
}

#[test]
fn anonymous_sightings_are_paired_as_a_whole() {
    let noise = NoiseSettings { position_sd_m: 0.1, ..NOISE };
    let mut estimator = Estimator::new(EstimatorSettings { noise: Some(noise), ..kalman() });
    for k in 0..40 {
        feed(&mut estimator, 50 * k, &[seen(0, [0.0, 0.0]), seen(0, [0.3, 0.0])]);
    }
    // The first one is nearest to the second track, which would leave the second one to nobody.
    let answer = feed(&mut estimator, 2_000, &[seen(0, [0.16, 0.0]), seen(0, [0.46, 0.0])]);
    assert_eq!(ids(&answer).len(), 2);
    assert_eq!(estimator.counts().tracks_started, 2);
}
