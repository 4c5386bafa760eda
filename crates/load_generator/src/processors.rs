//! The processors that may be loaded, their caches, and the policy under which this process runs.

use std::collections::BTreeMap;
use std::path::Path;

use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

use crate::LoadError;

/// Policies of the kernel under which other programs still run: SCHED_OTHER, SCHED_BATCH, SCHED_IDLE.
const HARMLESS_POLICIES: [u32; 3] = [0, 3, 5];

/// Processors that this process may use; one if the kernel does not say.
pub(crate) fn allowed() -> Vec<usize> {
    let allowed: Vec<usize> = sched_getaffinity(None)
        .map(|set| (0..CpuSet::MAX_CPU).filter(|&processor| set.is_set(processor)).collect())
        .unwrap_or_default();
    if allowed.is_empty() { vec![0] } else { allowed }
}

/// Keeps the calling thread on one processor. Where the kernel refuses, its own balance spreads the threads.
pub(crate) fn stay_on(processor: usize) {
    let mut set = CpuSet::new();
    set.set(processor);
    // Refusal changes the spread, not the load.
    let _ = sched_setaffinity(None, &set);
}

/// Refuses to go on at a real-time priority.
pub(crate) fn refuse_real_time() -> Result<(), LoadError> {
    let stat = procfs::process::Process::myself().and_then(|process| process.stat());
    match stat.ok().and_then(|stat| stat.policy) {
        Some(policy) if !HARMLESS_POLICIES.contains(&policy) => Err(LoadError::RealTime { policy }),
        Some(_) | None => Ok(()),
    }
}

/// Size of all last-level caches together, bytes; 0 if the kernel does not say.
pub(crate) fn last_caches_bytes() -> u64 {
    let mut caches = BTreeMap::new();
    for processor in allowed() {
        let folder = format!("/sys/devices/system/cpu/cpu{processor}/cache");
        let indexes = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let last = indexes.filter_map(|index| cache(&index.path())).max_by_key(|(level, ..)| *level);
        if let Some((_, shared_by, bytes)) = last {
            caches.insert(shared_by, bytes);
        }
    }
    caches.values().sum()
}

/// Level, the processors that share it, and bytes of one cache.
fn cache(folder: &Path) -> Option<(u32, String, u64)> {
    let read = |name| std::fs::read_to_string(folder.join(name)).ok().map(|text| text.trim().to_owned());
    let kibibytes: u64 = read("size")?.strip_suffix('K')?.parse().ok()?;
    Some((read("level")?.parse().ok()?, read("shared_cpu_list")?, kibibytes << 10))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_a_processor() {
        assert!(!allowed().is_empty());
    }
}
