//! The readable messages of a file in log-time order, one chunk in memory at a time where chunks do not overlap.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::fs::File;
use std::io;

use super::chunk::open;
use super::records::{Record, Records};
use super::source::read_at;
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
    /// Log time, ns; where its chunk lies in the file, 0 outside of chunks; how many came before it there.
    place: (u64, u64, usize),
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
}

impl OrderedMessages {
    pub(crate) fn new(file: File, chunks: &[ChunkPlace], loose: Vec<LooseMessage>) -> Self {
        let mut chunks = chunks.to_vec();
        chunks.sort_by_key(|chunk| Reverse((chunk.start_ns, chunk.content_at)));
        let mut messages = Self { file, chunks, waiting: BinaryHeap::new() };
        for (index, LooseMessage { channel_id, sequence, log_time_ns, data }) in loose.into_iter().enumerate()
        {
            messages.take_in((0, index), RawMessage { channel_id, sequence, log_time_ns, data });
        }
        messages
    }

    fn take_in(&mut self, (chunk, index): (u64, usize), message: RawMessage) {
        self.waiting.push(Reverse(Waiting { place: (message.log_time_ns, chunk, index), message }));
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

    fn take_in_chunk(&mut self, place: ChunkPlace, survey: &Survey) -> io::Result<()> {
        let mut body = Vec::new();
        read_at(&self.file, place.content_at, place.length, &mut body)?;
        let chunk = open(&body).map_err(|error| io::Error::other(error.to_string()))?;
        for (index, record) in Records::new(&chunk.records).enumerate() {
            if let Ok(Record::Message { channel_id, sequence, log_time_ns, data }) = record
                && survey.channels.get(&channel_id).is_some_and(|channel| channel.codec.is_ok())
            {
                let message = RawMessage { channel_id, sequence, log_time_ns, data: data.to_vec() };
                self.take_in((place.content_at, index), message);
            }
        }
        Ok(())
    }
}
