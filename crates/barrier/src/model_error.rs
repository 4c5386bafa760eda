//! Why a model file was refused. Not here: the checks (`model_file`, `model`).

use std::path::PathBuf;

use crate::domain::DomainError;
use crate::weights::WeightsError;

/// Why a model could not be read, written or made. Every variant says what to do next.
#[derive(Debug, thiserror::Error)]
pub enum ModelFileError {
    /// The file system refused.
    #[error("cannot access the model file {path}: {source}; check path and rights", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Far more bytes than a model has.
    #[error(
        "{bytes} bytes are no model of about 5,000 parameters (limit {limit}); is this another network's file?"
    )]
    TooLarge {
        /// Size found.
        bytes: u64,
        /// Size accepted.
        limit: u64,
    },
    /// The file is shorter, or longer, than its own header says.
    #[error("the model file has {bytes} bytes, another number than its header announces; copy it again")]
    Truncated {
        /// Size found.
        bytes: usize,
    },
    /// Not a safetensors file at all.
    #[error("this is no safetensors file ({reason}); give a model made by `cncbf train`")]
    Foreign {
        /// What the reader said.
        reason: String,
    },
    /// A safetensors file without this project's metadata.
    #[error(
        "the file has no `cncbf` metadata, so its dynamics and bounds are unknown; published weights load \
         only through `Model::from_published` with the metadata stated"
    )]
    MissingMetadata,
    /// The metadata does not read.
    #[error("the `cncbf` metadata does not read ({reason}); train the model again with this version")]
    Metadata {
        /// What the reader said.
        reason: String,
    },
    /// Metadata of another version.
    #[error(
        "the model has format version {found}, this program reads {supported}; train it again with this version, or update"
    )]
    FormatVersion {
        /// Version found.
        found: u32,
        /// Version read.
        supported: u32,
    },
    /// A metadata value that makes no sense.
    #[error("the metadata field `{field}` is not usable ({value}); correct it and train again")]
    MetadataValue {
        /// Name of the field.
        field: &'static str,
        /// What it holds.
        value: String,
    },
    /// The grid's box is no domain.
    #[error("the metadata field `grid` is not usable: {0}")]
    Domain(#[from] DomainError),
    /// A tensor is missing.
    #[error("tensor `{name}` is missing; the file holds another network than the model's")]
    MissingTensor {
        /// Its name.
        name: String,
    },
    /// There are more tensors than the network has.
    #[error("tensor `{name}` does not belong to a model's seven layers; is this another network?")]
    ExtraTensor {
        /// Its name.
        name: String,
    },
    /// A tensor of another shape or type.
    #[error("tensor `{name}` is {found}, needed is {expected}; the file holds another network")]
    WrongTensor {
        /// Its name.
        name: String,
        /// Type and shape found.
        found: String,
        /// Type and shape needed.
        expected: String,
    },
    /// The parameters are unusable.
    #[error(transparent)]
    Weights(#[from] WeightsError),
    /// The contents are not those that were hashed.
    #[error(
        "the contents have SHA-256 {computed}, the metadata says {stated}; the file was altered, restore it"
    )]
    Hash {
        /// What the metadata says.
        stated: String,
        /// What the contents give.
        computed: String,
    },
}
