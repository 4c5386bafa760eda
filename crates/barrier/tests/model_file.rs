//! Reading and writing model files: what comes back, and one defect per test.
#![allow(clippy::unwrap_used)] // helpers of a test may panic

mod common;

use std::collections::HashMap;

use barrier::{
    Bounds, DynamicsKind, Expected, InputEncoding, Model, ModelFileError, ModelMetadata, ModelMismatch,
};
use dynamics::InputBox;
use safetensors::tensor::{Dtype, SafeTensors, TensorView, serialize};

fn model() -> Model {
    common::ground_robot_model(1)
}

/// The file of [`model`], taken apart, changed and put together again without a new hash.
fn rewritten(change: impl FnOnce(&mut Vec<Tensor>, &mut HashMap<String, String>)) -> Vec<u8> {
    let bytes = model().to_bytes().unwrap();
    let tensors = SafeTensors::deserialize(&bytes).unwrap();
    let mut parts: Vec<Tensor> = tensors
        .iter()
        .map(|(name, view)| Tensor {
            name: name.to_owned(),
            dtype: view.dtype(),
            shape: view.shape().to_vec(),
            data: view.data().to_vec(),
        })
        .collect();
    parts.sort_by(|a, b| a.name.cmp(&b.name));
    let mut metadata = SafeTensors::read_metadata(&bytes).unwrap().1.metadata().clone().unwrap();
    change(&mut parts, &mut metadata);
    let views = parts
        .iter()
        .map(|part| (&part.name, TensorView::new(part.dtype, part.shape.clone(), &part.data).unwrap()));
    serialize(views, Some(metadata)).unwrap()
}

struct Tensor {
    name: String,
    dtype: Dtype,
    shape: Vec<usize>,
    data: Vec<u8>,
}

fn refused(bytes: &[u8]) -> ModelFileError {
    Model::from_bytes(bytes).expect_err("the file has a defect")
}

