//! The weights the paper's authors published for the quadrotor, where a copy lies beside the checkout.
//!
//! Judged against the closed form of that pair's value function: the robot out-accelerates the obstacle by
//! 1 m/s² per axis, so `V = max over constant a in [−1, 1]² of min over t of |p + v t + a t²/2|, minus R`.
#![allow(clippy::unwrap_used)] // helpers of a test may panic

mod common;

use barrier::{Kernel, Model, ModelMetadata, RelativeBarrier, RelativeObstacle, RelativeSample};
use common::rng;
use rand::RngExt;

fn closed_form(z: &[f64; 4], radius_m: f64) -> f64 {
    let mut best = f64::NEG_INFINITY;
    for ix in -8..=8 {
        for iy in -8..=8 {
            let (ax, ay) = (f64::from(ix) / 8.0, f64::from(iy) / 8.0);
            let worst = (0..=160)
                .map(|step| {
                    let t = f64::from(step) * 0.05;
                    let (x, y) = (z[0] + z[2] * t + ax * t * t / 2.0, z[1] + z[3] * t + ay * t * t / 2.0);
                    x.hypot(y)
                })
                .fold(f64::INFINITY, f64::min);
            best = best.max(worst);
        }
    }
    best - radius_m
}

#[test]
fn the_published_quadrotor_weights_load_and_fit_the_closed_form() {
    let path =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/anchors/quadrotor_published_v1.safetensors");
    let Ok(bytes) = std::fs::read(path) else {
        println!("skipped: no published weights beside the checkout");
        return;
    };
    assert!(Model::from_bytes(&bytes).is_err(), "without metadata only `from_published` takes them");
    let stated: ModelMetadata =
        serde_json::from_str(include_str!("../examples/quadrotor_published.json")).unwrap();
    let model = Model::from_published(&bytes, stated).unwrap();
    let again = Model::from_bytes(&model.to_bytes().unwrap()).unwrap();
    assert_eq!(again, model, "with its metadata it is a model file like any other");
    let mut barrier = RelativeBarrier::new(&model, Kernel::detect()).unwrap();

    let mut rng = rng(1);
    let (mut errors, mut count) = (0.0, 0);
    while count < 400 {
        let mut within = |bound: f64| rng.random_range(-bound..bound);
        let z = [within(3.5), within(3.5), within(3.0), within(3.0)];
        let mut sample = [RelativeSample::default()];
        barrier.evaluate(&[RelativeObstacle { z, radius_m: 0.7 }], &mut sample);
        if sample[0].sdf > 0.0 {
            errors += (sample[0].h_bar - closed_form(&z, 0.7)).abs();
            count += 1;
        }
    }
    let mean_m = errors / f64::from(count);
    println!("published weights against the closed form: mean error {mean_m:.4} m");
    assert!(mean_m < 0.02, "{mean_m}");
}
