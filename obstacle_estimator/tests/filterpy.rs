//! The filters against filterpy (`tests/judges/estimators_reference.py`), and against what is known in closed form.

mod support;

use nalgebra::{Matrix2, Vector2};
use obstacle_estimator::motion::{Belief, MAX_MODELS, MotionFilter, Sighting};
use serde::Deserialize;
use settings::{EstimatorSettings, KalmanSettings, NoiseSettings};
use support::{NOISE, imm, kalman};

#[derive(Deserialize)]
struct Reference {
    sightings: Vec<Seen>,
    kalman: Vec<Kept>,
    imm: Vec<Kept>,
}

#[derive(Deserialize)]
struct Seen {
    elapsed_s: f64,
    position_m: [f64; 2],
    covariance_m2: [[f64; 2]; 2],
}

#[derive(Deserialize)]
struct Kept {
    after: usize,
    mean: [f64; 6],
    covariance: [[f64; 6]; 6],
    probabilities: Option<[f64; MAX_MODELS]>,
}

impl Seen {
    fn sighting(&self) -> Sighting {
        let [[xx, xy], [yx, yy]] = self.covariance_m2;
        Sighting { position_m: self.position_m.into(), covariance_m2: Matrix2::new(xx, xy, yx, yy) }
    }
}

fn reference() -> Reference {
    serde_json::from_str(include_str!("../../tests/data/estimators_reference.json"))
        .expect("the stored numbers are JSON")
}

fn compare(settings: &EstimatorSettings, seen: &[Seen], kept: &[Kept]) {
    let filter = MotionFilter::new(settings).expect("the settings ask for a filter");
    let mut belief = filter.begin(&seen[0].sighting());
    let mut compared = 0;
    for (k, next) in seen.iter().enumerate().skip(1) {
        filter.update(&mut belief, next.elapsed_s, &next.sighting());
        let Some(expected) = kept.iter().find(|kept| kept.after == k) else { continue };
        let found = filter.estimate(&belief, 0.0);
        for i in 0..6 {
            let difference = (found.mean[i] - expected.mean[i]).abs();
            assert!(difference < 1e-9, "sighting {k}, mean {i}: off by {difference:e}");
            for j in 0..6 {
                let difference = (found.covariance[(i, j)] - expected.covariance[i][j]).abs();
                assert!(difference < 1e-9, "sighting {k}, covariance {i} {j}: off by {difference:e}");
            }
        }
        if let Some(probabilities) = expected.probabilities {
            for (found, expected) in belief.probabilities().iter().zip(probabilities) {
                assert!((found - expected).abs() < 1e-9, "sighting {k}: {found} instead of {expected}");
            }
        }
        compared += 1;
    }
    assert_eq!(compared, 11);
}

#[test]
fn the_kalman_filter_is_filterpys() {
    let Reference { sightings, kalman: kept, .. } = reference();
    compare(&kalman(), &sightings, &kept);
}

#[test]
fn the_interacting_models_are_filterpys() {
    let Reference { sightings, imm: kept, .. } = reference();
    compare(&imm(), &sightings, &kept);
}

/// A belief after many sightings at regular intervals.
fn settled(filter: &MotionFilter, interval_s: f64, sd_m: f64) -> Belief {
    let sighting =
        Sighting { position_m: Vector2::zeros(), covariance_m2: Matrix2::from_diagonal_element(sd_m * sd_m) };
    let mut belief = filter.begin(&sighting);
    (0..2000).for_each(|_| filter.update(&mut belief, interval_s, &sighting));
    belief
}

#[test]
fn the_kalman_filter_settles_where_the_closed_form_says() {
    for q in [0.3, 1.0, 2.0] {
        for s in [0.02, 0.05, 0.10, 0.15] {
            for t in [0.05, 0.1] {
                let noise = NoiseSettings { position_sd_m: s, ..NOISE };
                let filter = MotionFilter::kalman(&KalmanSettings { acceleration_sd_mps2: q }, &noise);
                let found = filter.estimate(&settled(&filter, t, s), 0.0).covariance;
                // The α-β filter's steady state, by the manoeuvring index Λ.
                let index: f64 = q * t * t / s;
                let r = (4.0 + index - (8.0 * index + index * index).sqrt()) / 4.0;
                let alpha = 1.0 - r * r;
                let beta = 2.0 * (2.0 - alpha) - 4.0 * (1.0 - alpha).sqrt();
                let position = alpha * s * s;
                let velocity = beta * (2.0 * alpha - beta) / (2.0 * (1.0 - alpha)) * (s / t).powi(2);
                for axis in 0..2 {
                    assert!((found[(axis, axis)] / position - 1.0).abs() < 1e-9);
                    assert!((found[(2 + axis, 2 + axis)] / velocity - 1.0).abs() < 1e-9);
                }
            }
        }
    }
}

#[test]
fn a_forecast_is_the_estimate_without_what_nobody_asks_for() {
    let filter = MotionFilter::new(&imm()).expect("the settings ask for a filter");
    let seen = reference().sightings;
    let mut belief = filter.begin(&seen[0].sighting());
    for next in &seen[1..] {
        filter.update(&mut belief, next.elapsed_s, &next.sighting());
        for ahead_s in [0.0, 0.03, 0.4] {
            let (short, long) = (filter.forecast(&belief, ahead_s), filter.estimate(&belief, ahead_s));
            assert!((short.mean - long.mean).amax() < 1e-12);
            let position = long.covariance.fixed_view::<2, 2>(0, 0);
            assert!((short.position_covariance_m2 - position).amax() < 1e-12);
        }
    }
}
