//! The MCAP file as records and chunks, read so that damage stays where it is.
//!
//! Lives here: framing, checksums, decompression, the survey of a whole file and its messages in log-time order. Not
//! here: what a message's bytes mean (`message`, `ros2`).

mod chunk;
mod fields;
mod ordered;
mod records;
mod scan;
mod source;
mod survey;

pub(crate) use ordered::{OrderedMessages, RawMessage};
pub(crate) use scan::{ScanError, scan};
pub(crate) use survey::Survey;
