//! The bytes of a model: a `.safetensors` file with seven layers and one metadata entry.
//!
//! | part | content |
//! |---|---|
//! | tensors `layers.0.weight` … `layers.6.weight` | `f32`, `[outputs, inputs]`; the first has [`InputEncoding::input_count`] inputs |
//! | tensors `layers.0.bias` … `layers.6.bias` | `f32`, `[outputs]` |
//! | metadata key `cncbf` | [`ModelMetadata`] as compact JSON |
//!
//! `hash` is SHA-256, in lower-case hexadecimal, over the JSON text with its 64 hash digits removed
//! (`"hash":""`), followed by the bytes of `layers.0.weight`, `layers.0.bias`, `layers.1.weight`, … as
//! stored (little-endian). The names of the tensors are those of the weights the paper's authors published.

use std::collections::HashMap;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::Path;

use safetensors::tensor::{Dtype, SafeTensorError, SafeTensors, TensorView, serialize};
use sha2::{Digest, Sha256};

use crate::encoding::InputEncoding;
use crate::metadata::{FORMAT_VERSION, ModelMetadata};
use crate::model::Model;
use crate::model_error::ModelFileError;
use crate::weights::{LayerWeights, NetworkWeights};

/// Metadata key of this project.
const KEY: &str = "cncbf";
/// A model has about 20 kB; nothing near this limit is one.
const SIZE_LIMIT: u64 = 1 << 20;

impl Model {
    /// Reads and checks a model file.
    ///
    /// # Errors
    /// * [`ModelFileError::Io`], [`ModelFileError::TooLarge`] before anything is read.
    /// * As [`Model::from_bytes`].
    pub fn load(path: &Path) -> Result<Self, ModelFileError> {
        let io = |source| ModelFileError::Io { path: path.to_owned(), source };
        let mut bytes = Vec::new();
        let file = File::open(path).map_err(io)?;
        file.take(SIZE_LIMIT + 1).read_to_end(&mut bytes).map_err(io)?;
        Self::from_bytes(&bytes)
    }

    /// Reads and checks the bytes of a model file.
    ///
    /// # Errors
    /// * [`ModelFileError::Truncated`], [`ModelFileError::Foreign`], [`ModelFileError::TooLarge`] for bytes
    ///   that are no whole file.
    /// * [`ModelFileError::MissingMetadata`], [`ModelFileError::Metadata`] and their kin for the metadata.
    /// * [`ModelFileError::MissingTensor`], [`ModelFileError::ExtraTensor`], [`ModelFileError::WrongTensor`],
    ///   [`ModelFileError::Weights`] for the parameters.
    /// * [`ModelFileError::Hash`] if the contents are not those that were hashed.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ModelFileError> {
        let (tensors, text) = open(bytes)?;
        let text = text.ok_or(ModelFileError::MissingMetadata)?;
        check_version(&text)?;
        let metadata: ModelMetadata = serde_json::from_str(&text).map_err(|error| unreadable(&error))?;
        let weights = read_weights(&tensors, metadata.encoding)?;
        let stated = metadata.hash.clone();
        let unsealed = text.replacen(&hash_field(&stated), &hash_field(""), 1);
        let computed = digest(&unsealed, &weights);
        if stated != computed {
            return Err(ModelFileError::Hash { stated, computed });
        }
        Self::from_sealed(weights, metadata, text)
    }

    /// Reads weights without this project's metadata, such as the authors', which the caller then states.
    ///
    /// Tensor names and shapes must be those above; metadata in the file is not looked at.
    ///
    /// # Errors
    /// * As [`Model::from_bytes`] for tensors, as [`Model::new`] for the metadata given.
    pub fn from_published(bytes: &[u8], metadata: ModelMetadata) -> Result<Self, ModelFileError> {
        let (tensors, _) = open(bytes)?;
        Self::new(read_weights(&tensors, metadata.encoding)?, metadata)
    }

    /// Returns the bytes of the model file; the same model gives the same bytes.
    ///
    /// # Errors
    /// * [`ModelFileError::Foreign`] if the format's writer refuses, which checked models do not cause.
    pub fn to_bytes(&self) -> Result<Vec<u8>, ModelFileError> {
        let metadata = HashMap::from([(KEY.to_owned(), self.text().to_owned())]);
        let mut buffers = Vec::new();
        let sizes = self.weights().encoding().layer_sizes();
        for (index, layer) in self.weights().layers().iter().enumerate() {
            let (outputs, inputs) = (sizes[index + 1], sizes[index]);
            buffers.push((format!("layers.{index}.weight"), vec![outputs, inputs], to_le(&layer.weight)));
            buffers.push((format!("layers.{index}.bias"), vec![outputs], to_le(&layer.bias)));
        }
        let views: Result<Vec<_>, _> = buffers
            .iter()
            .map(|(name, shape, data)| Ok((name, TensorView::new(Dtype::F32, shape.clone(), data)?)))
            .collect();
        views.and_then(|views| serialize(views, Some(metadata))).map_err(|error| foreign(&error))
    }

    /// Writes the model file; an existing one is replaced as a whole or not at all.
    ///
    /// # Errors
    /// * [`ModelFileError::Io`] if the file system refuses.
    pub fn save(&self, path: &Path) -> Result<(), ModelFileError> {
        let io = |source| ModelFileError::Io { path: path.to_owned(), source };
        let bytes = self.to_bytes()?;
        let mut partial = path.as_os_str().to_owned();
        partial.push(".partial");
        let mut file = File::create(&partial).map_err(io)?;
        file.write_all(&bytes).and_then(|()| file.sync_all()).map_err(io)?;
        fs::rename(&partial, path).map_err(io)
    }
}

