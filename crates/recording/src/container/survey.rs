//! What a file holds: its channels, where its good chunks lie, and what is wrong with it.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use super::chunk::{ChunkError, open};
use super::records::{Record, Records};
use crate::message::{Codec, ros2_codec, wire_codec};
use crate::refusal::{RefusalCounts, RefusalReason};
use crate::summary::Damage;
use crate::wire::{WIRE_ENCODING, WIRE_TYPE_NOTE};

/// A stream of messages of one type.
#[derive(Debug, Clone)]
pub(crate) struct Channel {
    pub(crate) topic: Arc<str>,
    pub(crate) type_name: String,
    pub(crate) encoding: String,
    /// How its messages are read, or why they are refused.
    pub(crate) codec: Result<Codec, RefusalReason>,
    /// Messages in readable chunks, good or not.
    pub(crate) messages: u64,
}

/// A readable chunk.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ChunkPlace {
    /// Where the content of the chunk record begins in the file.
    pub(crate) content_at: u64,
    /// Length of that content.
    pub(crate) length: u64,
    /// Earliest log time of its messages, ns.
    pub(crate) start_ns: u64,
}

/// A message outside of any chunk.
#[derive(Debug, Clone)]
pub(crate) struct LooseMessage {
    pub(crate) channel_id: u16,
    pub(crate) sequence: u32,
    pub(crate) log_time_ns: u64,
    pub(crate) data: Vec<u8>,
}

struct Schema {
    name: String,
    encoding: String,
    data: Vec<u8>,
}

/// What was found so far.
#[derive(Default)]
pub(crate) struct Survey {
    pub(crate) profile: String,
    pub(crate) library: String,
    schemas: HashMap<u16, Schema>,
    pub(crate) channels: BTreeMap<u16, Channel>,
    pub(crate) chunks: Vec<ChunkPlace>,
    pub(crate) loose: Vec<LooseMessage>,
    pub(crate) metadata: BTreeMap<String, BTreeMap<String, String>>,
    pub(crate) unchecked_chunks: u64,
    pub(crate) damage: Vec<Damage>,
    pub(crate) refusals: RefusalCounts,
    /// Messages met, good or not.
    pub(crate) messages: u64,
    /// Earliest and latest log time, ns.
    pub(crate) log_span_ns: Option<(u64, u64)>,
}

impl Survey {
    /// Takes in a record that stands outside of any chunk.
    pub(crate) fn note(&mut self, record: Record<'_>) {
        match record {
            Record::Header { profile, library } => (self.profile, self.library) = (profile, library),
            Record::Schema { id, name, encoding, data } => {
                self.schemas.entry(id).or_insert_with(|| Schema { name, encoding, data: data.to_vec() });
            }
            Record::Channel { id, schema_id, topic, message_encoding, notes } => {
                self.channels.entry(id).or_insert_with(|| {
                    channel(self.schemas.get(&schema_id), topic, message_encoding, &notes)
                });
            }
            Record::Message { channel_id, sequence, log_time_ns, data } => {
                if self.note_message(channel_id, log_time_ns) {
                    let data = data.to_vec();
                    self.loose.push(LooseMessage { channel_id, sequence, log_time_ns, data });
                }
            }
            Record::Metadata { name, entries } => {
                self.metadata.entry(name).or_default().extend(entries);
            }
            Record::DataEnd { .. } | Record::ChunkIndex { .. } | Record::Footer { .. } | Record::Other => {}
        }
    }

    /// Counts a message; whether it can be read.
    fn note_message(&mut self, channel_id: u16, log_time_ns: u64) -> bool {
        self.messages += 1;
        let (first, last) = self.log_span_ns.unwrap_or((log_time_ns, log_time_ns));
        self.log_span_ns = Some((first.min(log_time_ns), last.max(log_time_ns)));
        let Some(channel) = self.channels.get_mut(&channel_id) else {
            self.refusals.add(RefusalReason::UnknownChannel, 1);
            return false;
        };
        channel.messages += 1;
        if let Err(reason) = channel.codec {
            self.refusals.add(reason, 1);
            return false;
        }
        true
    }

    /// Opens a chunk, takes in its records and remembers its place. Messages stay where they are.
    ///
    /// # Errors
    /// [`ChunkError`] if nothing of it can be trusted; the damage is then noted, its messages are not yet counted.
    pub(crate) fn note_chunk(&mut self, content_at: u64, body: &[u8]) -> Result<(), ChunkError> {
        let chunk = open(body).inspect_err(|error| {
            self.damage.push(Damage::Chunk { at_byte: content_at, reason: error.to_string() });
        })?;
        self.unchecked_chunks += u64::from(!chunk.is_checked);
        let mut start_ns = None::<u64>;
        for record in Records::new(&chunk.records) {
            match record {
                Ok(Record::Message { channel_id, log_time_ns, .. }) => {
                    if self.note_message(channel_id, log_time_ns) {
                        start_ns = Some(start_ns.map_or(log_time_ns, |start| start.min(log_time_ns)));
                    }
                }
                Ok(record) => self.note(record),
                Err(()) => {
                    self.damage.push(Damage::Record { at_byte: content_at });
                    self.refuse_lost(RefusalReason::MalformedRecord, 1);
                }
            }
        }
        if let Some(start_ns) = start_ns {
            self.chunks.push(ChunkPlace { content_at, length: body.len() as u64, start_ns });
        }
        Ok(())
    }

    /// Counts messages that were there but cannot even be looked at.
    pub(crate) fn refuse_lost(&mut self, reason: RefusalReason, count: u64) {
        self.messages += count;
        self.refusals.add(reason, count);
    }
}

/// A channel as its record, its schema and its notes declare it.
fn channel(
    schema: Option<&Schema>,
    topic: String,
    encoding: String,
    notes: &BTreeMap<String, String>,
) -> Channel {
    let (type_name, codec) = match (schema, notes.get(WIRE_TYPE_NOTE)) {
        (_, Some(wire_type)) if encoding == WIRE_ENCODING => (wire_type.clone(), wire_codec(wire_type)),
        (Some(schema), _) => {
            (schema.name.clone(), ros2_codec(&encoding, &schema.name, &schema.encoding, &schema.data))
        }
        (None, _) => (String::new(), Err(RefusalReason::UnknownSchema)),
    };
    Channel { topic: topic.into(), type_name, encoding, codec, messages: 0 }
}
