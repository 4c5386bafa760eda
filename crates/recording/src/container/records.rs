//! The records that matter here, and the walk over a run of them.

use std::collections::BTreeMap;

use super::fields::Fields;

/// Opcode and length in front of every record.
pub(crate) const RECORD_HEADER_BYTES: u64 = 9;

/// One record; borrowed, because most are only looked at.
#[derive(Debug)]
pub(crate) enum Record<'a> {
    Header {
        profile: String,
        library: String,
    },
    Schema {
        id: u16,
        name: String,
        encoding: String,
        data: &'a [u8],
    },
    Channel {
        id: u16,
        schema_id: u16,
        topic: String,
        message_encoding: String,
        notes: BTreeMap<String, String>,
    },
    Message {
        channel_id: u16,
        sequence: u32,
        log_time_ns: u64,
        data: &'a [u8],
    },
    Metadata {
        name: String,
        entries: BTreeMap<String, String>,
    },
    DataEnd {
        data_section_crc: u32,
    },
    /// Where a chunk record begins in the file.
    ChunkIndex {
        start: u64,
    },
    Footer {
        summary_start: u64,
        summary_crc: u32,
    },
    /// A record that nothing here needs.
    Other,
}

/// Reads one record's content; `None` if it does not hold what its opcode promises.
pub(crate) fn parse(opcode: u8, body: &[u8]) -> Option<Record<'_>> {
    use mcap::records::op;
    let mut fields = Fields::new(body);
    Some(match opcode {
        op::HEADER => Record::Header { profile: fields.string()?, library: fields.string()? },
        op::SCHEMA => Record::Schema {
            id: fields.u16()?,
            name: fields.string()?,
            encoding: fields.string()?,
            data: fields.sized_bytes()?,
        },
        op::CHANNEL => {
            let (id, schema_id) = (fields.u16()?, fields.u16()?);
            let (topic, message_encoding) = (fields.string()?, fields.string()?);
            Record::Channel { id, schema_id, topic, message_encoding, notes: fields.string_map()? }
        }
        op::MESSAGE => {
            let (channel_id, sequence) = (fields.u16()?, fields.u32()?);
            let (log_time_ns, _publish_time_ns) = (fields.u64()?, fields.u64()?);
            Record::Message { channel_id, sequence, log_time_ns, data: fields.rest() }
        }
        op::METADATA => Record::Metadata { name: fields.string()?, entries: fields.string_map()? },
        op::DATA_END => Record::DataEnd { data_section_crc: fields.u32()? },
        op::CHUNK_INDEX => {
            let (_start_ns, _end_ns) = (fields.u64()?, fields.u64()?);
            Record::ChunkIndex { start: fields.u64()? }
        }
        op::FOOTER => {
            let (summary_start, _summary_offset_start) = (fields.u64()?, fields.u64()?);
            Record::Footer { summary_start, summary_crc: fields.u32()? }
        }
        _ => Record::Other,
    })
}

/// Walks over records that lie one behind the other, as in a chunk or in the summary.
#[derive(Debug, Clone)]
pub(crate) struct Records<'a>(Fields<'a>);

impl<'a> Records<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self(Fields::new(bytes))
    }

    fn take(&mut self) -> Option<Record<'a>> {
        let (opcode, length) = (self.0.byte()?, self.0.u64()?);
        parse(opcode, self.0.bytes(length)?)
    }
}

impl<'a> Iterator for Records<'a> {
    /// A record, or `Err` once, where the bytes stop making sense.
    type Item = Result<Record<'a>, ()>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.0.rest().is_empty() {
            return None;
        }
        let record = self.take();
        if record.is_none() {
            self.0 = Fields::new(&[]);
        }
        Some(record.ok_or(()))
    }
}
