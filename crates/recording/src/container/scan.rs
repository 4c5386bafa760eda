//! The way through a whole file: record by record, and past what is damaged by the file's own index.

use std::collections::BTreeSet;
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;

use mcap::records::op;

use super::chunk::MAX_CHUNK_BYTES;
use super::records::{RECORD_HEADER_BYTES, Record, Records, parse};
use super::source::{Source, read_at};
use super::survey::Survey;
use crate::refusal::RefusalReason;
use crate::summary::Damage;

/// Largest record other than a chunk that is looked at, bytes. Attachments are passed over whatever their size.
const MAX_RECORD_BYTES: u64 = 64 << 20;
/// Footer record and closing magic at the end of a complete file.
const FOOTER_BYTES: u64 = RECORD_HEADER_BYTES + 20 + 8;
/// One entry of a message index: log time and offset.
const INDEX_ENTRY_BYTES: u64 = 16;

/// Why a file cannot be read at all.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ScanError {
    #[error(transparent)]
    Io(#[from] io::Error),
    #[error("empty")]
    Empty,
    #[error("not an MCAP file")]
    NotMcap,
}

/// Reads every record of `file` and says what it holds. Damage is noted and passed over.
pub(crate) fn scan(file: &File) -> Result<Survey, ScanError> {
    let mut scan = Scan {
        source: Source::new(file.try_clone()?)?,
        survey: Survey::default(),
        tried_chunks: BTreeSet::new(),
        lost_chunk: None,
        buffer: Vec::new(),
    };
    if scan.source.length() == 0 {
        return Err(ScanError::Empty);
    }
    let magic_bytes = scan.source.remaining().min(mcap::MAGIC.len() as u64);
    scan.source.read(magic_bytes, &mut scan.buffer)?;
    if scan.buffer != mcap::MAGIC {
        return Err(ScanError::NotMcap);
    }
    let indexed = scan.read_index(file)?;
    scan.walk()?;
    scan.close_lost_chunk();
    scan.follow_index(file, &indexed)?;
    Ok(scan.survey)
}

struct Scan {
    source: Source,
    survey: Survey,
    /// Where the content of each chunk begins that was opened or found damaged.
    tried_chunks: BTreeSet<u64>,
    /// The last chunk was damaged; so many of its messages have been counted by the index behind it.
    lost_chunk: Option<u64>,
    buffer: Vec<u8>,
}

impl Scan {
    /// From the first record to the footer, or to where the bytes stop making sense.
    fn walk(&mut self) -> io::Result<()> {
        loop {
            let at_byte = self.source.position();
            if self.source.remaining() < RECORD_HEADER_BYTES {
                self.survey.damage.push(Damage::Truncated { at_byte });
                return Ok(());
            }
            // The data section's checksum ends before the record that holds it.
            let checksum_so_far = self.source.checksum();
            self.source.read(RECORD_HEADER_BYTES, &mut self.buffer)?;
            let opcode = self.buffer[0];
            let mut length = [0; 8];
            length.copy_from_slice(&self.buffer[1..]);
            let length = u64::from_le_bytes(length);
            if opcode == 0 || length > self.source.remaining() {
                self.survey.damage.push(Damage::Truncated { at_byte });
                return Ok(());
            }
            match opcode {
                op::FOOTER => return Ok(()),
                op::CHUNK if length <= MAX_CHUNK_BYTES => self.chunk(length)?,
                op::MESSAGE_INDEX => self.message_index(length)?,
                op::HEADER | op::SCHEMA | op::CHANNEL | op::MESSAGE | op::METADATA | op::DATA_END
                    if length <= MAX_RECORD_BYTES =>
                {
                    self.source.read(length, &mut self.buffer)?;
                    self.record(at_byte, opcode, checksum_so_far);
                }
                op::CHUNK | op::MESSAGE => {
                    self.source.skip(length, &mut self.buffer)?;
                    let reason = format!("its {length} bytes exceed what is opened");
                    self.survey.damage.push(Damage::Chunk { at_byte, reason });
                    self.survey.refuse_lost(RefusalReason::DamagedChunk, 1);
                }
                _ => self.source.skip(length, &mut self.buffer)?,
            }
        }
    }

    fn record(&mut self, at_byte: u64, opcode: u8, checksum_so_far: u32) {
        match parse(opcode, &self.buffer) {
            Some(Record::DataEnd { data_section_crc }) => {
                if data_section_crc != 0 && data_section_crc != checksum_so_far {
                    self.survey.damage.push(Damage::DataSection);
                }
            }
            Some(record) => self.survey.note(record),
            None => {
                self.survey.damage.push(Damage::Record { at_byte });
                if opcode == op::MESSAGE {
                    self.survey.refuse_lost(RefusalReason::MalformedRecord, 1);
                }
            }
        }
    }

