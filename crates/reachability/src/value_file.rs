//! The file of a value function: safetensors with everything needed to use or repeat it.
//!
//! | tensor | type | shape |
//! |---|---|---|
//! | `value` | f32 | one entry per node, m |
//! | `axis_0` … | f64 | node positions of each axis, in the state's unit |
//!
//! The metadata key `cncbf` holds [`ValueMetadata`] and the format as JSON. The axes are redundant with it:
//! they let any safetensors reader plot the file, and are checked on reading.

use crate::{Grid, GridError, ValueFunction, ValueMetadata};
use safetensors::tensor::{Dtype, SafeTensorError, SafeTensors, TensorView};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

const FORMAT: &str = "cncbf value function v1";
const METADATA_KEY: &str = "cncbf";

/// Why a value file could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum ValueFileError {
    /// The file system refused.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// `read` or `write`.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Not a complete safetensors file.
    #[error("{} is damaged or no safetensors file ({reason}); solve again", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A safetensors file of something else.
    #[error("{} is no value function of this project ({reason}); give the output of `cncbf solve`", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What gave it away.
        reason: String,
    },
    /// Metadata and tensors contradict each other, or the values were changed.
    #[error("{} contradicts itself ({reason}); solve again", path.display())]
    Inconsistent {
        /// The file.
        path: PathBuf,
        /// The contradiction.
        reason: String,
    },
}

/// The JSON under [`METADATA_KEY`].
#[derive(Serialize, Deserialize)]
struct Header {
    format: String,
    #[serde(flatten)]
    metadata: ValueMetadata,
}

impl<const N: usize> ValueFunction<N> {
    /// Writes the file at `path`, replacing one that is there only once the new one is complete.
    ///
    /// # Errors
    /// * [`ValueFileError::Io`] if the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), ValueFileError> {
        let io = |source| ValueFileError::Io { action: "write", path: path.to_path_buf(), source };
        let bytes = self.to_bytes().map_err(|e| io(std::io::Error::other(e)))?;
        let mut unfinished = path.as_os_str().to_owned();
        unfinished.push(".unfinished");
        std::fs::write(&unfinished, bytes).map_err(io)?;
        std::fs::rename(&unfinished, path).map_err(io)
    }

    fn to_bytes(&self) -> Result<Vec<u8>, SafeTensorError> {
        let invalid = |e: serde_json::Error| SafeTensorError::InvalidHeaderDeserialization(e);
        let header = Header { format: FORMAT.to_owned(), metadata: self.metadata.clone() };
        let json = serde_json::to_string(&header).map_err(invalid)?;
        let value = f32_bytes(&self.values);
        let axes: Vec<Vec<u8>> = self.grid.axes().iter().map(axis_bytes).collect();
        let shape = self.grid.shape();
        let mut tensors = vec![("value".to_owned(), TensorView::new(Dtype::F32, shape.to_vec(), &value)?)];
        for (d, bytes) in axes.iter().enumerate() {
            tensors.push((axis_name(d), TensorView::new(Dtype::F64, vec![shape[d]], bytes)?));
        }
        safetensors::serialize(tensors, Some(HashMap::from([(METADATA_KEY.to_owned(), json)])))
    }

    /// Reads the file at `path` and checks that it is whole, of this project, and consistent.
    ///
    /// # Errors
    /// One [`ValueFileError`] per way in which it is not.
    pub fn load(path: &Path) -> Result<Self, ValueFileError> {
        let owned = || path.to_path_buf();
        let bytes = std::fs::read(path).map_err(|source| ValueFileError::Io {
            action: "read",
            path: owned(),
            source,
        })?;
        let damaged = |e: SafeTensorError| ValueFileError::Damaged { path: owned(), reason: e.to_string() };
        let foreign = |reason: String| ValueFileError::Foreign { path: owned(), reason };
        let inconsistent = |reason: String| ValueFileError::Inconsistent { path: owned(), reason };

        let (_, file_metadata) = SafeTensors::read_metadata(&bytes).map_err(damaged)?;
        let tensors = SafeTensors::deserialize(&bytes).map_err(damaged)?;
        let json = file_metadata
            .metadata()
            .as_ref()
            .and_then(|map| map.get(METADATA_KEY))
            .ok_or_else(|| foreign(format!("it has no metadata `{METADATA_KEY}`")))?;
        let format = serde_json::from_str::<serde_json::Value>(json)
            .ok()
            .and_then(|v| v.get("format")?.as_str().map(str::to_owned));
        if format.as_deref() != Some(FORMAT) {
            return Err(foreign(format!("its format is not `{FORMAT}`")));
        }
        let Header { metadata, .. } = serde_json::from_str(json).map_err(|e| foreign(e.to_string()))?;

        let axes = <[_; N]>::try_from(metadata.grid.clone())
            .map_err(|axes| foreign(format!("it has {} axes, {N} are expected", axes.len())))?;
        let grid = Grid::new(axes).map_err(|e: GridError| inconsistent(e.to_string()))?;
        for (d, axis) in grid.axes().iter().enumerate() {
            let tensor = tensors.tensor(&axis_name(d)).map_err(|e| foreign(e.to_string()))?;
            if tensor.dtype() != Dtype::F64 || tensor.data() != axis_bytes(axis) {
                return Err(inconsistent(format!("`{}` is not the axis of its metadata", axis_name(d))));
            }
        }
        let value = tensors.tensor("value").map_err(|e| foreign(e.to_string()))?;
        if value.dtype() != Dtype::F32 || value.shape() != grid.shape() {
            return Err(inconsistent(format!(
                "`value` is {:?} of shape {:?}, not F32 of {:?}",
                value.dtype(),
                value.shape(),
                grid.shape()
            )));
        }
        let values: Vec<f32> =
            value.data().as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        if sha256_of(&values) != metadata.value_sha256 {
            return Err(inconsistent("the values are not those that were hashed".to_owned()));
        }
        if !values.iter().all(|v| v.is_finite()) {
            return Err(inconsistent("a value is not finite".to_owned()));
        }
        Ok(Self { grid, values, metadata })
    }
}

/// Returns the SHA-256 of `values` as little-endian f32, in hexadecimal.
pub(crate) fn sha256_of(values: &[f32]) -> String {
    hexadecimal(&Sha256::digest(f32_bytes(values)))
}

/// Returns `bytes` in hexadecimal.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    use std::fmt::Write as _;
    bytes.iter().fold(String::with_capacity(2 * bytes.len()), |mut hex, byte| {
        // Writing to a String cannot fail.
        let _ = write!(hex, "{byte:02x}");
        hex
    })
}

fn axis_name(axis: usize) -> String {
    format!("axis_{axis}")
}

fn axis_bytes(axis: &crate::Axis) -> Vec<u8> {
    (0..axis.count).flat_map(|i| axis.coordinate(i).to_le_bytes()).collect()
}

pub(crate) fn f32_bytes(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}
