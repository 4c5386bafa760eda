//! Memory that is there before the loop begins, and stays.
//!
//! Two things, since each works without the other: touching what the loop will use, for which nobody needs rights, and
//! forbidding the kernel to take any of it away again.

use std::hint::black_box;

use rustix::{
    mm::{MlockAllFlags, mlockall, munlockall},
    process::{Resource, getrlimit},
};

use super::{
    granted::{Grant, Right},
    rights::can_lock_any_amount,
};
use crate::UsageMeter;

/// Heap that is touched and kept: loops allocate nothing, but a peer that comes or goes costs some.
const HEAP_BYTES: usize = 4 << 20;
/// Heap is taken in pieces below the size from which allocators map each piece separately.
const PIECE_BYTES: usize = 64 << 10;
/// Size of one block whose release tells glibc to keep what is freed: it then maps no block smaller than this separately, and
/// returns no free end of the heap shorter than twice this (mallopt(3), "dynamic mmap threshold").
const KEPT_FROM_BYTES: usize = 16 << 20;
/// Stack below the loop that is touched: a hundred times what a filter cycle uses.
const STACK_BYTES: usize = 256 << 10;
/// Page faults of a second pass that count as none: the kernel may move a page at any time.
const FAULTS_ALLOWED: u32 = 8;

/// Touches heap and stack, then goes over them again and counts the page faults that are left.
pub(super) fn prefault() -> Grant {
    let asked = format!("{} KiB of heap, {} KiB of stack", HEAP_BYTES >> 10, STACK_BYTES >> 10);
    let kept: Vec<u8> = Vec::with_capacity(KEPT_FROM_BYTES);
    drop(black_box(kept));
    touch_heap();
    touch_stack();
    let mut usage = UsageMeter::new();
    touch_heap();
    touch_stack();
    let faults = usage.since_last().minor_faults;
    let got = format!("{faults} page faults in a second pass");
    if faults <= FAULTS_ALLOWED {
        Grant::granted(Right::Prefault, asked, got)
    } else {
        let advice = "the allocator gives freed memory back; unset MALLOC_TRIM_THRESHOLD_ and MALLOC_MMAP_THRESHOLD_, use glibc";
        Grant::refused(Right::Prefault, asked, got, advice)
    }
}

/// Takes [`HEAP_BYTES`], writes to all of it, and frees it.
fn touch_heap() {
    let pieces: Vec<Vec<u8>> = (0..HEAP_BYTES / PIECE_BYTES).map(|_| vec![1; PIECE_BYTES]).collect();
    black_box(pieces);
}

/// Writes to [`STACK_BYTES`] below the caller's frame.
#[inline(never)]
fn touch_stack() {
    #[expect(clippy::large_stack_arrays, reason = "the stack is what is to be touched")]
    let block = [1_u8; STACK_BYTES];
    black_box(&block);
}

/// Locks everything that is mapped, shared memory included, and what will be.
///
/// Where a limit applies, later mappings are left out: each one beyond the limit would fail, and with it the allocation or
/// the port that needs it.
pub(super) fn lock() -> Grant {
    let limit = getrlimit(Resource::Memlock).current.filter(|_| !can_lock_any_amount());
    let asked = "all memory, now and later".to_owned();
    let outcome = mlockall(reach(limit));
    let locked_kib = locked_kib().unwrap_or(0);
    // The kernel counts reserved addresses as locked, which take no memory; what is in RAM now will stay there.
    let locked = format!("{} MiB", status_kib("VmRSS:").unwrap_or(0) >> 10);
    match (outcome, limit) {
        (Ok(()), None) if locked_kib > 0 => {
            Grant::granted(Right::MemoryLock, asked, format!("{locked} locked"))
        }
        (Ok(()), Some(bytes)) => Grant::refused(
            Right::MemoryLock,
            asked,
            format!("{locked} locked, nothing that comes later"),
            advice(bytes),
        ),
        (Err(error), Some(bytes)) => {
            Grant::refused(Right::MemoryLock, asked, error.to_string(), advice(bytes))
        }
        (Ok(()), None) => Grant::refused(
            Right::MemoryLock,
            asked,
            "nothing is locked".to_owned(),
            "a sandbox answers for the kernel; allow mlockall",
        ),
        (Err(error), None) => Grant::refused(
            Right::MemoryLock,
            asked,
            error.to_string(),
            "a sandbox forbids mlockall, or memory is short; allow it, or free some",
        ),
    }
}

/// Which memory to lock where `limit` bytes may be locked.
const fn reach(limit: Option<u64>) -> MlockAllFlags {
    match limit {
        None => MlockAllFlags::CURRENT.union(MlockAllFlags::FUTURE),
        Some(_) => MlockAllFlags::CURRENT,
    }
}

fn advice(limit_bytes: u64) -> String {
    format!(
        "RLIMIT_MEMLOCK is {} KiB: add `USER - memlock unlimited` to /etc/security/limits.conf and log in again, or \
         LimitMEMLOCK=infinity to the systemd unit, or --ulimit memlock=-1 to the container",
        limit_bytes >> 10
    )
}

/// Takes the lock off again.
pub(super) fn unlock() {
    if let Err(error) = munlockall() {
        tracing::warn!(%error, "the memory stays locked");
    }
}

/// Locked addresses of this process, KiB, as the kernel counts them.
pub(super) fn locked_kib() -> Option<u64> {
    status_kib("VmLck:")
}

/// One line of this process' status, KiB.
fn status_kib(key: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    status.lines().find_map(|line| line.strip_prefix(key)?.trim().strip_suffix("kB")?.trim().parse().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn under_a_limit_what_comes_later_is_left_out_since_it_would_fail() {
        assert!(reach(None).contains(MlockAllFlags::FUTURE));
        assert_eq!(reach(Some(1 << 40)), MlockAllFlags::CURRENT);
    }

    #[test]
    fn touched_heap_is_kept() {
        // On a thread of its own, as a control thread that is not the main one; its arena must keep what is freed, too.
        let grant = std::thread::spawn(prefault).join().unwrap();
        assert!(grant.granted, "{grant:?}");
    }
}
