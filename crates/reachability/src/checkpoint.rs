//! Checkpoints: a long solve survives its process.
//!
//! The file is a safetensors file with the tensors `value` and `value_at_last_check` (f32, per node) and, under the metadata
//! key `cncbf`, the time reached and the identity of the solve as JSON. The identity is a hash of all numbers that enter:
//! grid, settings, tabulated dynamics, input limits and failure function.

use crate::coefficients::Coefficients;
use crate::solve::{Clock, Running};
use crate::value_file::{f32_bytes, hexadecimal};
use crate::{Grid, SolverSettings};
use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};

const FORMAT: &str = "cncbf solve checkpoint v1";
const METADATA_KEY: &str = "cncbf";

/// Where and how often a solve saves its state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Checkpoint<'a> {
    /// The file.
    pub path: &'a Path,
    /// Time steps between two writes; 0 writes only when the solve is interrupted.
    pub every_steps: u64,
}

/// Why a checkpoint could not be written or used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CheckpointError {
    /// The file system refused.
    #[error("cannot {action} the checkpoint {}: {reason}", path.display())]
    Io {
        /// `read` or `write`.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// Not a complete checkpoint.
    #[error("{} is damaged or no checkpoint of a solve ({reason}); remove it to solve from the start", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A checkpoint of another solve.
    #[error(
        "{} was written for other dynamics, limits, radius, grid or solver settings; restore those, or remove the file to \
         solve from the start",
        path.display()
    )]
    OtherProblem {
        /// The file.
        path: PathBuf,
    },
}

impl<'a> Checkpoint<'a> {
    /// A write every hundred steps: at three evaluations a step, well below one percent of the work on any grid.
    pub fn at(path: &'a Path) -> Self {
        Self { path, every_steps: 100 }
    }

    pub(crate) fn identify<const N: usize, const NU: usize, const ND: usize>(
        self,
        grid: &Grid<N>,
        settings: &SolverSettings,
        failure: &[f32],
        coefficients: &Coefficients<N, NU, ND>,
    ) -> IdentifiedCheckpoint<'a> {
        let mut hash = Sha256::new();
        // The debug form of numbers is exact, and it changes when a field is added.
        hash.update(format!("{FORMAT} {:?} {settings:?}", grid.axes()));
        hash.update(f32_bytes(failure));
        coefficients.hash_into(&mut hash);
        IdentifiedCheckpoint { checkpoint: self, identity: hexadecimal(&hash.finalize()) }
    }
}

/// A checkpoint file and the only solve it may belong to.
pub(crate) struct IdentifiedCheckpoint<'a> {
    checkpoint: Checkpoint<'a>,
    identity: String,
}

/// The JSON under [`METADATA_KEY`].
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    format: String,
    identity: String,
    values_sha256: String,
    clock: Clock,
}

impl IdentifiedCheckpoint<'_> {
    pub(crate) fn is_due(&self, steps: u64) -> bool {
        self.checkpoint.every_steps > 0 && steps.is_multiple_of(self.checkpoint.every_steps)
    }

    /// Replaces the file, in one step of the file system.
    pub(crate) fn write(&self, running: &Running) -> Result<(), CheckpointError> {
        let path = self.checkpoint.path;
        let refused = |e: io::Error| CheckpointError::Io {
            action: "write",
            path: path.to_owned(),
            reason: e.to_string(),
        };
        let bytes = self.to_bytes(running).map_err(|e| refused(io::Error::other(e)))?;
        let mut unfinished = path.as_os_str().to_owned();
        unfinished.push(".unfinished");
        std::fs::write(&unfinished, bytes).map_err(refused)?;
        std::fs::rename(&unfinished, path).map_err(refused)
    }

    fn to_bytes(&self, running: &Running) -> Result<Vec<u8>, Box<dyn std::error::Error + Send + Sync>> {
        let (value, at_last_check) = (f32_bytes(&running.values), f32_bytes(&running.at_last_check));
        let header = Header {
            format: FORMAT.to_owned(),
            identity: self.identity.clone(),
            values_sha256: hash_of(&value, &at_last_check),
            clock: running.clock.clone(),
        };
        let json = serde_json::to_string(&header)?;
        let tensor = |bytes| TensorView::new(Dtype::F32, vec![running.values.len()], bytes);
        let tensors = [("value", tensor(&value)?), ("value_at_last_check", tensor(&at_last_check)?)];
        let metadata = HashMap::from([(METADATA_KEY.to_owned(), json)]);
        Ok(safetensors::serialize(tensors, Some(metadata))?)
    }

    /// Returns the saved state, nothing if there is no file.
    pub(crate) fn read(&self, nodes: usize) -> Result<Option<Running>, CheckpointError> {
        let path = || self.checkpoint.path.to_owned();
        let bytes = match std::fs::read(self.checkpoint.path) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(e) => {
                return Err(CheckpointError::Io { action: "read", path: path(), reason: e.to_string() });
            }
        };
        let damaged = |reason: String| CheckpointError::Damaged { path: path(), reason };
        let text = |e: safetensors::SafeTensorError| damaged(e.to_string());
        let (_, metadata) = SafeTensors::read_metadata(&bytes).map_err(text)?;
        let tensors = SafeTensors::deserialize(&bytes).map_err(text)?;
        let json = metadata.metadata().as_ref().and_then(|map| map.get(METADATA_KEY));
        let json = json.ok_or_else(|| damaged(format!("it has no metadata `{METADATA_KEY}`")))?;
        let header: Header = serde_json::from_str(json).map_err(|e| damaged(e.to_string()))?;
        if header.format != FORMAT {
            return Err(damaged(format!("its format is not `{FORMAT}`")));
        }
        if header.identity != self.identity {
            return Err(CheckpointError::OtherProblem { path: path() });
        }
        let values = |name: &str| {
            let tensor = tensors.tensor(name).map_err(text)?;
            if tensor.dtype() != Dtype::F32 || tensor.shape() != [nodes] {
                return Err(damaged(format!("`{name}` is not one F32 per node")));
            }
            Ok(tensor.data())
        };
        let (value, at_last_check) = (values("value")?, values("value_at_last_check")?);
        if hash_of(value, at_last_check) != header.values_sha256 {
            return Err(damaged("the values are not those that were hashed".to_owned()));
        }
        let numbers =
            |bytes: &[u8]| bytes.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        let (values, at_last_check) = (numbers(value), numbers(at_last_check));
        Ok(Some(Running { values, at_last_check, clock: header.clock }))
    }
}

fn hash_of(value: &[u8], at_last_check: &[u8]) -> String {
    hexadecimal(&Sha256::new().chain_update(value).chain_update(at_last_check).finalize())
}
