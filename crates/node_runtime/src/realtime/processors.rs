//! Which processors the calling thread may run on.

use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

use super::granted::{Grant, Right};

/// Binds the calling thread to `processors` and reads back where it may run.
pub(super) fn ask(processors: &[usize]) -> Grant {
    let asked = list(processors.iter().copied());
    let mut wanted = CpuSet::new();
    for &processor in processors.iter().filter(|&&processor| processor < CpuSet::MAX_CPU) {
        wanted.set(processor);
    }
    let refusal = sched_setaffinity(None, &wanted).err();
    let got = allowed();
    // The kernel silently leaves out processors that it does not have.
    let all =
        processors.iter().all(|processor| got.contains(processor)) && got.len() == wanted.count() as usize;
    let told = match refusal {
        Some(error) => format!("{} ({error})", list(got.iter().copied())),
        None => list(got.iter().copied()),
    };
    if all {
        Grant::granted(Right::Processors, asked, told)
    } else {
        Grant::refused(
            Right::Processors,
            asked,
            told,
            "name processors that this machine has and that the container may use (`nproc`, `lscpu`, cpuset)",
        )
    }
}

/// Processors that the calling thread may run on.
pub(crate) fn allowed() -> Vec<usize> {
    let set = sched_getaffinity(None).unwrap_or_else(|_| CpuSet::new());
    (0..CpuSet::MAX_CPU).filter(|&processor| set.is_set(processor)).collect()
}

fn list(processors: impl Iterator<Item = usize>) -> String {
    let numbers: Vec<_> = processors.map(|processor| processor.to_string()).collect();
    if numbers.is_empty() { "none".to_owned() } else { format!("processors {}", numbers.join(", ")) }
}
