//! A frame, a refused frame and a heartbeat allocate nothing, however many tracks come and go.

mod support;

use allocation_counter::measure;
use obstacle_estimator::Estimator;
use settings::EstimatorSettings;
use support::{MS, START_NS, frame, imm, kalman, learning, moving, provided, seen};

#[test]
fn nothing_is_allocated_after_construction() {
    for settings in [provided(), kalman(), imm(), learning()] {
        allocates_nothing(settings);
    }
}

fn allocates_nothing(settings: EstimatorSettings) {
    let mut estimator = Estimator::new(settings);
    let frames: Vec<_> = (0..300_u64)
        .map(|k| {
            let shift = k as f64 * 0.05;
            // A full house first, so that tracks are evicted; then room enough for them to be dropped.
            let people: Vec<_> = (0..if k < 150 { 64_u64 } else { 30 })
                .map(|i| {
                    let at = [i as f64 + shift, if k % 7 == 0 { 50.0 } else { 0.0 }];
                    match i % 3 {
                        0 => seen(0, at),
                        1 => moving(i + k / 20 * 64, at, [1.0, 0.0]),
                        _ => seen(i, [if k % 11 == 0 { f64::NAN } else { at[0] }, at[1]]),
                    }
                })
                .collect();
            frame(if k % 13 == 12 { 50 * k - 500 } else { 50 * k }, &people)
        })
        .collect();
    assert_eq!(measure(|| drop(std::hint::black_box(vec![1_u8; 100]))).count_total, 1, "the counter counts");
    let of_stepping = measure(|| {
        for (k, frame) in frames.iter().enumerate() {
            let now_ns = START_NS + 50 * k as u64 * MS + MS;
            estimator.step(frame, now_ns);
            estimator.heartbeat(now_ns + 25 * MS);
        }
    });
    assert_eq!(of_stepping.count_total, 0);
    let counts = estimator.counts();
    assert!(
        counts.tracks_evicted > 0 && counts.tracks_teleported > 0 && counts.frames_out_of_order > 0,
        "{counts:?}"
    );
    assert!(counts.tracks_dropped > 0 && counts.detections_malformed > 0, "{counts:?}");
}
