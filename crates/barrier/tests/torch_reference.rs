//! The network against PyTorch; numbers stored by `tests/judges/torch_barrier_reference.py`.
#![allow(clippy::unwrap_used)] // helpers of a test may panic

mod common;

use barrier::{InputEncoding, Kernel, Model, ModelFileError, NetworkBatch, ResidualNetwork};
use safetensors::SafeTensors;

fn stored() -> Vec<u8> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/barrier_torch_reference.safetensors");
    std::fs::read(path).unwrap()
}

fn f64s(tensors: &SafeTensors<'_>, name: &str) -> Vec<f64> {
    let data = tensors.tensor(name).unwrap().data();
    data.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect()
}

fn f32s(tensors: &SafeTensors<'_>, name: &str) -> Vec<f32> {
    let data = tensors.tensor(name).unwrap().data();
    data.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect()
}

#[test]
fn values_and_gradients_agree_with_torch_to_1e_4() {
    let bytes = stored();
    let tensors = SafeTensors::deserialize(&bytes).unwrap();
    let layers = (0..7)
        .map(|index| barrier::LayerWeights {
            weight: f32s(&tensors, &format!("layers.{index}.weight")),
            bias: f32s(&tensors, &format!("layers.{index}.bias")),
        })
        .collect();
    let weights = barrier::NetworkWeights::new(InputEncoding::Raw, layers).unwrap();
    let (inputs, residuals) = (f32s(&tensors, "inputs"), f64s(&tensors, "residual"));
    let gradients = f64s(&tensors, "gradient");
    assert_eq!(residuals.len(), 200);

    for kernel in Kernel::ALL.into_iter().filter(|kernel| kernel.is_supported()) {
        let mut network = ResidualNetwork::new(&weights, kernel).unwrap();
        let mut batch = NetworkBatch::new();
        let (mut worst_value, mut worst_gradient) = (0.0_f64, 0.0_f64);
        for (index, z) in inputs.as_chunks::<4>().0.iter().enumerate() {
            batch.set_len(1);
            batch.set_state(0, z);
            network.evaluate(&mut batch);
            worst_value = worst_value.max((f64::from(batch.residual(0)) - residuals[index]).abs());
            for k in 0..4 {
                let error = (f64::from(batch.gradient(0)[k]) - gradients[4 * index + k]).abs();
                worst_gradient = worst_gradient.max(error);
            }
        }
        println!("{kernel} against torch: value {worst_value:.1e}, gradient {worst_gradient:.1e}");
        assert!(worst_value < 1e-4 && worst_gradient < 1e-4, "{kernel}: {worst_value:e} {worst_gradient:e}");
    }
}

#[test]
fn the_judge_s_file_is_no_model() {
    assert!(matches!(Model::from_bytes(&stored()), Err(ModelFileError::MissingMetadata)));
    let error = Model::from_published(&stored(), common::ground_robot_metadata()).unwrap_err();
    assert!(matches!(error, ModelFileError::ExtraTensor { .. }), "{error}");
}
