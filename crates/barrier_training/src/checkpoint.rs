//! A run's state on disk: written after every epoch, taken up again to the same bits.

use crate::adam::Adam;
use safetensors::tensor::{Dtype, SafeTensors, TensorView, serialize};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Metadata key of [`State`].
const KEY: &str = "cncbf_training";

/// Why a checkpoint cannot be used or written.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The file system refuses.
    #[error("cannot access the checkpoint {}: {source}; check the path and the free space", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// The file is no checkpoint of this program.
    #[error("{} is no checkpoint of a training run ({what}); delete it to start anew", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// It belongs to another run.
    #[error(
        "the checkpoint {} belongs to other settings or another value function; restore them, or delete it to start anew",
        path.display()
    )]
    OtherRun {
        /// The file.
        path: PathBuf,
    },
}

/// What a run is between two epochs.
#[derive(Debug, Clone)]
pub(crate) struct State {
    /// Finished epochs.
    pub(crate) epoch: u64,
    /// Mean loss of each, m².
    pub(crate) history: Vec<f64>,
    pub(crate) parameters: Vec<f32>,
    pub(crate) adam: Adam,
}

/// The part that JSON carries.
#[derive(Serialize, Deserialize)]
struct Header {
    run_sha256: String,
    epoch: u64,
    /// Bits of the numbers: JSON would have to round.
    history_bits: Vec<u64>,
    power_bits: [u64; 2],
}

/// Writes `state` of the run `run_sha256`, at once or not at all.
pub(crate) fn save(path: &Path, run_sha256: &str, state: &State) -> Result<(), CheckpointError> {
    let header = Header {
        run_sha256: run_sha256.to_owned(),
        epoch: state.epoch,
        history_bits: state.history.iter().map(|loss| loss.to_bits()).collect(),
        power_bits: state.adam.powers.map(f64::to_bits),
    };
    let foreign = |what: String| CheckpointError::Foreign { path: path.to_owned(), what };
    let json = serde_json::to_string(&header).map_err(|error| foreign(error.to_string()))?;
    let bytes: [Vec<u8>; 3] = [&state.parameters, &state.adam.first, &state.adam.second]
        .map(|values| values.iter().flat_map(|v| v.to_le_bytes()).collect());
    let tensors = ["parameters", "first_moment", "second_moment"].iter().zip(&bytes);
    let views = tensors
        .map(|(name, bytes)| Ok((*name, TensorView::new(Dtype::F32, vec![bytes.len() / 4], bytes)?)))
        .collect::<Result<Vec<_>, safetensors::SafeTensorError>>()
        .map_err(|error| foreign(error.to_string()))?;
    let metadata = HashMap::from([(KEY.to_owned(), json)]);
    let data = serialize(views, Some(metadata)).map_err(|error| foreign(error.to_string()))?;
    let io = |source| CheckpointError::Io { path: path.to_owned(), source };
    let mut part = path.as_os_str().to_owned();
    part.push(".part");
    std::fs::write(&part, data).map_err(io)?;
    std::fs::rename(&part, path).map_err(io)
}

/// Reads the state of the run `run_sha256`; nothing where there is no file.
pub(crate) fn load(
    path: &Path,
    run_sha256: &str,
    parameters: usize,
) -> Result<Option<State>, CheckpointError> {
    let data = match std::fs::read(path) {
        Ok(data) => data,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(CheckpointError::Io { path: path.to_owned(), source }),
    };
    let foreign = |what: String| CheckpointError::Foreign { path: path.to_owned(), what };
    let (_, metadata) = SafeTensors::read_metadata(&data).map_err(|error| foreign(error.to_string()))?;
    let json = metadata.metadata().as_ref().and_then(|m| m.get(KEY));
    let json = json.ok_or_else(|| foreign(format!("no metadata `{KEY}`")))?;
    let header: Header = serde_json::from_str(json).map_err(|error| foreign(error.to_string()))?;
    if header.run_sha256 != run_sha256 {
        return Err(CheckpointError::OtherRun { path: path.to_owned() });
    }
    let tensors = SafeTensors::deserialize(&data).map_err(|error| foreign(error.to_string()))?;
    let read = |name: &str| {
        let tensor = tensors.tensor(name).map_err(|error| foreign(error.to_string()))?;
        let values = tensor.data().as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b));
        let values: Vec<f32> = values.collect();
        let sound = tensor.dtype() == Dtype::F32 && values.len() == parameters;
        if sound { Ok(values) } else { Err(foreign(format!("`{name}` has another shape"))) }
    };
    let powers = header.power_bits.map(f64::from_bits);
    let adam = Adam { first: read("first_moment")?, second: read("second_moment")?, powers };
    let history = header.history_bits.into_iter().map(f64::from_bits).collect();
    Ok(Some(State { epoch: header.epoch, history, parameters: read("parameters")?, adam }))
}
