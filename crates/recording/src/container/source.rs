//! The file under the records: bounded reads, and a checksum over everything that passed.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::os::unix::fs::FileExt;

/// Reads a file from its beginning and keeps the checksum of what was read.
pub(crate) struct Source {
    file: BufReader<File>,
    length: u64,
    position: u64,
    hasher: crc32fast::Hasher,
}

impl Source {
    pub(crate) fn new(file: File) -> io::Result<Self> {
        let length = file.metadata()?.len();
        let file = BufReader::with_capacity(1 << 18, file);
        Ok(Self { file, length, position: 0, hasher: crc32fast::Hasher::new() })
    }

    pub(crate) fn length(&self) -> u64 {
        self.length
    }

    pub(crate) fn position(&self) -> u64 {
        self.position
    }

    pub(crate) fn remaining(&self) -> u64 {
        self.length.saturating_sub(self.position)
    }

    /// Checksum of all bytes so far.
    pub(crate) fn checksum(&self) -> u32 {
        self.hasher.clone().finalize()
    }

    /// Reads exactly `length` bytes into `buffer`; the caller has compared with [`Source::remaining`].
    pub(crate) fn read(&mut self, length: u64, buffer: &mut Vec<u8>) -> io::Result<()> {
        buffer.clear();
        let read = (&mut self.file).take(length).read_to_end(buffer)? as u64;
        self.hasher.update(buffer);
        self.position += read;
        if read == length { Ok(()) } else { Err(io::ErrorKind::UnexpectedEof.into()) }
    }

    /// Passes over `length` bytes.
    pub(crate) fn skip(&mut self, length: u64, scratch: &mut Vec<u8>) -> io::Result<()> {
        let mut left = length;
        while left > 0 {
            let step = left.min(1 << 18);
            self.read(step, scratch)?;
            left -= step;
        }
        Ok(())
    }
}

/// Reads exactly `length` bytes at a place into `buffer`. Leaves the file's cursor alone, which handles may share; the
/// caller has compared with the file's length.
pub(crate) fn read_at(file: &File, at_byte: u64, length: u64, buffer: &mut Vec<u8>) -> io::Result<()> {
    buffer.clear();
    buffer.resize(length as usize, 0);
    file.read_exact_at(buffer, at_byte)
}
