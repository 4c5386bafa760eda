//! A recording, opened: its summary, and its good messages in log-time order.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::container::{OrderedMessages, RawMessage, ScanError, Survey, scan};
use crate::message::RecordedMessage;
use crate::refusal::{RefusalCounts, RefusalReason};
use crate::summary::{ChannelSummary, RecordingSummary};

/// Why a recording could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The operating system refuses.
    #[error("cannot read the recording {}: {source}; check the path", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// There is nothing in it.
    #[error("the recording {} is empty (0 bytes); was the recorder stopped before it wrote anything?", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// It does not begin as an MCAP file does.
    #[error("{} is no MCAP file; convert other bags first, for example with `rosbags-convert`", path.display())]
    NotMcap {
        /// The file.
        path: PathBuf,
    },
    /// It begins well, but not one message in it can be read.
    #[error("no message of the recording {} is readable ({found}); see `cncbf inspect`", path.display())]
    NothingReadable {
        /// The file.
        path: PathBuf,
        /// What was found instead.
        found: String,
    },
}

/// A recording that hands out its messages in log-time order.
///
/// Opening reads the whole file once: every chunk is decompressed and checked, so that damage is known before the first
/// message is used. Memory holds the largest chunk, not the file.
pub struct McapReader {
    path: PathBuf,
    summary: RecordingSummary,
    survey: Survey,
    messages: OrderedMessages,
    refusals: RefusalCounts,
}

impl McapReader {
    /// Opens and checks a recording.
    ///
    /// # Errors
    /// [`OpenError`] if the file is missing, empty, no MCAP file, or without a single readable message.
    pub fn open(path: &Path) -> Result<Self, OpenError> {
        let read_error = |source| OpenError::Read { path: path.to_owned(), source };
        let file = File::open(path).map_err(read_error)?;

        let mut survey = scan(&file).map_err(|error| match error {
            ScanError::Io(source) => read_error(source),
            ScanError::Empty => OpenError::Empty { path: path.to_owned() },
            ScanError::NotMcap => OpenError::NotMcap { path: path.to_owned() },
        })?;
        let summary = summarise(&survey);
        if summary.messages == summary.refusals.total() {
            return Err(OpenError::NothingReadable {
                path: path.to_owned(),
                found: what_was_found(&summary),
            });
        }
        for damage in &summary.damage {
            tracing::warn!(recording = %path.display(), "{damage}");
        }
        let loose = std::mem::take(&mut survey.loose);
        let messages = OrderedMessages::new(file, &survey.chunks, loose);
        let refusals = summary.refusals;
        Ok(Self { path: path.to_owned(), summary, survey, messages, refusals })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What the recording holds.
    pub fn summary(&self) -> &RecordingSummary {
        &self.summary
    }

    /// Messages refused so far. Once the end is reached, these and the messages handed out add up to all messages found.
    pub fn refusals(&self) -> &RefusalCounts {
        &self.refusals
    }

    /// The next good message; `None` at the end.
    pub fn next_message(&mut self) -> Option<RecordedMessage> {
        while let Some(raw) = self.advance() {
            // Only messages of declared channels are handed out.
            let channel = self.survey.channels.get(&raw.channel_id)?;
            let decoded = match &channel.codec {
                Ok(codec) => codec.decode(&raw.data),
                Err(reason) => Err(*reason),
            };
            match decoded {
                Ok(kind) => {
                    let (topic, sequence) = (Arc::clone(&channel.topic), raw.sequence);
                    return Some(RecordedMessage { topic, log_time_ns: raw.log_time_ns, sequence, kind });
                }
                Err(reason) => self.refusals.add(reason, 1),
            }
        }
        None
    }

    /// The next message undecoded, with its topic.
    pub(crate) fn next_raw(&mut self) -> Option<(Arc<str>, RawMessage)> {
        let raw = self.advance()?;
        let channel = self.survey.channels.get(&raw.channel_id)?;
        Some((Arc::clone(&channel.topic), raw))
    }

    fn advance(&mut self) -> Option<RawMessage> {
        loop {
            match self.messages.next(&self.survey) {
                Ok(next) => return next,
                Err(error) => {
                    tracing::warn!(recording = %self.path.display(), "a chunk became unreadable: {error}");
                    self.refusals.add(RefusalReason::DamagedChunk, 1);
                }
            }
        }
    }
}

impl Iterator for McapReader {
    type Item = RecordedMessage;

    fn next(&mut self) -> Option<RecordedMessage> {
        self.next_message()
    }
}

fn summarise(survey: &Survey) -> RecordingSummary {
    let channels = survey.channels.values().map(|channel| ChannelSummary {
        topic: channel.topic.to_string(),
        type_name: channel.type_name.clone(),
        encoding: channel.encoding.clone(),
        messages: channel.messages,
        is_readable: channel.codec.is_ok(),
    });
    RecordingSummary {
        profile: survey.profile.clone(),
        library: survey.library.clone(),
        channels: channels.collect(),
        metadata: survey.metadata.clone(),
        messages: survey.messages,
        log_span_ns: survey.log_span_ns,
        chunks: survey.chunks.len() as u64,
        unchecked_chunks: survey.unchecked_chunks,
        damage: survey.damage.clone(),
        refusals: survey.refusals,
    }
}

fn what_was_found(summary: &RecordingSummary) -> String {
    let refused = summary.refusals.iter().map(|(reason, count)| format!("{count} {}", reason.label()));
    let damage = summary.damage.iter().map(ToString::to_string);
    let found: Vec<_> = refused.chain(damage).collect();
    if found.is_empty() { "it holds none".to_owned() } else { found.join(", ") }
}