/// Sets the hash in `metadata` and returns its text.
pub(crate) fn sealed_text(
    weights: &NetworkWeights,
    metadata: &mut ModelMetadata,
) -> Result<String, ModelFileError> {
    let text = |metadata: &ModelMetadata| serde_json::to_string(metadata).map_err(|error| unreadable(&error));
    metadata.hash = String::new();
    metadata.hash = digest(&text(metadata)?, weights);
    text(metadata)
}

/// The hash as it stands in the JSON text.
fn hash_field(hash: &str) -> String {
    format!("\"hash\":\"{hash}\"")
}

/// SHA-256 over metadata and parameters, hexadecimal.
fn digest(unsealed_text: &str, weights: &NetworkWeights) -> String {
    let mut sha = Sha256::new();
    sha.update(unsealed_text.as_bytes());
    for layer in weights.layers() {
        sha.update(to_le(&layer.weight));
        sha.update(to_le(&layer.bias));
    }
    sha.finalize().iter().fold(String::new(), |hex, byte| hex + &format!("{byte:02x}"))
}

/// Splits a file into its tensors and the text under [`KEY`].
fn open(bytes: &[u8]) -> Result<(SafeTensors<'_>, Option<String>), ModelFileError> {
    if bytes.len() as u64 > SIZE_LIMIT {
        return Err(ModelFileError::TooLarge { bytes: bytes.len() as u64, limit: SIZE_LIMIT });
    }
    // A file whose header begins as it should but which ends too early was cut off.
    let Some((length, rest)) = bytes.split_first_chunk::<8>() else {
        return Err(ModelFileError::Truncated { bytes: bytes.len() });
    };
    if rest.is_empty() || (rest[0] == b'{' && u64::from_le_bytes(*length) > rest.len() as u64) {
        return Err(ModelFileError::Truncated { bytes: bytes.len() });
    }
    let read = |error| match error {
        SafeTensorError::MetadataIncompleteBuffer => ModelFileError::Truncated { bytes: bytes.len() },
        other => foreign(&other),
    };
    let (_, header) = SafeTensors::read_metadata(bytes).map_err(read)?;
    let text = header.metadata().as_ref().and_then(|entries| entries.get(KEY).cloned());
    Ok((SafeTensors::deserialize(bytes).map_err(read)?, text))
}

/// Looks at the version before anything else, so that an older file is told from a broken one.
fn check_version(text: &str) -> Result<(), ModelFileError> {
    #[derive(serde::Deserialize)]
    struct Versioned {
        format_version: u32,
    }
    let Versioned { format_version } = serde_json::from_str(text).map_err(|error| unreadable(&error))?;
    if format_version == FORMAT_VERSION {
        Ok(())
    } else {
        Err(ModelFileError::FormatVersion { found: format_version, supported: FORMAT_VERSION })
    }
}

fn unreadable(error: &serde_json::Error) -> ModelFileError {
    ModelFileError::Metadata { reason: error.to_string() }
}

fn foreign(error: &SafeTensorError) -> ModelFileError {
    ModelFileError::Foreign { reason: error.to_string() }
}

fn read_weights(
    tensors: &SafeTensors<'_>,
    encoding: InputEncoding,
) -> Result<NetworkWeights, ModelFileError> {
    let mut names = Vec::new();
    let mut layers = Vec::new();
    for (index, sizes) in encoding.layer_sizes().windows(2).enumerate() {
        let (weight, bias) = (format!("layers.{index}.weight"), format!("layers.{index}.bias"));
        layers.push(LayerWeights {
            weight: read_tensor(tensors, &weight, &[sizes[1], sizes[0]])?,
            bias: read_tensor(tensors, &bias, &[sizes[1]])?,
        });
        names.extend([weight, bias]);
    }
    match tensors.names().into_iter().find(|name| !names.iter().any(|known| known == name)) {
        Some(name) => Err(ModelFileError::ExtraTensor { name: name.to_owned() }),
        None => Ok(NetworkWeights::new(encoding, layers)?),
    }
}

fn read_tensor(tensors: &SafeTensors<'_>, name: &str, shape: &[usize]) -> Result<Vec<f32>, ModelFileError> {
    let tensor = tensors.tensor(name).map_err(|_| ModelFileError::MissingTensor { name: name.to_owned() })?;
    if tensor.dtype() != Dtype::F32 || tensor.shape() != shape {
        return Err(ModelFileError::WrongTensor {
            name: name.to_owned(),
            found: format!("{:?} {:?}", tensor.dtype(), tensor.shape()),
            expected: format!("F32 {shape:?}"),
        });
    }
    Ok(tensor.data().as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect())
}

fn to_le(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}
