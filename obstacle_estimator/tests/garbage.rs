//! Whatever perception sends, the answer is sound: seeded random frames, most of them nonsense.

mod support;

use std::collections::BTreeSet;

use messages::Obstacles;
use obstacle_estimator::Estimator;
use rand::RngExt;
use rand_pcg::Pcg64;
use settings::EstimatorSettings;
use support::{MS, START_NS, frame, imm, kalman, provided, seen, settings};

const ODD: [f64; 14] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    5e-324,
    -0.0,
    0.0,
    1e6,
    -1e6,
    1e-300,
    1e154,
    0.3,
];

fn number(random: &mut Pcg64) -> f64 {
    match random.random_range(0..10) {
        0..4 => random.random_range(-5.0..5.0),
        4..7 => ODD[random.random_range(0..ODD.len())],
        7..9 => random.random_range(0.01..1.0),
        _ => f64::from_bits(random.random()),
    }
}

fn assert_sound(obstacles: &Obstacles, settings: &EstimatorSettings) {
    assert!(obstacles.count as usize == obstacles.as_slice().len());
    let mut ids = BTreeSet::new();
    for obstacle in obstacles.as_slice() {
        assert!(obstacle.is_sound(), "{obstacle:?}");
        assert!(obstacle.track_id != 0 && ids.insert(obstacle.track_id), "{obstacle:?}");
        assert!(obstacle.speed_mps <= settings.teleport_speed_mps * 1.000_001, "{obstacle:?}");
        assert!(obstacle.heading_rate_radps.abs() <= settings.max_heading_rate_radps);
        assert!(obstacle.speed_rate_mps2.abs() <= settings.max_speed_rate_mps2);
        assert!((-std::f64::consts::PI..std::f64::consts::PI).contains(&obstacle.heading_rad));
        assert!(obstacle.valid_at_ns >= obstacle.measured_at_ns);
    }
}

fn hurl_garbage(seed: u64, settings: &EstimatorSettings) {
    let mut random = Pcg64::new(seed.into(), 1);
    let mut estimator = Estimator::new(settings.clone());
    let (mut now_ns, mut sent, mut frames) = (START_NS, 0_u64, 0_u64);
    for _ in 0..400 {
        now_ns += random.random_range(0..60 * MS);
        let mut items = vec![seen(0, [0.0, 0.0]); random.random_range(0..=64)];
        for item in &mut items {
            item.track_id = if random.random() { random.random_range(0..90) } else { random.random() };
            item.position_in_odom_m = [number(&mut random), number(&mut random)];
            item.velocity_in_odom_mps = [number(&mut random), number(&mut random)];
            item.position_covariance_m2 = std::array::from_fn(|_| number(&mut random));
            item.radius_m = number(&mut random);
            item.flags = random.random();
            item.class = random.random();
        }
        let mut garbage = frame(0, &items);
        garbage.stamp.valid_at_ns = match random.random_range(0..20) {
            0 => random.random(),
            1 => now_ns - 200 * MS,
            2 => 0,
            _ => now_ns - random.random_range(0..5),
        };
        garbage.left_out = random.random();
        let used_before = estimator.counts().frames_used;
        assert_sound(estimator.step(&garbage, now_ns), settings);
        frames += 1;
        sent += if estimator.counts().frames_used > used_before { items.len() as u64 } else { 0 };
        if random.random() {
            let later_ns = now_ns.saturating_add(random.random_range(0..600 * MS));
            assert_sound(estimator.heartbeat(later_ns), settings);
        }
    }
    // Nothing is lost without a counter.
    let counts = estimator.counts();
    assert_eq!(sent, counts.detections_used + counts.detections_malformed + counts.detections_duplicate);
    let refused = counts.frames_out_of_order + counts.frames_duplicate + counts.frames_from_future;
    assert_eq!(frames, counts.frames_used + refused);
    assert!(
        counts.frames_used > 100 && counts.tracks_teleported > 0 && counts.tracks_evicted > 0,
        "{counts:?}"
    );
}

#[test]
fn random_garbage_never_yields_an_unsound_obstacle() {
    for seed in 0..20 {
        hurl_garbage(seed, &settings());
        hurl_garbage(seed, &provided());
        hurl_garbage(seed, &kalman());
        hurl_garbage(seed, &imm());
    }
}

#[test]
fn the_same_frames_give_the_same_bytes() {
    let run = |settings: EstimatorSettings| {
        let mut random = Pcg64::new(3, 1);
        let mut estimator = Estimator::new(settings);
        let mut bytes = Vec::new();
        for k in 0..200 {
            let items: Vec<_> = (0..64)
                .map(|i| seen(i % 40, [random.random_range(-3.0..3.0), random.random_range(-3.0..3.0)]))
                .collect();
            bytes.extend_from_slice(bytemuck::bytes_of(&support::feed(&mut estimator, 50 * k, &items)));
        }
        bytes
    };
    for settings in [settings(), kalman(), imm()] {
        assert!(run(settings.clone()) == run(settings));
    }
}
