//! A search on disc, so that it may go on where it stopped: one safetensors file, replaced in one step.

use std::collections::HashMap;
use std::io;
use std::path::Path;

use safetensors::tensor::{Dtype, TensorView};
use safetensors::{SafeTensors, serialize};

use super::cell::Cell;
use super::error::AffineError;
use super::question::Identity;
use super::search::{Search, Tally, Witness};

const IDENTITY: &str = "cncbf_affine";

/// Writes the search beside `path` and renames it into place.
pub(crate) fn save(path: &Path, identity: &Identity, search: &Search<'_>) -> Result<(), AffineError> {
    let refused = |source: io::Error| AffineError::Io { path: path.to_owned(), source };
    let cells: Vec<&Cell> = search.stack.iter().chain(&search.waiting).collect();
    let halvings: Vec<u8> = cells.iter().flat_map(|cell| cell.halvings).collect();
    let index: Vec<u8> = cells.iter().flat_map(|cell| cell.index).flat_map(u32::to_le_bytes).collect();
    let lower: Vec<u8> = cells.iter().flat_map(|cell| cell.lower.to_le_bytes()).collect();
    let Tally { boxes, outside, proven, aside, aside_lower, worst } = search.tally;
    let counts = [boxes, outside, proven, aside, search.stack.len() as u64];
    let counts: Vec<u8> = counts.into_iter().flat_map(u64::to_le_bytes).collect();
    let mut bounds = vec![aside_lower];
    if let Some(worst) = worst {
        bounds.extend(worst.z);
        bounds.extend([worst.barrier_m, worst.condition_mps]);
    }
    let bound_count = bounds.len();
    let bounds: Vec<u8> = bounds.into_iter().flat_map(f64::to_le_bytes).collect();
    let view = |dtype, shape, data| {
        TensorView::new(dtype, shape, data).map_err(|error| refused(io::Error::other(error)))
    };
    let n = cells.len();
    let tensors = [
        ("halvings", view(Dtype::U8, vec![n, 4], &halvings)?),
        ("index", view(Dtype::U32, vec![n, 4], &index)?),
        ("lower", view(Dtype::F64, vec![n], &lower)?),
        ("counts", view(Dtype::U64, vec![5], &counts)?),
        ("bounds", view(Dtype::F64, vec![bound_count], &bounds)?),
    ];
    let text = serde_json::to_string(identity).map_err(|error| refused(io::Error::other(error)))?;
    let metadata = HashMap::from([(IDENTITY.to_owned(), text)]);
    let bytes = serialize(tensors, Some(metadata)).map_err(|error| refused(io::Error::other(error)))?;
    let mut unfinished = path.as_os_str().to_owned();
    unfinished.push(".unfinished");
    std::fs::write(&unfinished, bytes).map_err(refused)?;
    std::fs::rename(&unfinished, path).map_err(refused)
}

/// Puts what `path` holds into `search`; leaves it as it is where there is no such file.
pub(crate) fn resume(path: &Path, identity: &Identity, search: &mut Search<'_>) -> Result<(), AffineError> {
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(source) => return Err(AffineError::Io { path: path.to_owned(), source }),
    };
    let damaged = |reason: String| AffineError::NoCheckpoint { path: path.to_owned(), reason };
    let (_, header) = SafeTensors::read_metadata(&bytes).map_err(|error| damaged(error.to_string()))?;
    let text = header.metadata().as_ref().and_then(|metadata| metadata.get(IDENTITY));
    let text = text.ok_or_else(|| damaged(format!("no `{IDENTITY}` in its metadata")))?;
    let found: Identity = serde_json::from_str(text).map_err(|error| damaged(error.to_string()))?;
    if let Some(what) = found.difference(identity) {
        return Err(AffineError::AnotherQuestion { path: path.to_owned(), what });
    }
    let tensors = SafeTensors::deserialize(&bytes).map_err(|error| damaged(error.to_string()))?;
    let tensor = |name: &str, dtype| {
        let tensor = tensors.tensor(name).map_err(|error| damaged(error.to_string()))?;
        if tensor.dtype() != dtype {
            return Err(damaged(format!("`{name}` has another type")));
        }
        Ok(tensor.data())
    };
    let (halvings, _) = tensor("halvings", Dtype::U8)?.as_chunks::<4>();
    let (index, _) = tensor("index", Dtype::U32)?.as_chunks::<16>();
    let lower = floats(tensor("lower", Dtype::F64)?);
    let counts: Vec<u64> =
        tensor("counts", Dtype::U64)?.as_chunks().0.iter().map(|bytes| u64::from_le_bytes(*bytes)).collect();
    let bounds = floats(tensor("bounds", Dtype::F64)?);
    let &[boxes, outside, proven, aside, stacked] = counts.as_slice() else {
        return Err(damaged("`counts` has another length".to_owned()));
    };
    let (aside_lower, worst) = match *bounds.as_slice() {
        [aside_lower] => (aside_lower, None),
        [aside_lower, x, y, third, fourth, barrier_m, condition_mps] => {
            (aside_lower, Some(Witness { z: [x, y, third, fourth], barrier_m, condition_mps }))
        }
        _ => return Err(damaged("`bounds` has another length".to_owned())),
    };
    let stacked = usize::try_from(stacked).unwrap_or(usize::MAX);
    if halvings.len() != index.len() || index.len() != lower.len() || stacked > lower.len() {
        return Err(damaged("its cells have several lengths".to_owned()));
    }
    let mut cells: Vec<Cell> = Vec::with_capacity(lower.len());
    for ((halvings, index), lower) in halvings.iter().zip(index).zip(&lower) {
        let part = |i: usize| [index[4 * i], index[4 * i + 1], index[4 * i + 2], index[4 * i + 3]];
        let index = core::array::from_fn(|i| u32::from_le_bytes(part(i)));
        let cell = Cell { halvings: *halvings, index, lower: *lower };
        if !cell.is_possible() {
            return Err(damaged("one of its cells is none".to_owned()));
        }
        cells.push(cell);
    }
    let covered = cells.iter().try_fold(outside, |sum, cell| sum.checked_add(cell.share()));
    let covered = covered.and_then(|sum| sum.checked_add(proven)).and_then(|sum| sum.checked_add(aside));
    if covered != Some(Cell::WHOLE.share()) {
        return Err(damaged("its cells do not make up the region".to_owned()));
    }
    search.waiting = cells.split_off(stacked).into();
    search.stack = cells;
    search.tally = Tally { boxes, outside, proven, aside, aside_lower, worst };
    Ok(())
}

fn floats(bytes: &[u8]) -> Vec<f64> {
    bytes.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect()
}