#[test]
fn a_model_comes_back_as_it_was_saved_byte_for_byte() {
    let folder = std::env::temp_dir().join(format!("cncbf-model-file-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("model.safetensors");
    model().save(&path).unwrap();
    let loaded = Model::load(&path).unwrap();
    assert_eq!(loaded, model());
    assert_eq!(loaded.to_bytes().unwrap(), std::fs::read(&path).unwrap());
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1, "nothing but the model stays behind");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn an_unchanged_rewrite_is_accepted() {
    assert_eq!(Model::from_bytes(&rewritten(|_, _| ())).unwrap(), model());
}

#[test]
fn a_missing_file_names_its_path() {
    let error = Model::load(std::path::Path::new("no/such/model.safetensors")).unwrap_err();
    assert!(error.to_string().contains("no/such/model.safetensors"), "{error}");
}

#[test]
fn every_truncation_is_refused_as_such() {
    let bytes = model().to_bytes().unwrap();
    for length in (0..bytes.len()).step_by(97).chain([bytes.len() - 1]) {
        let error = refused(&bytes[..length]);
        assert!(matches!(error, ModelFileError::Truncated { .. }), "{length}: {error}");
    }
}

#[test]
fn a_foreign_file_is_refused_as_such() {
    let error = refused(b"# a text, not a model, and longer than eight bytes\n");
    assert!(matches!(error, ModelFileError::Foreign { .. }), "{error}");
}

#[test]
fn a_far_too_large_file_is_refused_before_it_is_parsed() {
    assert!(matches!(refused(&vec![0; 2 << 20]), ModelFileError::TooLarge { .. }));
}

#[test]
fn any_flipped_byte_is_noticed() {
    let bytes = model().to_bytes().unwrap();
    for index in (0..bytes.len()).step_by(13) {
        let mut flipped = bytes.clone();
        flipped[index] ^= 0x10;
        // In the header's padding or its JSON spelling a flip may be refused for many reasons; in no case
        // may a model come out that differs from the one saved.
        if let Ok(read) = Model::from_bytes(&flipped) {
            assert_eq!(read, model(), "byte {index}");
        }
    }
}

#[test]
fn a_changed_weight_breaks_the_hash() {
    let bytes = rewritten(|tensors, _| tensors[3].data[5] ^= 1);
    assert!(matches!(refused(&bytes), ModelFileError::Hash { .. }));
}

#[test]
fn a_changed_bound_breaks_the_hash() {
    let bytes = rewritten(|_, metadata| {
        let text = metadata.get_mut("cncbf").unwrap();
        *text = text.replace("\"failure_radius_m\":0.7", "\"failure_radius_m\":0.3");
    });
    assert!(matches!(refused(&bytes), ModelFileError::Hash { .. }));
}

#[test]
fn a_file_without_metadata_points_to_the_explicit_way() {
    let error = refused(&rewritten(|_, metadata| metadata.clear()));
    assert!(matches!(error, ModelFileError::MissingMetadata));
    assert!(error.to_string().contains("from_published"), "{error}");
}

#[test]
fn published_weights_load_with_the_metadata_stated() {
    let bytes = rewritten(|_, metadata| metadata.clear());
    let loaded = Model::from_published(&bytes, common::ground_robot_metadata()).unwrap();
    assert_eq!(loaded, model());
}

#[test]
fn an_unknown_metadata_field_is_named() {
    let error = refused(&rewritten(|_, metadata| {
        let text = metadata.get_mut("cncbf").unwrap();
        *text = text.replacen('{', "{\"colour\":1,", 1);
    }));
    assert!(error.to_string().contains("colour"), "{error}");
}

#[test]
fn another_format_version_is_refused() {
    let mut metadata = common::ground_robot_metadata();
    metadata.format_version = 1;
    let error = Model::new(common::random_weights(1, 1.0), metadata).unwrap_err();
    assert!(matches!(error, ModelFileError::FormatVersion { found: 1, .. }));
}

#[test]
fn a_file_of_version_1_is_told_to_be_trained_again() {
    // What version 1 lacked would otherwise be reported as a missing field.
    let error = refused(&rewritten(|_, metadata| {
        let text = metadata.get_mut("cncbf").unwrap();
        *text =
            text.replace("\"format_version\":2", "\"format_version\":1").replace("\"encoding\":\"raw\",", "");
    }));
    assert!(matches!(error, ModelFileError::FormatVersion { found: 1, supported: 2 }), "{error}");
    assert!(error.to_string().contains("train it again"), "{error}");
}

#[test]
fn an_encoding_that_does_not_suit_the_dynamics_is_refused() {
    let weights = common::random_encoded_weights(InputEncoding::HeadingCosSin, 1, 1.0);
    let metadata = ModelMetadata { encoding: InputEncoding::HeadingCosSin, ..common::quadrotor_metadata() };
    let error = Model::new(weights, metadata).unwrap_err();
    assert!(matches!(error, ModelFileError::MetadataValue { field: "encoding", .. }), "{error}");
}

#[test]
fn an_encoding_that_is_not_the_weights_is_refused() {
    let metadata =
        ModelMetadata { encoding: InputEncoding::HeadingCosSin, ..common::ground_robot_metadata() };
    let error = Model::new(common::random_weights(1, 1.0), metadata).unwrap_err();
    assert!(matches!(error, ModelFileError::MetadataValue { field: "encoding", .. }), "{error}");
}

#[test]
fn models_of_every_encoding_come_back_from_their_bytes() {
    for (encoding, dynamics) in [
        (InputEncoding::Raw, DynamicsKind::UnicyclePair),
        (InputEncoding::HeadingCosSin, DynamicsKind::UnicyclePair),
        (InputEncoding::Position, DynamicsKind::UnicycleStaticPair),
    ] {
        let disturbance = Bounds {
            min: vec![-0.35; dynamics.disturbance_count()],
            max: vec![0.35; dynamics.disturbance_count()],
        };
        let metadata = ModelMetadata { encoding, dynamics, disturbance, ..common::ground_robot_metadata() };
        let model = Model::new(common::random_encoded_weights(encoding, 2, 1.0), metadata).unwrap();
        assert_eq!(Model::from_bytes(&model.to_bytes().unwrap()).unwrap(), model);
    }
}

#[test]
fn what_was_verified_is_sealed_with_the_model() {
    let record = serde_json::json!({ "failures": 0, "rollouts": 138_149, "hash": "" });
    let verified = model().with_verification([("scenario".to_owned(), record.clone())].into()).unwrap();
    assert_ne!(verified.metadata().hash, model().metadata().hash);
    let read = Model::from_bytes(&verified.to_bytes().unwrap()).unwrap();
    assert_eq!(read.metadata().verification["scenario"], record);
    assert_eq!(read.weights(), model().weights());
    assert_eq!(read.with_verification([].into()).unwrap(), model(), "taken away, the model is the old one");
}

#[test]
fn a_negative_radius_is_refused() {
    let mut metadata = common::ground_robot_metadata();
    metadata.failure_radius_m = -0.7;
    let error = Model::new(common::random_weights(1, 1.0), metadata).unwrap_err();
    assert!(matches!(error, ModelFileError::MetadataValue { field: "failure_radius_m", .. }));
}

#[test]
fn a_disturbance_box_of_the_wrong_dimension_is_refused() {
    let mut metadata = common::ground_robot_metadata();
    metadata.disturbance = Bounds { min: vec![-1.0; 2], max: vec![1.0; 2] };
    let error = Model::new(common::random_weights(1, 1.0), metadata).unwrap_err();
    assert!(matches!(error, ModelFileError::MetadataValue { field: "disturbance", .. }));
}

#[test]
fn a_missing_tensor_is_named() {
    let error = refused(&rewritten(|tensors, _| tensors.retain(|tensor| tensor.name != "layers.4.bias")));
    assert!(matches!(&error, ModelFileError::MissingTensor { name } if name == "layers.4.bias"), "{error}");
}

#[test]
fn an_extra_tensor_is_named() {
    let error = refused(&rewritten(|tensors, _| {
        tensors.push(Tensor {
            name: "layers.7.bias".into(),
            dtype: Dtype::F32,
            shape: vec![1],
            data: vec![0; 4],
        });
    }));
    assert!(matches!(&error, ModelFileError::ExtraTensor { name } if name == "layers.7.bias"), "{error}");
}

#[test]
fn a_transposed_tensor_is_refused_with_both_shapes() {
    let error = refused(&rewritten(|tensors, _| {
        let tensor = tensors.iter_mut().find(|tensor| tensor.name == "layers.0.weight").unwrap();
        tensor.shape.reverse();
    }));
    let message = error.to_string();
    assert!(message.contains("[4, 48]") && message.contains("[48, 4]"), "{message}");
}

#[test]
fn integers_in_place_of_floats_are_refused() {
    let error = refused(&rewritten(|tensors, _| tensors[0].dtype = Dtype::I32));
    assert!(matches!(error, ModelFileError::WrongTensor { .. }), "{error}");
}

#[test]
fn a_nan_weight_is_refused() {
    let error = refused(&rewritten(|tensors, _| {
        tensors[0].data[..4].copy_from_slice(&f32::NAN.to_le_bytes());
    }));
    assert!(matches!(error, ModelFileError::Weights(_)), "{error}");
}

#[test]
fn the_layers_have_the_shapes_of_the_paper() {
    let bytes = model().to_bytes().unwrap();
    let tensors = SafeTensors::deserialize(&bytes).unwrap();
    for (index, sizes) in InputEncoding::Raw.layer_sizes().windows(2).enumerate() {
        let weight = tensors.tensor(&format!("layers.{index}.weight")).unwrap();
        assert_eq!(weight.shape(), [sizes[1], sizes[0]]);
    }
}

fn expected() -> Expected {
    let pair = common::unicycle_pair();
    Expected {
        dynamics: DynamicsKind::UnicyclePair,
        control: pair.control,
        disturbance: Bounds::from(&pair.disturbance),
        failure_radius_m: Some(0.7),
    }
}

#[test]
fn a_model_fits_the_robot_it_was_made_for() {
    assert_eq!(model().check_fits(&expected()), Ok(()));
    assert_eq!(model().check_fits(&Expected { failure_radius_m: None, ..expected() }), Ok(()));
}

#[test]
fn a_model_for_other_dynamics_does_not_fit() {
    let expected = Expected { dynamics: DynamicsKind::DoubleIntegratorPair, ..expected() };
    assert!(matches!(model().check_fits(&expected), Err(ModelMismatch::Dynamics { .. })));
}

#[test]
fn a_model_fits_a_robot_that_can_do_more_and_none_that_can_do_less() {
    let fits = |min, max| {
        let control = InputBox::new(min, max).unwrap();
        model().check_fits(&Expected { control, ..expected() })
    };
    // The model's box is [0.25, 1] m/s by [−0.8, 0.8] rad/s.
    for (min, max) in [
        ([0.0, -0.8], [1.0, 0.8]),
        ([-1.0, -2.0], [3.0, 2.0]),
        ([0.25, -0.8], [1.0, 0.9]),
        ([0.25 + 1e-12, -0.8], [1.0, 0.8 - 1e-12]),
    ] {
        assert_eq!(fits(min, max), Ok(()), "{min:?} to {max:?}");
    }
    for (min, max) in [
        ([0.3, -0.8], [1.0, 0.8]),
        ([0.25, -0.7], [1.0, 0.8]),
        ([0.25, -0.8], [0.9, 0.8]),
        ([0.25, -0.8], [1.0, 0.7]),
        ([0.0, -0.8], [0.9, 2.0]),
    ] {
        assert!(matches!(fits(min, max), Err(ModelMismatch::Control { .. })), "{min:?} to {max:?}");
    }
}

#[test]
fn a_model_for_another_disturbance_box_does_not_fit() {
    let disturbance = Bounds { min: vec![-0.5], max: vec![0.5] };
    let found = model().check_fits(&Expected { disturbance, ..expected() });
    assert!(matches!(found, Err(ModelMismatch::Disturbance { .. })));
}

#[test]
fn a_model_for_another_radius_does_not_fit_where_one_is_asked_for() {
    let found = model().check_fits(&Expected { failure_radius_m: Some(0.9), ..expected() });
    assert!(matches!(found, Err(ModelMismatch::Radius { .. })));
}