    fn chunk(&mut self, length: u64) -> io::Result<()> {
        self.close_lost_chunk();
        let content_at = self.source.position();
        self.source.read(length, &mut self.buffer)?;
        self.tried_chunks.insert(content_at);
        self.lost_chunk = self.survey.note_chunk(content_at, &self.buffer).is_err().then_some(0);
        Ok(())
    }

    /// Behind a damaged chunk, its index still tells how many messages are lost.
    fn message_index(&mut self, length: u64) -> io::Result<()> {
        self.source.skip(length, &mut self.buffer)?;
        if let Some(counted) = &mut self.lost_chunk {
            // Channel id and byte length come first.
            let count = length.saturating_sub(6) / INDEX_ENTRY_BYTES;
            *counted += count;
            self.survey.refuse_lost(RefusalReason::DamagedChunk, count);
        }
        Ok(())
    }

    /// A damaged chunk without any index behind it: at least one message is lost.
    fn close_lost_chunk(&mut self) {
        if self.lost_chunk.take() == Some(0) {
            self.survey.refuse_lost(RefusalReason::DamagedChunk, 1);
        }
    }

    /// Opens the chunks that the file's index names and the walk did not meet, because it lost its way before them.
    fn follow_index(&mut self, file: &File, indexed: &[u64]) -> io::Result<()> {
        for &content_at in indexed {
            if !self.tried_chunks.insert(content_at) {
                continue;
            }
            let length = record_length(file, content_at)?;
            let fits = content_at.checked_add(length).is_some_and(|end| end <= self.source.length());
            if !fits || length > MAX_CHUNK_BYTES {
                let reason = "its place in the index is wrong".to_owned();
                self.survey.damage.push(Damage::Chunk { at_byte: content_at, reason });
                self.survey.refuse_lost(RefusalReason::DamagedChunk, 1);
                continue;
            }
            read_at(file, content_at, length, &mut self.buffer)?;
            if self.survey.note_chunk(content_at, &self.buffer).is_err() {
                self.survey.refuse_lost(RefusalReason::DamagedChunk, 1);
            }
        }
        Ok(())
    }

    /// Takes schemas and channels from the end of the file, since the chunk that declares them may be lost, and answers
    /// where the content of every chunk begins. Empty if the file has no index that can be trusted.
    fn read_index(&mut self, file: &File) -> io::Result<Vec<u64>> {
        let Some(summary) = summary_section(file)? else { return Ok(Vec::new()) };
        let mut chunks = Vec::new();
        for record in Records::new(&summary) {
            match record {
                Ok(Record::ChunkIndex { start }) if start >= mcap::MAGIC.len() as u64 => {
                    chunks.extend(
                        start.checked_add(RECORD_HEADER_BYTES).filter(|at| *at < self.source.length()),
                    );
                }
                Ok(record @ (Record::Schema { .. } | Record::Channel { .. })) => self.survey.note(record),
                Ok(_) | Err(()) => {}
            }
        }
        Ok(chunks)
    }
}

/// Length of the record whose content begins at `content_at`.
fn record_length(file: &File, content_at: u64) -> io::Result<u64> {
    let mut length = [0; 8];
    file.read_exact_at(&mut length, content_at - 8)?;
    Ok(u64::from_le_bytes(length))
}

/// The records at the end of a complete file that sum it up; `None` if there are none or their checksum is wrong.
fn summary_section(file: &File) -> io::Result<Option<Vec<u8>>> {
    let length = file.metadata()?.len();
    let Some(footer_at) = length.checked_sub(FOOTER_BYTES) else { return Ok(None) };
    let mut footer = Vec::new();
    read_at(file, footer_at, FOOTER_BYTES, &mut footer)?;
    let Some(footer) = footer.strip_suffix(mcap::MAGIC) else { return Ok(None) };
    let Some(Ok(Record::Footer { summary_start, summary_crc })) = Records::new(footer).next() else {
        return Ok(None);
    };
    if summary_start == 0 || summary_start > footer_at || footer_at - summary_start > MAX_CHUNK_BYTES {
        return Ok(None);
    }
    // The checksum covers the summary and the footer up to the checksum itself.
    let mut summary = Vec::new();
    read_at(file, summary_start, footer_at - summary_start + FOOTER_BYTES - 12, &mut summary)?;
    if summary_crc != 0 && summary_crc != crc32fast::hash(&summary) {
        return Ok(None);
    }
    summary.truncate((footer_at - summary_start) as usize);
    Ok(Some(summary))
}
