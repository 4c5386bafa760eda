//! Bounded load on processors, memory or disk: what a stack has to live beside while it is measured.
//!
//! [`generate`] works until it is told to stop and then says what it did. It belongs into a process of its own, at the
//! default scheduler: never into one of the stack's, whose heap, caches and accounting it would share.
//!
//! The crates there are (`stress-cpu`, `cpu-stress`, `test_cpu_parallel`) run for a time fixed beforehand, load only the
//! processors or have no bound on memory, and do not tell what they did; `stress-ng` is a program that few robots carry.
//! Hence these few lines.
//!
//! What is deliberately absent: a clock of its own, and any wish to be fast. The figures say that there was load, how much,
//! and that it did not cease.

mod cpu;
mod io;
mod memory;
mod processors;
mod workers;

use std::path::{Path, PathBuf};

use node_runtime::Clock;
use serde::{Deserialize, Serialize};

pub use io::FILE_BYTES;
pub use memory::{LARGEST_BUFFER_BYTES, SMALLEST_BUFFER_BYTES};

/// What is kept busy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LoadKind {
    /// One thread on each processor computes in its registers.
    Cpu,
    /// One thread on each processor reads and writes through its share of a buffer that no cache holds.
    Memory,
    /// One thread writes a temporary file block by block, each forced to the disk, removes it, and begins anew.
    Io,
}

impl LoadKind {
    /// Every kind.
    pub const ALL: [Self; 3] = [Self::Cpu, Self::Memory, Self::Io];

    /// Name on the command line and in figures.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Cpu => "cpu",
            Self::Memory => "memory",
            Self::Io => "io",
        }
    }
}

impl core::fmt::Display for LoadKind {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.pad(self.label())
    }
}

/// What was done until it was told to stop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LoadReport {
    /// What was kept busy.
    pub kind: LoadKind,
    /// Threads that did it.
    pub threads: usize,
    /// How long, s.
    pub seconds: f64,
    /// Rounds of all threads together: of arithmetic, of blocks read and written, of blocks forced to the disk.
    pub iterations: u64,
    /// Bytes read and written back, or written to the disk; 0 for [`LoadKind::Cpu`].
    pub bytes: u64,
    /// Memory or disk that was in use at most, bytes; 0 for [`LoadKind::Cpu`].
    pub footprint_bytes: u64,
}

impl LoadReport {
    /// Bytes a second, in millions.
    pub fn megabytes_per_s(&self) -> f64 {
        self.bytes as f64 * 1e-6 / self.seconds.max(1e-9)
    }
}

impl core::fmt::Display for LoadReport {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { kind, threads, seconds, iterations, footprint_bytes, .. } = self;
        let noun = if *threads == 1 { "thread" } else { "threads" };
        write!(f, "{kind}: {threads} {noun}, {seconds:.1} s, {iterations} rounds")?;
        if *footprint_bytes > 0 {
            let footprint_mb = *footprint_bytes as f64 * 1e-6;
            write!(f, ", {:.0} MB/s through {footprint_mb:.0} MB", self.megabytes_per_s())?;
        }
        Ok(())
    }
}

/// Why there is no load, or none any more.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The process runs with a real-time policy, and would freeze the machine.
    #[error(
        "this process has scheduling policy {policy}, and load at a real-time priority would freeze the machine; start it without chrt"
    )]
    RealTime {
        /// The kernel's number of the policy.
        policy: u32,
    },
    /// There is not enough memory for a buffer that no cache holds.
    #[error(
        "a buffer of {wanted_bytes} bytes is needed and {available_bytes} are available, of which a quarter may be used; end other programs"
    )]
    Memory {
        /// Bytes that no cache holds.
        wanted_bytes: u64,
        /// Bytes that programs could still use.
        available_bytes: u64,
    },
    /// The temporary file could not be made, written or forced to the disk.
    #[error("cannot write a temporary file of at most {FILE_BYTES} bytes in {}: {source}; name another folder", folder.display())]
    Disk {
        /// Where.
        folder: PathBuf,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// A thread could not be started.
    #[error("cannot start a thread: {source}; is the number of tasks limited?")]
    Thread {
        /// The operating system's reason.
        source: std::io::Error,
    },
}

/// Makes load until `stop` says so, which every thread asks after each round, a few milliseconds at most (longer only while
/// the disk keeps a block waiting). `folder` takes the temporary file of [`LoadKind::Io`].
///
/// # Errors
/// [`LoadError`] if the load cannot be made; it ends early then, on all threads.
pub fn generate(
    kind: LoadKind,
    folder: &Path,
    clock: &impl Clock,
    stop: &(impl Fn() -> bool + Sync),
) -> Result<LoadReport, LoadError> {
    processors::refuse_real_time()?;
    let began_ns = clock.now_ns();
    let done = match kind {
        LoadKind::Cpu => cpu::run(stop)?,
        LoadKind::Memory => memory::run(stop)?,
        LoadKind::Io => io::run(folder, stop)?,
    };
    let seconds = clock.now_ns().saturating_sub(began_ns) as f64 * 1e-9;
    let Done { threads, iterations, bytes, footprint_bytes } = done;
    Ok(LoadReport { kind, threads, seconds, iterations, bytes, footprint_bytes })
}

/// What the threads of one kind did.
struct Done {
    threads: usize,
    iterations: u64,
    bytes: u64,
    footprint_bytes: u64,
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use node_runtime::SteppedClock;

    use super::*;

    /// Stops each kind after a number of rounds, so that no test depends on the clock.
    fn rounds(kind: LoadKind, folder: &Path, limit: u32) -> Result<LoadReport, LoadError> {
        let asked = AtomicU32::new(0);
        let clock = SteppedClock::new(5);
        generate(kind, folder, &clock, &|| {
            clock.advance(std::time::Duration::from_millis(1));
            asked.fetch_add(1, Ordering::Relaxed) >= limit
        })
    }

    #[test]
    fn every_kind_does_what_it_says_until_it_is_stopped() {
        let folder = tempfile::tempdir().expect("a scratch folder");
        for kind in LoadKind::ALL {
            let report = rounds(kind, folder.path(), 20).expect("load");
            assert_eq!(report.kind, kind);
            assert!(report.iterations >= 20 && report.threads >= 1 && report.seconds > 0.0, "{report:?}");
            assert_eq!(report.bytes > 0, kind != LoadKind::Cpu, "{report:?}");
            assert_eq!(report.footprint_bytes > 0, kind != LoadKind::Cpu, "{report:?}");
            assert!(report.to_string().starts_with(kind.label()));
        }
        assert_eq!(
            std::fs::read_dir(folder.path()).expect("the folder").count(),
            0,
            "a file was left behind"
        );
    }

    #[test]
    fn memory_and_disk_are_bounded() {
        let folder = tempfile::tempdir().expect("a scratch folder");
        let memory = rounds(LoadKind::Memory, folder.path(), 4).expect("load");
        assert!(
            (SMALLEST_BUFFER_BYTES..=LARGEST_BUFFER_BYTES).contains(&memory.footprint_bytes),
            "{memory:?}"
        );
        // Longer than one file: it was removed and begun anew.
        let disk = rounds(LoadKind::Io, folder.path(), 40).expect("load");
        assert!(disk.bytes > FILE_BYTES && disk.footprint_bytes == FILE_BYTES, "{disk:?}");
    }

    #[test]
    fn a_folder_that_is_not_there_is_named() {
        let error = rounds(LoadKind::Io, Path::new("/nowhere/at/all"), 4).expect_err("no folder").to_string();
        assert!(error.contains("/nowhere/at/all") && error.contains("another folder"), "{error}");
    }
}
