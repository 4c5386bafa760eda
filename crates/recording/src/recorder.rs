//! Writes what flows through the stack to an MCAP file: raw for exact replay, and as ROS 2 messages for ROS tools.
//!
//! Lives here: the hand-over from the recording process to its writer thread. What becomes of a message is `convert`,
//! how it reaches the file is `writer`.

mod convert;
mod markers;
mod writer;

pub use markers::{curve_marker, obstacle_markers};

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;

use crate::wire::WireMessage;
use writer::Writer;

/// Messages that may wait for the writer: several seconds of a whole stack, about 16 MB.
const QUEUE_LENGTH: usize = 2048;

/// Key in a recording's metadata record `cncbf` that is there where the filter only watched.
pub const SHADOW_KEY: &str = "shadow";

/// What a recording says about itself, in its metadata record `cncbf`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RecordingInfo {
    /// Version of this program.
    pub version: String,
    /// Name of the evaluation kernel; replays are byte-identical only with the same one.
    pub kernel: String,
    /// The settings as TOML.
    pub settings: String,
    /// Whether the filter only watched: the robot obeyed somebody else.
    pub shadow: bool,
    /// Name of the world frame in the ROS messages.
    pub odom_frame: String,
    /// Name of the robot's frame in the ROS messages.
    pub base_frame: String,
}

impl RecordingInfo {
    pub(crate) fn entries(&self) -> BTreeMap<String, String> {
        let entries = [("version", &self.version), ("kernel", &self.kernel), ("settings", &self.settings)];
        let mut entries: BTreeMap<_, _> = entries.map(|(key, value)| (key.to_owned(), value.clone())).into();
        if self.shadow {
            entries.insert(SHADOW_KEY.to_owned(), "true".to_owned());
        }
        entries
    }
}

/// Why a recording cannot be made or completed.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The file cannot be created.
    #[error("cannot create the recording {}: {source}; check folder and rights", path.display())]
    Create {
        /// The file.
        path: PathBuf,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// The thread that writes cannot be started.
    #[error("cannot start the thread that writes the recording: {source}")]
    Thread {
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// Writing failed; what was flushed before is readable.
    #[error("writing the recording {} failed: {reason}; is the disk full?", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What went wrong.
        reason: String,
    },
}

/// What became of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecorderReport {
    /// The file.
    pub path: PathBuf,
    /// Wire messages written.
    pub written: u64,
    /// Wire messages dropped because the writer did not keep up.
    pub dropped: u64,
}

/// Takes messages without ever waiting; a thread of its own writes them.
///
/// Dropped without [`Recorder::finish`], it still completes the file, but nobody hears of errors.
#[derive(Debug)]
pub struct Recorder {
    path: PathBuf,
    queue: Option<SyncSender<(u64, WireMessage)>>,
    thread: Option<JoinHandle<Result<u64, RecordError>>>,
    dropped: Arc<AtomicU64>,
}

impl Recorder {
    /// Creates the file and starts writing.
    ///
    /// # Errors
    /// [`RecordError`] if the file cannot be created or the thread not started.
    pub fn create(path: &Path, info: RecordingInfo) -> Result<Self, RecordError> {
        let (queue, messages) = sync_channel(QUEUE_LENGTH);
        let mut writer = Writer::create(path, info)?;
        let thread = std::thread::Builder::new()
            .name("recording-writer".to_owned())
            .spawn(move || writer.run(&messages))
            .map_err(|source| RecordError::Thread { source })?;
        let dropped = Arc::new(AtomicU64::new(0));
        Ok(Self { path: path.to_owned(), queue: Some(queue), thread: Some(thread), dropped })
    }

    /// Hands over a message with its log time (stack clock, ns). Whether there was room for it; if not, it is counted as
    /// dropped. Never waits, allocates nothing.
    pub fn record(&mut self, log_time_ns: u64, message: impl Into<WireMessage>) -> bool {
        let Some(queue) = &self.queue else { return false };
        match queue.try_send((log_time_ns, message.into())) {
            Ok(()) => true,
            Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => {
                self.dropped.fetch_add(1, Ordering::Relaxed);
                false
            }
        }
    }

    /// Hands over a message and waits until there is room: for replays in virtual time, which may outrun the disk. Whether
    /// the writer still lives.
    pub fn record_waiting(&mut self, log_time_ns: u64, message: impl Into<WireMessage>) -> bool {
        self.queue.as_ref().is_some_and(|queue| queue.send((log_time_ns, message.into())).is_ok())
    }

    /// Messages dropped so far.
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    /// Writes what is waiting, completes the file with its index, and closes it.
    ///
    /// # Errors
    /// [`RecordError::Write`] if anything could not be written, now or earlier.
    pub fn finish(mut self) -> Result<RecorderReport, RecordError> {
        let written = self.close()?;
        Ok(RecorderReport { path: self.path.clone(), written, dropped: self.dropped() })
    }

    fn close(&mut self) -> Result<u64, RecordError> {
        self.queue = None;
        match self.thread.take().map(JoinHandle::join) {
            None => Ok(0),
            Some(Ok(result)) => result,
            Some(Err(_)) => Err(RecordError::Write {
                path: self.path.clone(),
                reason: "the writer thread panicked".into(),
            }),
        }
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        if let Err(error) = self.close() {
            tracing::error!("{error}");
        }
    }
}
