//! Caches emptied and the memory bus kept busy: a buffer that no cache holds, read and written back without end.

use std::hint::black_box;

use sysinfo::{MemoryRefreshKind, RefreshKind, System};

use crate::workers::{Share, on_each};
use crate::{Done, LoadError, processors};

/// The buffer is never smaller, bytes: more than the last cache of common robot computers.
pub const SMALLEST_BUFFER_BYTES: u64 = 64 << 20;
/// The buffer is never larger, bytes.
pub const LARGEST_BUFFER_BYTES: u64 = 512 << 20;

/// Times the last caches that the buffer is long.
const TIMES_CACHE: u64 = 4;
/// Words of one round, 1 MiB.
const ROUND_WORDS: usize = (1 << 20) / 8;

pub(crate) fn run(stop: &(impl Fn() -> bool + Sync)) -> Result<Done, LoadError> {
    let processors = processors::allowed();
    let wanted_bytes =
        (processors::last_caches_bytes() * TIMES_CACHE).clamp(SMALLEST_BUFFER_BYTES, LARGEST_BUFFER_BYTES);
    let what = RefreshKind::nothing().with_memory(MemoryRefreshKind::nothing().with_ram());
    let available_bytes = System::new_with_specifics(what).available_memory();
    if wanted_bytes > available_bytes / 4 {
        return Err(LoadError::Memory { wanted_bytes, available_bytes });
    }
    let words = (wanted_bytes / 8) as usize / processors.len().max(1);
    on_each(&processors, wanted_bytes, || {
        let mut share = Share::default();
        let mut buffer = vec![0_u64; words];
        loop {
            for block in buffer.chunks_mut(ROUND_WORDS) {
                for word in block.iter_mut() {
                    *word = word.wrapping_add(1);
                }
                share.iterations += 1;
                share.bytes += 2 * size_of_val(black_box(&*block)) as u64;
                if stop() {
                    return share;
                }
            }
        }
    })
}
