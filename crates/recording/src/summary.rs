//! What a recording holds, for `inspect` and for choosing topics.

use std::collections::BTreeMap;

use crate::RefusalCounts;

/// Something wrong with a file. Everything outside of it was read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Damage {
    /// The file ends, or stops making sense, before its end; messages behind this place are missing unless the file's own
    /// index led to them.
    #[error("it breaks off at byte {at_byte}: was the recorder killed? Everything before is used")]
    Truncated {
        /// Where the last good record ends.
        at_byte: u64,
    },
    /// A chunk was refused with all its messages.
    #[error("the chunk at byte {at_byte} is refused: {reason}")]
    Chunk {
        /// Where the chunk's content begins.
        at_byte: u64,
        /// What is wrong with it.
        reason: String,
    },
    /// A record does not hold what it promises.
    #[error("a record at byte {at_byte} makes no sense and is refused")]
    Record {
        /// Where it, or the chunk around it, begins.
        at_byte: u64,
    },
    /// The checksum over the whole data section is wrong: somewhere a bit changed, perhaps outside of any chunk.
    #[error("the checksum of its data section is wrong: parts that no other checksum covers may be damaged")]
    DataSection,
}

/// A stream of messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelSummary {
    /// Topic.
    pub topic: String,
    /// Type, for example `nav_msgs/msg/Odometry`.
    pub type_name: String,
    /// Encoding of the messages, for example `cdr`.
    pub encoding: String,
    /// Messages found.
    pub messages: u64,
    /// Whether this program reads them.
    pub is_readable: bool,
}

/// What a recording holds.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RecordingSummary {
    /// Profile, for example `ros2`.
    pub profile: String,
    /// The program that wrote it.
    pub library: String,
    /// Channels in the order of their ids; several may share a topic.
    pub channels: Vec<ChannelSummary>,
    /// Named sets of notes, such as ours called `cncbf`.
    pub metadata: BTreeMap<String, BTreeMap<String, String>>,
    /// Messages found, those refused included.
    pub messages: u64,
    /// Log times of the earliest and the latest message, ns.
    pub log_span_ns: Option<(u64, u64)>,
    /// Readable chunks.
    pub chunks: u64,
    /// Readable chunks that carry no checksum.
    pub unchecked_chunks: u64,
    /// What is wrong with the file.
    pub damage: Vec<Damage>,
    /// Messages refused without decoding them.
    pub refusals: RefusalCounts,
}
