//! The network against PyTorch, and weights there and back; numbers stored by `tests/judges/torch_barrier_reference.py`,
//! the model file by `tests/judges/torch_weights_exchange.py` and `examples/from_published.rs`.
#![allow(clippy::unwrap_used)] // helpers of a test may panic

mod common;

use barrier::{
    InputEncoding, Kernel, LayerWeights, Model, ModelFileError, ModelMetadata, NetworkBatch, NetworkWeights,
    ResidualNetwork,
};
use safetensors::SafeTensors;

const RAW: &str = "barrier_torch_reference";
const COS_SIN: &str = "barrier_torch_cos_sin_reference";

fn stored(name: &str) -> Vec<u8> {
    let path = format!("{}/../../tests/data/{name}.safetensors", env!("CARGO_MANIFEST_DIR"));
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

fn weights(tensors: &SafeTensors<'_>, encoding: InputEncoding) -> NetworkWeights {
    let layers = (0..7)
        .map(|index| LayerWeights {
            weight: f32s(tensors, &format!("layers.{index}.weight")),
            bias: f32s(tensors, &format!("layers.{index}.bias")),
        })
        .collect();
    NetworkWeights::new(encoding, layers).unwrap()
}

/// Largest error of residual and gradient of `weights` on `kernel` against what PyTorch stored in `tensors`.
fn errors(tensors: &SafeTensors<'_>, weights: &NetworkWeights, kernel: Kernel) -> [f64; 2] {
    let (inputs, residuals) = (f32s(tensors, "inputs"), f64s(tensors, "residual"));
    let gradients = f64s(tensors, "gradient");
    assert_eq!(residuals.len(), 200);
    let mut network = ResidualNetwork::new(weights, kernel).unwrap();
    let mut batch = NetworkBatch::new();
    let mut worst = [0.0_f64; 2];
    for (index, z) in inputs.as_chunks::<4>().0.iter().enumerate() {
        batch.set_len(1);
        batch.set_state(0, z);
        network.evaluate(&mut batch);
        worst[0] = worst[0].max((f64::from(batch.residual(0)) - residuals[index]).abs());
        for k in 0..4 {
            worst[1] = worst[1].max((f64::from(batch.gradient(0)[k]) - gradients[4 * index + k]).abs());
        }
    }
    worst
}

#[test]
fn values_agree_with_torch_to_1e_5_and_gradients_to_1e_4() {
    for (name, encoding) in [(RAW, InputEncoding::Raw), (COS_SIN, InputEncoding::HeadingCosSin)] {
        let bytes = stored(name);
        let tensors = SafeTensors::deserialize(&bytes).unwrap();
        let weights = weights(&tensors, encoding);
        for kernel in Kernel::ALL.into_iter().filter(|kernel| kernel.is_supported()) {
            let [value, gradient] = errors(&tensors, &weights, kernel);
            println!("{encoding}, {kernel} against torch: value {value:.1e}, gradient {gradient:.1e}");
            assert!(value < 1e-5 && gradient < 1e-4, "{encoding}, {kernel}: {value:e} {gradient:e}");
        }
    }
}

#[test]
fn weights_that_torch_wrote_make_a_model_that_torch_reads() {
    let (reference, file) = (stored(COS_SIN), stored("barrier_torch_model"));
    let tensors = SafeTensors::deserialize(&reference).unwrap();
    let model = Model::from_bytes(&file).unwrap();
    assert_eq!(*model.weights(), weights(&tensors, InputEncoding::HeadingCosSin), "not one bit changed");
    assert_eq!(model.to_bytes().unwrap(), file, "writing again gives the file that torch was shown");
    let metadata = include_str!("../examples/ground_robot_cos_sin.json");
    let metadata: ModelMetadata = serde_json::from_str(metadata).unwrap();
    let made = Model::new(weights(&tensors, InputEncoding::HeadingCosSin), metadata).unwrap();
    assert_eq!(made, model, "the example's metadata made it");
}

#[test]
fn the_judge_s_file_is_no_model() {
    assert!(matches!(Model::from_bytes(&stored(RAW)), Err(ModelFileError::MissingMetadata)));
    let error = Model::from_published(&stored(RAW), common::ground_robot_metadata()).unwrap_err();
    assert!(matches!(error, ModelFileError::ExtraTensor { .. }), "{error}");
}

#[test]
fn weights_of_another_encoding_are_refused_with_both_shapes() {
    let mut metadata = common::ground_robot_metadata();
    metadata.encoding = InputEncoding::HeadingCosSin;
    let message = Model::from_published(&stored(RAW), metadata).unwrap_err().to_string();
    assert!(message.contains("[48, 4]") && message.contains("[48, 5]"), "{message}");
}
