//! The network on every kernel against the scalar `f64` judge, and the kernels against each other.
#![allow(clippy::unwrap_used)] // helpers of a test may panic

mod common;

use barrier::{InputEncoding, Kernel, Model, NetworkBatch, NetworkWeights, ResidualNetwork};
use common::{central_differences, random_encoded_weights, random_weights, reference_residual, rng};
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

/// Every kernel on every encoding, with the names for messages.
fn kernels_and_encodings() -> impl Iterator<Item = (Kernel, InputEncoding)> {
    kernels().flat_map(|kernel| InputEncoding::ALL.map(|encoding| (kernel, encoding)))
}

#[test]
fn values_and_gradients_agree_with_the_scalar_judge() {
    for (kernel, encoding) in kernels_and_encodings() {
        let (mut worst_value, mut worst_gradient) = (0.0_f64, 0.0_f64);
        for seed in 0..4 {
            let weights = random_encoded_weights(encoding, seed, 3.0);
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
        println!("{kernel}, {encoding}: value {worst_value:.1e}, gradient {worst_gradient:.1e}");
        assert!(worst_value < 1e-5 && worst_gradient < 1e-4, "{kernel}: {worst_value:e} {worst_gradient:e}");
    }
}

/// Largest difference of the kernels from the portable one: of values, and of gradients as a share of `1 + |∇r|`.
fn disagreement(weights: &NetworkWeights, seeds: std::ops::Range<u64>) -> [f32; 2] {
    let mut worst = [0.0_f32; 2];
    for seed in seeds {
        let states = random_states(seed, 64);
        let results =
            kernels().map(|kernel| evaluate(&mut ResidualNetwork::new(weights, kernel).unwrap(), &states));
        let results: Vec<_> = results.collect();
        for (a, b) in results[1..].iter().flat_map(|other| results[0].iter().zip(other)) {
            let scale = 1.0 + a.1.iter().map(|v| v.abs()).fold(0.0, f32::max);
            let gradient = (0..4).map(|k| (a.1[k] - b.1[k]).abs()).fold(0.0, f32::max) / scale;
            worst = [worst[0].max((a.0 - b.0).abs()), worst[1].max(gradient)];
        }
    }
    worst
}

#[test]
fn kernels_agree_with_each_other() {
    for encoding in InputEncoding::ALL {
        // Scale 3 is beyond trained networks: its gradients of size 10 magnify the rounding of f32 fifty times.
        for (scale, gradient_bound) in [(1.0, 1e-6), (2.0, 1e-5), (3.0, 1e-4)] {
            let worst = disagreement(&random_encoded_weights(encoding, 7, scale), 8..208);
            println!("random {encoding} network of scale {scale}: {:.1e} and {:.1e}", worst[0], worst[1]);
            assert!(worst[0] < 1e-5 && worst[1] < gradient_bound, "{encoding}, {scale}: {worst:?}");
        }
    }
    for name in ["ground_robot", "ground_robot_paper"] {
        let file = format!("{}/../../models/{name}.safetensors", env!("CARGO_MANIFEST_DIR"));
        let model = Model::load(file.as_ref()).unwrap();
        let worst = disagreement(model.weights(), 8..408);
        println!("{name}: kernels differ by {:.1e} and {:.1e}", worst[0], worst[1]);
        assert!(worst[0] < 1e-5 && worst[1] < 1e-5, "{name}: {worst:?}");
    }
}

#[test]
fn the_heading_as_cosine_and_sine_leaves_no_seam_and_the_raw_angle_does() {
    let seam = |encoding: InputEncoding| {
        let weights = random_encoded_weights(encoding, 21, 3.0);
        let mut network = ResidualNetwork::new(&weights, Kernel::detect()).unwrap();
        let (mut left, mut right) = (random_states(22, 64), random_states(22, 64));
        for (left, right) in left.iter_mut().zip(&mut right) {
            (left[2], right[2]) = (-std::f32::consts::PI, std::f32::consts::PI);
        }
        let both = evaluate(&mut network, &left).into_iter().zip(evaluate(&mut network, &right));
        both.map(|(left, right)| (left.0 - right.0).abs()).fold(0.0, f32::max)
    };
    let (raw, periodic) = (seam(InputEncoding::Raw), seam(InputEncoding::HeadingCosSin));
    println!("seam at ±π of random networks: raw {raw:.2e} m, cosine and sine {periodic:.2e} m");
    assert!(periodic < 1e-5 && raw > 0.01, "{periodic:e} {raw:e}");
}

#[test]
fn a_position_network_does_not_see_the_other_components() {
    let weights = random_encoded_weights(InputEncoding::Position, 23, 3.0);
    for kernel in kernels() {
        let mut network = ResidualNetwork::new(&weights, kernel).unwrap();
        let states = random_states(24, 64);
        let still: Vec<_> = states.iter().map(|z| [z[0], z[1], 0.0, 0.0]).collect();
        let out = evaluate(&mut network, &states);
        assert_eq!(out, evaluate(&mut network, &still));
        assert!(out.iter().all(|(_, gradient)| gradient[2..] == [0.0; 2]));
    }
}

#[test]
fn the_two_fused_kernels_give_the_same_bits() {
    if !(Kernel::Avx512.is_supported() && Kernel::Avx2Fma.is_supported()) {
        println!("skipped: this processor runs at most one of them");
        return;
    }
    for encoding in InputEncoding::ALL {
        let weights = random_encoded_weights(encoding, 25, 3.0);
        let mut networks =
            [Kernel::Avx2Fma, Kernel::Avx512].map(|k| ResidualNetwork::new(&weights, k).unwrap());
        for count in [1, 8, 9, 16, 17, 31, 32, 33, 47, 64] {
            let states = random_states(26 + count as u64, count);
            let [eight, sixteen] = networks.each_mut().map(|network| evaluate(network, &states));
            assert_eq!(eight, sixteen, "{encoding}, {count} states");
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
