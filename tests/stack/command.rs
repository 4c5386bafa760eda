//! The `cncbf` command run to its end in a private domain, and its output.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use node_runtime::Domain;
use serde_json::Value;

/// The command in `domain`, working in `folder`, its output kept.
pub(crate) fn cncbf(domain: &Domain, folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cncbf"));
    command
        .current_dir(folder)
        .env(Domain::VARIABLE, domain.prefix())
        .env("RUST_LOG", "warn")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// An empty scratch folder of one test.
pub(crate) fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).expect("a scratch folder that may be removed");
    }
    std::fs::create_dir_all(&folder).expect("a writable scratch folder");
    folder
}

/// What a command said and how it ended.
#[derive(Debug)]
pub(crate) struct Said {
    /// Exit code.
    pub(crate) code: i32,
    /// Standard output.
    pub(crate) out: String,
    /// Standard error.
    pub(crate) err: String,
}

impl Said {
    /// Runs `command` with `arguments` to its end. Whatever it was given, it may neither panic nor die of a signal.
    pub(crate) fn by(mut command: Command, arguments: &[&dyn AsRef<OsStr>]) -> Self {
        Self::of(command.args(arguments).output().expect("the command starts"))
    }

    /// The same of a command that has ended.
    pub(crate) fn of(output: Output) -> Self {
        let said = Self {
            code: output.status.code().unwrap_or_else(|| panic!("died of a signal: {output:?}")),
            out: String::from_utf8(output.stdout).expect("standard output is text"),
            err: String::from_utf8(output.stderr).expect("standard error is text"),
        };
        assert!(!said.err.contains("panicked"), "{}", said.err);
        said
    }

    /// Standard output as JSON.
    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|error| panic!("no JSON ({error}): {self:?}"))
    }
}

/// The part of `value` that a JSON pointer names; it must be there.
pub(crate) fn at<'a>(value: &'a Value, pointer: &str) -> &'a Value {
    value.pointer(pointer).unwrap_or_else(|| panic!("{pointer} is not in {value}"))
}

/// The count that a JSON pointer names.
pub(crate) fn count(value: &Value, pointer: &str) -> u64 {
    at(value, pointer).as_u64().unwrap_or_else(|| panic!("{pointer} is no count in {value}"))
}
