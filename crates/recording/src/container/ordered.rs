//! The readable messages of a file in log-time order, one chunk in memory at a time where chunks do not overlap.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

use super::chunk::open;
use super::records::{Record, Records};
use super::survey::{ChunkPlace, LooseMessage, Survey};

/// A message as it lies in the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct RawMessage {
    pub(crate) channel_id: u16,
    pub(crate) sequence: u32,
    pub(crate) log_time_ns: u64,
    pub(crate) data: Vec<u8>,
}

/// Orders by log time, then by place in the file.
#[derive(Debug, PartialEq, Eq)]
struct Waiting {
    place: (u64, u64),
    message: RawMessage,
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.place.cmp(&other.place)
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// Hands out the readable messages one by one.
pub(crate) struct OrderedMessages {
    file: File,
    /// Not yet opened, the next one last.
    chunks: Vec<ChunkPlace>,
    waiting: BinaryHeap<Reverse<Waiting>>,
    taken_in: u64,
}

impl OrderedMessages {
    pub(crate) fn new(file: File, chunks: &[ChunkPlace], loose: Vec<LooseMessage>) -> Self {
        let mut chunks = chunks.to_vec();
        chunks.sort_by_key(|chunk| Reverse((chunk.start_ns, chunk.content_at)));
        let mut messages = Self { file, chunks, waiting: BinaryHeap::new(), taken_in: 0 };
        for LooseMessage { channel_id, sequence, log_time_ns, data } in loose {
            messages.take_in(RawMessage { channel_id, sequence, log_time_ns, data });
        }
        messages
    }

    fn take_in(&mut self, message: RawMessage) {
        self.taken_in += 1;
        self.waiting.push(Reverse(Waiting { place: (message.log_time_ns, self.taken_in), message }));
    }

    /// The next message; `None` at the end.
    ///
    /// # Errors
    /// If a chunk that was readable in the survey is not any more: the file changed meanwhile. The chunk is passed over.
    pub(crate) fn next(&mut self, survey: &Survey) -> io::Result<Option<RawMessage>> {
        while let Some(chunk) = self.chunks.last().copied() {
            let is_needed = match self.waiting.peek() {
                Some(Reverse(first)) => chunk.start_ns <= first.place.0,
                None => true,
            };
            if !is_needed {
                break;
            }
            self.chunks.pop();
            self.take_in_chunk(chunk, survey)?;
        }
        Ok(self.waiting.pop().map(|Reverse(first)| first.message))
    }

    fn take_in_chunk(&mut self, chunk: ChunkPlace, survey: &Survey) -> io::Result<()> {
        let mut body = Vec::new();
        self.file.seek(SeekFrom::Start(chunk.content_at))?;
        (&mut self.file).take(chunk.length).read_to_end(&mut body)?;
        let chunk = open(&body).map_err(|error| io::Error::other(error.to_string()))?;
        for record in Records::new(&chunk.records) {
            if let Ok(Record::Message { channel_id, sequence, log_time_ns, data }) = record
                && survey.channels.get(&channel_id).is_some_and(|channel| channel.codec.is_ok())
            {
                self.take_in(RawMessage { channel_id, sequence, log_time_ns, data: data.to_vec() });
            }
        }
        Ok(())
    }
}
