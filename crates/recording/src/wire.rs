//! Raw wire messages in recordings: the exact bytes that went through shared memory.

use std::path::Path;

use bytemuck::Pod;
use messages::{
    Cycle, Detections, Goal, Health, Message, NominalCommand, Obstacles, RobotState, SafeCommand,
    SourceStatus,
};

use crate::refusal::RefusalReason;
use crate::{McapReader, OpenError};

/// Message encoding of raw wire channels.
pub const WIRE_ENCODING: &str = "cncbf-wire";

/// Channel metadata that holds the versioned type name of a raw wire channel. Such a channel has no schema: ROS tools
/// would try to understand one, and rosbags refuses the whole file over a schema language it does not know.
pub const WIRE_TYPE_NOTE: &str = "cncbf_type";

/// Topic on which the raw messages of a service are recorded.
pub fn wire_topic(service: &str) -> String {
    format!("/cncbf/wire/{service}")
}

macro_rules! wire_messages {
    ($($(#[$doc:meta])* $name:ident),+ $(,)?) => {
        /// Any message of the stack.
        #[derive(Debug, Clone, Copy, PartialEq)]
        #[expect(clippy::large_enum_variant, reason = "the recorder's queue must not allocate for each message")]
        pub enum WireMessage { $($(#[$doc])* $name($name)),+ }

        $(impl From<$name> for WireMessage {
            fn from(message: $name) -> Self { Self::$name(message) }
        })+

        impl WireMessage {
            /// Service the message travels on.
            pub fn service(&self) -> &'static str {
                match self { $(Self::$name(_) => $name::SERVICE),+ }
            }

            /// Versioned type name.
            pub fn type_name(&self) -> &'static str {
                match self { $(Self::$name(_) => $name::TYPE_NAME),+ }
            }

            /// The bytes on the wire.
            pub fn bytes(&self) -> &[u8] {
                match self { $(Self::$name(message) => bytemuck::bytes_of(message)),+ }
            }

            /// Whether this program knows a type of this name and version.
            pub(crate) fn knows(type_name: &str) -> bool {
                [$($name::TYPE_NAME),+].contains(&type_name)
            }

            /// Reads bytes as the type of this name and version.
            pub(crate) fn parse(type_name: &str, bytes: &[u8]) -> Result<Self, RefusalReason> {
                $(if type_name == $name::TYPE_NAME {
                    return parse::<$name>(bytes).map(Self::$name);
                })+
                Err(RefusalReason::WireVersion)
            }
        }
    };
}

wire_messages! {
    /// Where the robot is.
    RobotState,
    /// What was perceived.
    Detections,
    /// What was estimated.
    Obstacles,
    /// Where the robot shall go.
    Goal,
    /// What the nominal controller wants.
    NominalCommand,
    /// What the filter allows.
    SafeCommand,
    /// How far the source has come.
    SourceStatus,
    /// How a process is doing.
    Health,
    /// When a process ran.
    Cycle,
}

fn parse<T: Pod>(bytes: &[u8]) -> Result<T, RefusalReason> {
    bytemuck::try_pod_read_unaligned(bytes).map_err(|_| RefusalReason::WireSize)
}

/// Why the raw messages of a recording could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadWireError {
    /// The file itself.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// No channel of this kind.
    #[error("the recording has no raw messages on {topic}; was it made by `cncbf run --record`?")]
    NoChannel {
        /// The topic looked for.
        topic: String,
    },
    /// Another version of the type.
    #[error(
        "{topic} carries {found}, this program reads {expected}; use the program version that made the recording"
    )]
    OtherVersion {
        /// The topic.
        topic: String,
        /// Type name in the recording.
        found: String,
        /// Type name of this program.
        expected: &'static str,
    },
    /// A message that is longer or shorter than its type.
    #[error(
        "a message on {topic} has {found} bytes instead of {expected}; the recording is damaged or forged"
    )]
    Size {
        /// The topic.
        topic: String,
        /// Its bytes.
        found: usize,
        /// Bytes of the type.
        expected: usize,
    },
}

/// Reads every raw message of one type with its log time (stack clock, ns), in log-time order, bit for bit as sent.
///
/// # Errors
/// [`ReadWireError`] if the file is unreadable, has no such messages, or has them in another version or size.
pub fn read_wire<T: Message>(path: &Path) -> Result<Vec<(u64, T)>, ReadWireError> {
    let topic = wire_topic(T::SERVICE);
    let mut reader = McapReader::open(path)?;
    let found: Vec<_> = reader.summary().channels.iter().filter(|channel| channel.topic == topic).collect();
    if found.is_empty() {
        return Err(ReadWireError::NoChannel { topic });
    }
    if let Some(other) = found.iter().find(|channel| channel.type_name != T::TYPE_NAME) {
        return Err(ReadWireError::OtherVersion {
            topic,
            found: other.type_name.clone(),
            expected: T::TYPE_NAME,
        });
    }
    let mut messages = Vec::new();
    while let Some((channel_topic, raw)) = reader.next_raw() {
        if *channel_topic == *topic {
            let message = parse(&raw.data).map_err(|_| ReadWireError::Size {
                topic: topic.clone(),
                found: raw.data.len(),
                expected: size_of::<T>(),
            })?;
            messages.push((raw.log_time_ns, message));
        }
    }
    Ok(messages)
}
