//! How much memory a solve takes and how much there is.

use crate::{Grid, SolveError};
use sysinfo::System;

/// Returns a bound on the heap a solve takes, bytes, for `inputs` control and disturbance components together.
///
/// Five values per node (value, failure function, value at the last check, two stages of the time step), one
/// while the dynamics are tabulated, and the table itself, counted as if no coefficient could be compressed.
pub fn memory_needed_at_most_bytes<const N: usize>(grid: &Grid<N>, inputs: usize) -> u64 {
    let table = N * (2 + inputs);
    (grid.node_count() as u64).saturating_mul(((5 + 1 + table) * size_of::<f32>()) as u64)
}

/// Returns how many bytes this process may still take: of the machine, or of its control group if that has fewer.
pub fn memory_available_bytes() -> u64 {
    let mut system = System::new();
    system.refresh_memory();
    let of_group = system.cgroup_limits().map_or(u64::MAX, |limits| limits.free_memory);
    system.available_memory().min(of_group)
}

/// Refuses a solve that would not fit, before anything is allocated.
pub(crate) fn refuse_what_does_not_fit(needed_bytes: u64) -> Result<(), SolveError> {
    let available_bytes = memory_available_bytes();
    if needed_bytes > available_bytes {
        return Err(SolveError::Memory { needed_bytes, available_bytes });
    }
    Ok(())
}
