//! Where a run leaves its recording, report and logs.

use std::path::{Path, PathBuf};

use anyhow::Context;

/// Folder that numbered runs go to, below the working directory.
const RUNS: &str = "runs";

/// Creates `chosen`, or the next free `runs/NNNN`.
pub(crate) fn create(chosen: Option<&Path>) -> anyhow::Result<PathBuf> {
    if let Some(folder) = chosen {
        std::fs::create_dir_all(folder).with_context(|| unwritable(folder))?;
        return Ok(folder.to_owned());
    }
    let runs = Path::new(RUNS);
    std::fs::create_dir_all(runs).with_context(|| unwritable(runs))?;
    for number in 1..10_000 {
        let folder = runs.join(format!("{number:04}"));
        match std::fs::create_dir(&folder) {
            Ok(()) => return Ok(folder),
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error).with_context(|| unwritable(&folder)),
        }
    }
    anyhow::bail!("{RUNS}/0001 to {RUNS}/9999 all exist; remove some or name a folder with --report")
}

fn unwritable(folder: &Path) -> String {
    format!("cannot create {}; name a writable folder with --report", folder.display())
}
