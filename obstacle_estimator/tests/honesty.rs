//! Whether the filters are as uncertain as they say: normalised errors against χ², over many seeded runs.
//!
//! The normalised estimation error squared (NEES) of a consistent filter averages the number of its components, the
//! normalised innovation squared (NIS) that of a sighting: Bar-Shalom's tests.

mod support;

use nalgebra::{Matrix2, Vector2, Vector4};
use obstacle_estimator::motion::{MotionFilter, Sighting};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use settings::{EstimatorSettings, ManoeuvreSettings, NoiseSettings};
use support::{NOISE, imm, kalman};

const RUNS: u64 = 400;
const SIGHTINGS: u64 = 60;

fn normal(random: &mut Pcg64) -> Vector2<f64> {
    Vector2::from_fn(|_, _| StandardNormal.sample(random))
}

/// Means over all runs and sightings of NEES (position and velocity) and NIS.
struct Consistency {
    nees: f64,
    nis: f64,
}

/// Somebody whose acceleration `accelerate` draws for every interval, kept until the next one, seen with the noise that the
/// filter expects.
fn consistency(
    settings: &EstimatorSettings,
    interval_s: f64,
    believed_sd_m: f64,
    mut accelerate: impl FnMut(&mut Pcg64) -> Vector2<f64>,
) -> Consistency {
    let noise = NoiseSettings { position_sd_m: believed_sd_m, ..NOISE };
    let filter = MotionFilter::new(&EstimatorSettings { noise: Some(noise), ..settings.clone() })
        .expect("the settings ask for a filter");
    let covariance_m2 = Matrix2::from_diagonal_element(believed_sd_m * believed_sd_m);
    let (mut nees, mut nis) = (0.0, 0.0);
    for run in 0..RUNS {
        let mut random = Pcg64::new(run.into(), 21);
        let mut position = Vector2::zeros();
        let mut velocity = normal(&mut random) * NOISE.initial_speed_sd_mps;
        let see = |position: Vector2<f64>, random: &mut Pcg64| Sighting {
            position_m: position + normal(random) * NOISE.position_sd_m,
            covariance_m2,
        };
        let mut belief = filter.begin(&see(position, &mut random));
        for _ in 0..SIGHTINGS {
            let acceleration = accelerate(&mut random);
            position += velocity * interval_s + acceleration * (interval_s * interval_s / 2.0);
            velocity += acceleration * interval_s;
            let sighting = see(position, &mut random);
            nis += filter.forecast(&belief, interval_s).surprise(&sighting).0;
            filter.update(&mut belief, interval_s, &sighting);
            let found = filter.estimate(&belief, 0.0);
            let error =
                Vector4::new(position.x, position.y, velocity.x, velocity.y) - found.mean.fixed_rows::<4>(0);
            let covariance = found.covariance.fixed_view::<4, 4>(0, 0).into_owned();
            let inverse = covariance.try_inverse().expect("the covariance is positive definite");
            nees += error.dot(&(inverse * error));
        }
    }
    let n = (RUNS * SIGHTINGS) as f64;
    Consistency { nees: nees / n, nis: nis / n }
}

/// Half-width of the 99.9 % interval of the mean of `RUNS` runs of NEES; χ² of k degrees has the variance 2k. Errors within a run
/// are related, so runs count, not sightings.
fn tolerance(degrees: f64) -> f64 {
    3.29 * (2.0 * degrees / RUNS as f64).sqrt()
}

#[test]
fn the_kalman_filter_is_as_uncertain_as_it_says() {
    let q = kalman().kalman.expect("kalman settings").acceleration_sd_mps2;
    for interval_s in [0.05, 0.1] {
        let found = consistency(&kalman(), interval_s, NOISE.position_sd_m, |random| normal(random) * q);
        assert!((found.nees - 4.0).abs() < tolerance(4.0), "NEES {}", found.nees);
        // Innovations of a consistent filter are white, so each counts.
        let of_nis = 3.29 * (4.0 / (RUNS * SIGHTINGS) as f64).sqrt();
        assert!((found.nis - 2.0).abs() < of_nis, "NIS {} ± {of_nis}", found.nis);
    }
}

#[test]
fn whoever_believes_in_better_eyes_than_there_are_is_caught() {
    let q = kalman().kalman.expect("kalman settings").acceleration_sd_mps2;
    let found = consistency(&kalman(), 0.05, 0.5 * NOISE.position_sd_m, |random| normal(random) * q);
    assert!(found.nees > 4.0 + tolerance(4.0) && found.nis > 2.5, "NEES {}, NIS {}", found.nees, found.nis);
}

/// Who walks now calmly and now in a lively way, as the models have it.
#[test]
fn the_interacting_models_are_nearly_as_uncertain_as_they_say() {
    let imm_of_two = EstimatorSettings {
        imm: imm().imm.map(|imm| settings::ImmSettings { manoeuvre: None::<ManoeuvreSettings>, ..imm }),
        ..imm()
    };
    let models = imm_of_two.imm.expect("imm settings");
    for interval_s in [0.05, 0.1] {
        let mut lively = false;
        let leaving = 0.5 * (1.0 - (-2.0 * interval_s / models.mean_stay_s).exp());
        let found = consistency(&imm_of_two, interval_s, NOISE.position_sd_m, |random| {
            lively ^= random.random::<f64>() < leaving;
            normal(random)
                * if lively { models.lively_acceleration_sd_mps2 } else { models.calm_acceleration_sd_mps2 }
        });
        // A mixture is no normal distribution, so its NEES follows χ² only nearly: 10 % are allowed for that.
        assert!((found.nees - 4.0).abs() < 0.4, "NEES {}", found.nees);
        assert!((found.nis - 2.0).abs() < 0.2, "NIS {}", found.nis);
    }
}
