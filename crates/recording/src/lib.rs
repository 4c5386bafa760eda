//! MCAP in and out: ROS 2 messages and raw wire messages.
//!
//! Lives here: the ROS 2 message types the stack speaks, with their schemas and CDR coding ([`ros2`], [`cdr`]); a reader
//! that hands over every good message of a recording and counts every bad one ([`McapReader`]); the exact replay of wire
//! messages ([`read_wire`]); and the [`Recorder`], which writes what flows through the stack so that ROS tools open it.
//!
//! Writing is the `mcap` crate's. Reading is our own, over the same record layout, for one reason: the crate's readers
//! end at the first damage, or check no chunk's CRC, or believe a damaged length field and ask for gigabytes. A
//! recording is evidence, and one flipped bit must cost one chunk, not the file and not the process. The crate's reader
//! is the judge in the tests.
//!
//! Deliberately absent: what a message means (frames, radii, identities, time mapping: `perception_bridge`), ports and
//! clocks (`node_runtime`).

pub mod cdr;
mod container;
mod message;
mod reader;
mod recorder;
mod refusal;
pub mod ros2;
mod summary;
mod wire;

pub use message::{RecordedKind, RecordedMessage};
pub use reader::{McapReader, OpenError};
pub use recorder::{RecordError, Recorder, RecorderReport, RecordingInfo, SHADOW_KEY};
pub use recorder::{curve_marker, obstacle_markers};
pub use refusal::{RefusalCounts, RefusalReason};
pub use summary::{ChannelSummary, Damage, RecordingSummary};
pub use wire::{ReadWireError, WIRE_ENCODING, WIRE_TYPE_NOTE, WireMessage, read_wire, wire_topic};
