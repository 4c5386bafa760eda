//! Why a recording cannot serve as a source.

use std::path::PathBuf;

use crowd_sim::PlantError;
use recording::OpenError;

/// Why a recording cannot serve as a source.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// The file itself.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The settings name a topic that the recording does not have, or not with a type that fits.
    #[error("{}: no readable {what} on topic `{topic}` ({key}); it has {available}", path.display())]
    NoSuchTopic {
        /// The recording.
        path: PathBuf,
        /// The settings key.
        key: &'static str,
        /// The topic asked for.
        topic: String,
        /// What should be on it.
        what: &'static str,
        /// What the recording has instead.
        available: String,
    },
    /// A kind of message that every source needs is missing altogether.
    #[error("{}: holds no {what}; it has {available}", path.display())]
    Missing {
        /// The recording.
        path: PathBuf,
        /// What is missing.
        what: &'static str,
        /// What the recording has instead.
        available: String,
    },
    /// All messages of a kind that every source needs were refused.
    #[error(
        "{}: none of the {what} is usable ({reasons}); check frames (source.odom_frame, source.assume_odom_frame) and stamps",
        path.display()
    )]
    NothingUsable {
        /// The recording.
        path: PathBuf,
        /// What is unusable.
        what: &'static str,
        /// Counts of the reasons.
        reasons: String,
    },
    /// It is to be played so often that the list of what to play does not fit into memory.
    #[error("{passes} passes over {messages} messages do not fit into memory; play it for a shorter time")]
    TooLong {
        /// Passes asked for.
        passes: u32,
        /// Messages of one pass.
        messages: usize,
    },
    /// The robot of a closed loop cannot be simulated.
    #[error(transparent)]
    Plant(#[from] PlantError),
}
