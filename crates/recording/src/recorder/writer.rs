//! The thread that writes: channels, chunks, a flush each second.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, McapResult, WriteOptions};

use super::convert::{Converter, Sink};
use super::{RecordError, RecordingInfo};
use crate::cdr;
use crate::ros2::Ros2Message;
use crate::wire::{WIRE_ENCODING, WIRE_TYPE_NOTE, WireMessage, wire_topic};

/// A crash loses at most this much recorded time, ns.
const FLUSH_INTERVAL_NS: u64 = 1_000_000_000;
/// Without messages for this long, what was written is flushed.
const IDLE_FLUSH: Duration = Duration::from_secs(1);

type McapWriter = mcap::Writer<BufWriter<File>>;

/// The schema id that says a channel has none.
const NO_SCHEMA: u16 = 0;

/// A channel of the file being written.
struct Channel {
    id: u16,
    sequence: u32,
}

/// The file being written.
pub(super) struct Writer {
    path: PathBuf,
    file: FileWriter,
    converter: Converter,
    flushed_at_ns: Option<u64>,
    is_dirty: bool,
    written: u64,
}

/// The MCAP side: which channels exist, and the buffer messages are encoded in.
struct FileWriter {
    mcap: McapWriter,
    channels: HashMap<String, Channel>,
    buffer: Vec<u8>,
}

impl Writer {
    pub(super) fn create(path: &Path, info: RecordingInfo) -> Result<Self, RecordError> {
        let file =
            File::create(path).map_err(|source| RecordError::Create { path: path.to_owned(), source })?;
        let failed =
            |error: mcap::McapError| RecordError::Write { path: path.to_owned(), reason: reason(&error) };
        // One writer thread is all this costs: the compressor's own threads would sit on the control cores.
        let mut mcap = WriteOptions::new()
            .profile("ros2")
            .library(format!("cncbf {}", info.version))
            .compression(Some(Compression::Zstd))
            .compression_threads(0)
            .create(BufWriter::new(file))
            .map_err(failed)?;
        mcap.write_metadata(&Metadata { name: "cncbf".to_owned(), metadata: info.entries() })
            .map_err(failed)?;
        Ok(Self {
            path: path.to_owned(),
            file: FileWriter { mcap, channels: HashMap::new(), buffer: Vec::new() },
            converter: Converter::new(info.odom_frame, info.base_frame),
            flushed_at_ns: None,
            is_dirty: false,
            written: 0,
        })
    }

    /// Writes until the queue is closed, then completes the file. The number of wire messages written.
    pub(super) fn run(&mut self, queue: &Receiver<(u64, WireMessage)>) -> Result<u64, RecordError> {
        loop {
            let result = match queue.recv_timeout(IDLE_FLUSH) {
                Ok((log_time_ns, message)) => self.write(log_time_ns, &message),
                Err(RecvTimeoutError::Timeout) => self.flush(),
                Err(RecvTimeoutError::Disconnected) => {
                    return match self.file.mcap.finish() {
                        Ok(_) => Ok(self.written),
                        Err(error) => Err(self.failed(&error)),
                    };
                }
            };
            result.map_err(|error| self.failed(&error))?;
        }
    }

    fn failed(&self, error: &mcap::McapError) -> RecordError {
        RecordError::Write { path: self.path.clone(), reason: reason(error) }
    }

    fn write(&mut self, log_time_ns: u64, message: &WireMessage) -> McapResult<()> {
        let flushed_at_ns = *self.flushed_at_ns.get_or_insert(log_time_ns);
        // By recorded time, so that equal runs give equal files; also if time ran backwards.
        if log_time_ns.abs_diff(flushed_at_ns) >= FLUSH_INTERVAL_NS {
            self.flushed_at_ns = Some(log_time_ns);
            self.flush()?;
        }
        self.file.write_wire(log_time_ns, message)?;
        self.converter.convert(message, &mut At { log_time_ns, file: &mut self.file })?;
        self.is_dirty = true;
        self.written += 1;
        Ok(())
    }

    fn flush(&mut self) -> McapResult<()> {
        if std::mem::take(&mut self.is_dirty) { self.file.mcap.flush() } else { Ok(()) }
    }
}

/// What went wrong; the operating system's words where it is to blame.
fn reason(error: &mcap::McapError) -> String {
    match error {
        mcap::McapError::Io(error) => error.to_string(),
        other => other.to_string(),
    }
}

/// The file, with the log time of the message at hand.
struct At<'a> {
    log_time_ns: u64,
    file: &'a mut FileWriter,
}

impl Sink for At<'_> {
    fn put<T: Ros2Message>(&mut self, topic: &str, message: &T) -> McapResult<()> {
        let mut buffer = std::mem::take(&mut self.file.buffer);
        let encoded = cdr::encode(message, &mut buffer);
        encoded.map_err(|error| std::io::Error::other(error.to_string()))?;
        self.file.write(topic, self.log_time_ns, &buffer, |mcap| {
            let schema = mcap.add_schema(&T::type_name(), "ros2msg", T::definition().as_bytes())?;
            mcap.add_channel(schema, topic, "cdr", &BTreeMap::new())
        })?;
        self.file.buffer = buffer;
        Ok(())
    }
}

impl FileWriter {
    fn write_wire(&mut self, log_time_ns: u64, message: &WireMessage) -> McapResult<()> {
        let topic = wire_topic(message.service());
        self.write(&topic, log_time_ns, message.bytes(), |mcap| {
            let notes = BTreeMap::from([(WIRE_TYPE_NOTE.to_owned(), message.type_name().to_owned())]);
            mcap.add_channel(NO_SCHEMA, &topic, WIRE_ENCODING, &notes)
        })
    }

    /// Writes a message, declaring its channel the first time.
    fn write(
        &mut self,
        topic: &str,
        log_time_ns: u64,
        data: &[u8],
        declare: impl FnOnce(&mut McapWriter) -> McapResult<u16>,
    ) -> McapResult<()> {
        if !self.channels.contains_key(topic) {
            let id = declare(&mut self.mcap)?;
            self.channels.insert(topic.to_owned(), Channel { id, sequence: 0 });
        }
        let Some(channel) = self.channels.get_mut(topic) else { return Ok(()) };
        channel.sequence = channel.sequence.wrapping_add(1);
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: channel.sequence,
            log_time: log_time_ns,
            publish_time: log_time_ns,
        };
        self.mcap.write_to_known_channel(&header, data)
    }
}
