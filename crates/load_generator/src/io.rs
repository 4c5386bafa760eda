//! The disk kept busy: blocks forced out one by one, the file removed when it is full.

use std::fs::File;
use std::io::Write;
use std::path::Path;

use crate::{Done, LoadError};

/// The temporary file is never longer, bytes.
pub const FILE_BYTES: u64 = 32 << 20;

/// One block, bytes.
const BLOCK_BYTES: usize = 1 << 20;

pub(crate) fn run(folder: &Path, stop: &impl Fn() -> bool) -> Result<Done, LoadError> {
    let failed = |source| LoadError::Disk { folder: folder.to_owned(), source };
    // Not zeros: some file systems do not store those.
    let block: Vec<u8> = (0..BLOCK_BYTES).map(|index| ((index * 31) >> 3) as u8).collect();
    let mut done = Done { threads: 1, iterations: 0, bytes: 0, footprint_bytes: FILE_BYTES };
    loop {
        // Without a name in the folder, so that nothing stays behind however this process ends.
        let mut file = tempfile::tempfile_in(folder).map_err(failed)?;
        for _ in 0..FILE_BYTES / BLOCK_BYTES as u64 {
            force_out(&mut file, &block).map_err(failed)?;
            done.iterations += 1;
            done.bytes += block.len() as u64;
            if stop() {
                return Ok(done);
            }
        }
    }
}

fn force_out(file: &mut File, block: &[u8]) -> std::io::Result<()> {
    file.write_all(block)?;
    file.sync_data()
}
