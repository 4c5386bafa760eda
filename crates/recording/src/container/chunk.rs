//! One chunk: where it lies, and its records checked and decompressed.

use std::io::Read;

use super::fields::Fields;

/// Largest chunk that is opened, compressed or not, bytes. Writers aim at 1 MiB; one camera image or point cloud may
/// exceed that, a damaged or hostile length must not fill the memory.
pub(crate) const MAX_CHUNK_BYTES: u64 = 256 << 20;

/// Why a chunk is unreadable.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(crate) enum ChunkError {
    #[error("its header is incomplete")]
    Header,
    #[error("its {bytes} bytes exceed the limit of {MAX_CHUNK_BYTES}")]
    TooLarge { bytes: u64 },
    #[error("its compression `{name}` is not supported (none, lz4 and zstd are)")]
    Compression { name: String },
    #[error("it does not decompress: {reason}")]
    Decompress { reason: String },
    #[error("it holds {found} bytes instead of {expected}")]
    Size { expected: u64, found: u64 },
    #[error("its checksum is {found:08x} instead of {expected:08x}")]
    Checksum { expected: u32, found: u32 },
}

/// The uncompressed records of a chunk.
#[derive(Debug)]
pub(crate) struct OpenChunk {
    /// The records, one behind the other.
    pub(crate) records: Vec<u8>,
    /// Whether a checksum vouches for them; writers may leave it out.
    pub(crate) is_checked: bool,
}

/// Opens the content of a chunk record.
pub(crate) fn open(body: &[u8]) -> Result<OpenChunk, ChunkError> {
    let mut fields = Fields::new(body);
    let header = (|| {
        let (_start_ns, _end_ns) = (fields.u64()?, fields.u64()?);
        let (size, checksum) = (fields.u64()?, fields.u32()?);
        let compression = fields.string()?;
        let compressed_size = fields.u64()?;
        Some((size, checksum, compression, fields.bytes(compressed_size)?))
    })();
    let (size, checksum, compression, data) = header.ok_or(ChunkError::Header)?;
    if size > MAX_CHUNK_BYTES {
        return Err(ChunkError::TooLarge { bytes: size });
    }
    let records = match compression.as_str() {
        "" => data.to_vec(),
        "zstd" => {
            let decoder = zstd::stream::read::Decoder::with_buffer(data);
            read_at_most(decoder, size)?
        }
        "lz4" => read_at_most(lz4::Decoder::new(data), size)?,
        _ => return Err(ChunkError::Compression { name: compression }),
    };
    if records.len() as u64 != size {
        return Err(ChunkError::Size { expected: size, found: records.len() as u64 });
    }
    let found = crc32fast::hash(&records);
    if checksum != 0 && checksum != found {
        return Err(ChunkError::Checksum { expected: checksum, found });
    }
    Ok(OpenChunk { records, is_checked: checksum != 0 })
}

/// Reads a decoder to its end, but never more than one byte beyond what was announced.
fn read_at_most<R: Read>(decoder: std::io::Result<R>, size: u64) -> Result<Vec<u8>, ChunkError> {
    let mut records = Vec::new();
    decoder
        .and_then(|decoder| decoder.take(size + 1).read_to_end(&mut records))
        .map_err(|error| ChunkError::Decompress { reason: error.to_string() })?;
    Ok(records)
}
