//! What every subcommand needs: settings, logging, a look at the clock for progress.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use anyhow::Context;
use settings::Settings;

use crate::cli::ProcessArgs;

/// The settings used where none are named.
pub(crate) const DEFAULT_SETTINGS: &str = include_str!("../config/ground_robot.toml");

/// Settings named on the command line, or the built-in ones.
pub(crate) fn settings(args: &ProcessArgs) -> anyhow::Result<Settings> {
    settings_from(args.config.as_deref())
}

/// Settings from a file, or the built-in ones.
pub(crate) fn settings_from(file: Option<&Path>) -> anyhow::Result<Settings> {
    match file {
        Some(file) => Ok(Settings::load(file)?),
        None => Settings::parse(DEFAULT_SETTINGS, Path::new("built-in settings"), Path::new("."))
            .context("the built-in settings are invalid; this is a defect of the build"),
    }
}

/// Whether a person watches standard error.
pub(crate) fn someone_watches() -> bool {
    std::io::stderr().is_terminal()
}

/// Refuses an output file that cannot be written, before hours of work go into what it should hold.
/// `option` is the one that names it.
pub(crate) fn refuse_unwritable(file: &Path, option: &str) -> anyhow::Result<()> {
    let existed = file.exists();
    std::fs::OpenOptions::new()
        .append(true)
        .create(true)
        .open(file)
        .with_context(|| format!("cannot write {}; name another file with {option}", file.display()))?;
    if !existed {
        std::fs::remove_file(file).with_context(|| format!("cannot remove {}", file.display()))?;
    }
    Ok(())
}

/// `file` with `word` before its ending: `a.value.safetensors` and `true` give `a.value.true.safetensors`.
pub(crate) fn beside(file: &Path, word: &str) -> PathBuf {
    let ending = file.extension().map_or_else(String::new, |ending| format!(".{}", ending.to_string_lossy()));
    file.with_extension(format!("{word}{ending}"))
}

/// Removes a file that may not be there.
pub(crate) fn remove_if_there(file: &Path) -> anyhow::Result<()> {
    match std::fs::remove_file(file) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(error).with_context(|| format!("cannot remove {}", file.display()))
        }
        _ => Ok(()),
    }
}
