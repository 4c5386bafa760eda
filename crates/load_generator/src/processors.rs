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
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    match policy(&stat) {
        Some(policy) if !HARMLESS_POLICIES.contains(&policy) => Err(LoadError::RealTime { policy }),
        Some(_) | None => Ok(()),
    }
}

/// The scheduling policy in `/proc/PID/stat`: field 41, of which two stand before the end of the program's name.
fn policy(stat: &str) -> Option<u32> {
    let (_, fields) = stat.rsplit_once(')')?;
    fields.split_whitespace().nth(38)?.parse().ok()
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
    fn the_policy_is_found_behind_any_name() {
        let fields: Vec<String> = (3..=52).map(|field| field.to_string()).collect();
        let stat = format!("7 (a) b (c) {}", fields.join(" "));
        assert_eq!(policy(&stat), Some(41));
        assert_eq!(policy("7 (cut off) S 1"), None);
        let own = std::fs::read_to_string("/proc/self/stat").expect("the kernel tells");
        assert_eq!(policy(&own), Some(0), "tests run at the default policy");
    }

    #[test]
    fn there_is_a_processor() {
        assert!(!allowed().is_empty());
    }
}
