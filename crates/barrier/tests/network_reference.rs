//! The network on every kernel against the scalar `f64` judge, and the kernels against each other.
#![allow(clippy::unwrap_used)] // helpers of a test may panic

mod common;

use barrier::{Kernel, NetworkBatch, ResidualNetwork};
use common::{central_differences, random_weights, reference_residual, rng};
use rand::RngExt;

fn kernels() -> impl Iterator<Item = Kernel> {
    Kernel::ALL.into_iter().filter(|kernel| kernel.is_supported())
}

fn random_states(seed: u64, count: usize) -> Vec<[f32; 4]> {
    let mut rng = rng(seed);
    let mut within = |bound: f32| rng.random_range(-bound..bound);
    (0..count).map(|_| [within(6.0), within(6.0), within(3.1), within(1.5)]).collect()
}

fn evaluate(network: &mut ResidualNetwork, states: &[[f32; 4]]) -> Vec<(f32, [f32; 4])> {
    let mut batch = NetworkBatch::new();
    batch.set_len(states.len());
    for (index, z) in states.iter().enumerate() {
        batch.set_state(index, z);
    }
    network.evaluate(&mut batch);
    (0..states.len()).map(|index| (batch.residual(index), batch.gradient(index))).collect()
}

#[test]
fn values_and_gradients_agree_with_the_scalar_judge() {
    for kernel in kernels() {
        let (mut worst_value, mut worst_gradient) = (0.0_f64, 0.0_f64);
        for seed in 0..4 {
            let weights = random_weights(seed, 3.0);
            let mut network = ResidualNetwork::new(&weights, kernel).unwrap();
            let states = random_states(100 + seed, 64);
            for (z, (value, gradient)) in states.iter().zip(evaluate(&mut network, &states)) {
                let z = z.map(f64::from);
                worst_value = worst_value.max((f64::from(value) - reference_residual(&weights, &z)).abs());
                let exact = central_differences(&z, |z| reference_residual(&weights, z));
                for k in 0..4 {
                    worst_gradient = worst_gradient.max((f64::from(gradient[k]) - exact[k]).abs());
                }
            }
        }
        println!("{kernel}: value {worst_value:.1e}, gradient {worst_gradient:.1e}");
        assert!(worst_value < 1e-5 && worst_gradient < 1e-4, "{kernel}: {worst_value:e} {worst_gradient:e}");
    }
}

#[test]
fn kernels_agree_with_each_other() {
    let weights = random_weights(7, 3.0);
    let states = random_states(8, 64);
    let mut results =
        kernels().map(|kernel| evaluate(&mut ResidualNetwork::new(&weights, kernel).unwrap(), &states));
    let portable = results.next().unwrap();
    for other in results {
        for (a, b) in portable.iter().zip(&other) {
            assert!((a.0 - b.0).abs() < 1e-5, "{a:?} {b:?}");
            let scale = 1.0 + a.1.iter().map(|v| v.abs()).fold(0.0, f32::max);
            assert!((0..4).all(|k| (a.1[k] - b.1[k]).abs() < 1e-5 * scale), "{a:?} {b:?}");
        }
    }
}

#[test]
fn a_state_gives_the_same_bits_whatever_stands_beside_it() {
    let weights = random_weights(9, 3.0);
    let states = random_states(10, 64);
    for kernel in kernels() {
        let mut network = ResidualNetwork::new(&weights, kernel).unwrap();
        let all = evaluate(&mut network, &states);
        for len in 1..=64 {
            assert_eq!(evaluate(&mut network, &states[..len]), all[..len], "{kernel}, {len} states");
        }
    }
}

#[test]
fn values_alone_equal_values_with_gradients() {
    let weights = random_weights(11, 3.0);
    let states = random_states(12, 37);
    for kernel in kernels() {
        let mut network = ResidualNetwork::new(&weights, kernel).unwrap();
        let with = evaluate(&mut network, &states);
        let mut batch = NetworkBatch::new();
        batch.set_len(states.len());
        for (index, z) in states.iter().enumerate() {
            batch.set_state(index, z);
        }
        network.evaluate_values(&mut batch);
        assert!((0..states.len()).all(|index| batch.residual(index) == with[index].0));
    }
}
