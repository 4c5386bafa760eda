//! Shared memory whose creator was killed between making it and giving it a size.
//!
//! iceoryx2 waits without end for such a segment to get one, wherever it meets it: when a node opens or ends, in the
//! clean-up after a dead process, and while a port connects. It asks again every millisecond, by name, so that removing the
//! segment sets everyone free who waits for it. This is done by a watch that every [`crate::Node`] and clean-up keeps.

use std::{
    collections::HashSet,
    os::unix::fs::MetadataExt,
    path::PathBuf,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread::JoinHandle,
    time::Duration,
};

use crate::{
    Domain,
    leftovers::{SHARED_MEMORY_FOLDER, carries_prefix, entries, remove},
};

/// Pause between two looks. Making a segment and giving it a size are two system calls in a row: whatever has no size at
/// two looks has lost its creator, or a creator that has been stopped for this long and will be taken for dead anyway.
const PAUSE: Duration = Duration::from_millis(500);

/// Removes stillborn segments of one domain until the last clone is dropped. Holds a thread that sleeps.
#[derive(Debug, Clone)]
pub(crate) struct StillbornWatch {
    _thread: Arc<WatchThread>,
}

#[derive(Debug)]
struct WatchThread {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl StillbornWatch {
    /// Starts watching. Where the system refuses another thread, nobody watches, and a warning says so.
    pub(crate) fn start(domain: &Domain) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let (domain, stopped) = (domain.clone(), Arc::clone(&stop));
        let thread = std::thread::Builder::new()
            .name("cncbf-stillborn".to_owned())
            .spawn(move || watch(&domain, &stopped));
        if let Err(error) = &thread {
            tracing::warn!(%error, "nobody watches for segments whose creator was killed");
        }
        Self { _thread: Arc::new(WatchThread { stop, thread: thread.ok() }) }
    }
}

impl Drop for WatchThread {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            let _ = thread.join();
        }
    }
}

fn watch(domain: &Domain, stop: &AtomicBool) {
    let mut suspects = HashSet::new();
    while !stop.load(Ordering::Relaxed) {
        let sizeless = sizeless_segments(domain);
        for (path, _) in sizeless.intersection(&suspects) {
            tracing::warn!(path = %path.display(), "removing a segment whose creator was killed");
            if let Err(error) = remove(path) {
                tracing::warn!(%error);
            }
        }
        suspects = sizeless;
        std::thread::park_timeout(PAUSE);
    }
}

/// Segments of `domain` without a size, with their inode, which tells a segment from its namesake and successor.
fn sizeless_segments(domain: &Domain) -> HashSet<(PathBuf, u64)> {
    let segments = entries(SHARED_MEMORY_FOLDER.as_ref()).unwrap_or_default();
    let ours = segments.into_iter().filter(|path| carries_prefix(path, domain));
    ours.filter_map(|path| {
        let metadata = path.symlink_metadata().ok()?;
        (metadata.len() == 0).then(|| (path, metadata.ino()))
    })
    .collect()
}
