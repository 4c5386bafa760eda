//! A model in memory: parameters with the metadata they hold for. Not here: its bytes (`model_file`), and whether it
//! fits a robot (`fit`).

use std::collections::BTreeMap;

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
    let still = metadata.dynamics == DynamicsKind::UnicycleStaticPair;
    Ok(TrainedDomain::new(grid.min, grid.max, grid.periodic)?.with_idle([false, false, still, still]))
}
