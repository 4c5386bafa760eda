//! A model in memory: parameters with the metadata they hold for. Not here: its bytes (`model_file`).

use std::collections::BTreeMap;

use dynamics::InputBox;

use crate::domain::TrainedDomain;
use crate::metadata::{Bounds, DynamicsKind, FORMAT_VERSION, ModelMetadata};
use crate::model_error::ModelFileError;
use crate::model_file::sealed_text;
use crate::weights::NetworkWeights;

/// A residual network together with what it was solved and trained for, checked and hashed.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    weights: NetworkWeights,
    metadata: ModelMetadata,
    domain: TrainedDomain,
    /// The metadata as written in the file, hash included: rewriting keeps its bytes.
    text: String,
}

/// What a robot needs a model to have been made for.
#[derive(Debug, Clone, PartialEq)]
pub struct Expected {
    /// Pair of dynamics.
    pub dynamics: DynamicsKind,
    /// Box of the robot's control.
    pub control: InputBox<2>,
    /// Box of the obstacles' disturbance.
    pub disturbance: Bounds,
    /// Radius of the failure function, m; `None` where each obstacle brings its own, which is exact (see
    /// [`crate::RelativeBarrier`]).
    pub failure_radius_m: Option<f64>,
}

/// In what a model differs from what the robot needs.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ModelMismatch {
    /// Another pair of dynamics.
    #[error("the model is for `{model}`, the robot needs `{expected}`; choose its model or set `dynamics`")]
    Dynamics {
        /// Of the model.
        model: DynamicsKind,
        /// Of the robot.
        expected: DynamicsKind,
    },
    /// Another box of controls.
    #[error(
        "the model's control box is {model:?}, the robot's {expected:?}; solve and train for the robot's"
    )]
    Control {
        /// Of the model.
        model: InputBox<2>,
        /// Of the robot.
        expected: InputBox<2>,
    },
    /// Another box of disturbances.
    #[error(
        "the model's disturbance box is {model:?}, configured {expected:?}; solve and train for the latter"
    )]
    Disturbance {
        /// Of the model.
        model: Bounds,
        /// As configured.
        expected: Bounds,
    },
    /// Another radius.
    #[error("the model's failure radius is {model_m} m, configured {expected_m} m; make the two agree")]
    Radius {
        /// Of the model, m.
        model_m: f64,
        /// As configured, m.
        expected_m: f64,
    },
}

impl Model {
    /// Checks the metadata and seals both with their hash; the `hash` given is replaced.
    ///
    /// # Errors
    /// * [`ModelFileError::FormatVersion`], [`ModelFileError::MetadataValue`], [`ModelFileError::Domain`],
    ///   [`ModelFileError::Metadata`] for unusable metadata.
    pub fn new(weights: NetworkWeights, mut metadata: ModelMetadata) -> Result<Self, ModelFileError> {
        check(&weights, &metadata)?;
        let text = sealed_text(&weights, &mut metadata)?;
        Self::from_sealed(weights, metadata, text)
    }

    /// Takes parts whose hash is known to be right.
    pub(crate) fn from_sealed(
        weights: NetworkWeights,
        metadata: ModelMetadata,
        text: String,
    ) -> Result<Self, ModelFileError> {
        let domain = check(&weights, &metadata)?;
        Ok(Self { weights, metadata, domain, text })
    }

    /// Returns the same model with `verification` in its metadata in place of what stood there, under a new hash.
    ///
    /// # Errors
    /// * [`ModelFileError::Metadata`] if a record has no JSON text.
    pub fn with_verification(
        &self,
        verification: BTreeMap<String, serde_json::Value>,
    ) -> Result<Self, ModelFileError> {
        Self::new(self.weights.clone(), ModelMetadata { verification, ..self.metadata.clone() })
    }

    /// Returns the parameters.
    pub fn weights(&self) -> &NetworkWeights {
        &self.weights
    }

    /// Returns what the model was made for, its hash included.
    pub fn metadata(&self) -> &ModelMetadata {
        &self.metadata
    }

    /// Returns the box of relative states the network was trained on.
    pub fn domain(&self) -> &TrainedDomain {
        &self.domain
    }

    /// Returns the metadata as the file carries it.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// Compares what the model was made for with what the robot needs. Bounds agree within 1e-9.
    ///
    /// # Errors
    /// * The first [`ModelMismatch`] found.
    pub fn check_fits(&self, expected: &Expected) -> Result<(), ModelMismatch> {
        let model = &self.metadata;
        if model.dynamics != expected.dynamics {
            return Err(ModelMismatch::Dynamics { model: model.dynamics, expected: expected.dynamics });
        }
        if !close(&Bounds::from(&model.control), &Bounds::from(&expected.control)) {
            return Err(ModelMismatch::Control { model: model.control, expected: expected.control });
        }
        if !close(&model.disturbance, &expected.disturbance) {
            let (model, expected) = (model.disturbance.clone(), expected.disturbance.clone());
            return Err(ModelMismatch::Disturbance { model, expected });
        }
        match expected.failure_radius_m {
            Some(expected_m) if (expected_m - model.failure_radius_m).abs() > TOLERANCE => {
                Err(ModelMismatch::Radius { model_m: model.failure_radius_m, expected_m })
            }
            Some(_) | None => Ok(()),
        }
    }
}

/// Two bounds this close are one bound written twice.
const TOLERANCE: f64 = 1e-9;

fn close(a: &Bounds, b: &Bounds) -> bool {
    let equal =
        |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= TOLERANCE);
    equal(&a.min, &b.min) && equal(&a.max, &b.max)
}

/// Returns the trained domain of metadata that makes sense.
fn check(weights: &NetworkWeights, metadata: &ModelMetadata) -> Result<TrainedDomain, ModelFileError> {
    if metadata.format_version != FORMAT_VERSION {
        let found = metadata.format_version;
        return Err(ModelFileError::FormatVersion { found, supported: FORMAT_VERSION });
    }
    let unusable = |field, value: String| Err(ModelFileError::MetadataValue { field, value });
    let radius = metadata.failure_radius_m;
    if !(radius > 0.0 && radius.is_finite()) {
        return unusable("failure_radius_m", radius.to_string());
    }
    if metadata.encoding != weights.encoding() {
        return unusable(
            "encoding",
            format!("{}, the weights are for {}", metadata.encoding, weights.encoding()),
        );
    }
    if !metadata.encoding.suits(metadata.dynamics) {
        return unusable("encoding", format!("{} for {}", metadata.encoding, metadata.dynamics));
    }
    let inputs = metadata.dynamics.disturbance_count();
    let Bounds { min, max } = &metadata.disturbance;
    if min.len() != inputs || max.len() != inputs || !min.iter().zip(max).all(|(min, max)| min <= max) {
        return unusable("disturbance", format!("{min:?} to {max:?}, {inputs} component(s) needed"));
    }
    let grid = &metadata.grid;
    Ok(TrainedDomain::new(grid.min, grid.max, grid.periodic)?)
}
