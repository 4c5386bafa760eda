//! A Python with CycloneDDS for peers that share no line with the stack, and a ROS domain for a test alone.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

/// What pip is asked for.
const PACKAGE: &str = "cyclonedds==11.0.1";

/// A Python that has CycloneDDS; `None` where it cannot be had. It lies in a virtual environment of the tests.
fn python() -> Option<&'static Path> {
    static PYTHON: OnceLock<Option<PathBuf>> = OnceLock::new();
    PYTHON
        .get_or_init(|| {
            let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("venv_cyclonedds");
            let python = folder.join("bin/python");
            let succeeds = |command: &mut Command| {
                command
                    .stdout(Stdio::null())
                    .stderr(Stdio::null())
                    .status()
                    .is_ok_and(|status| status.success())
            };
            let is_there = succeeds(Command::new(&python).args(["-c", "import cyclonedds"]))
                || (succeeds(Command::new("python3").args(["-m", "venv"]).arg(&folder))
                    && succeeds(Command::new(&python).args(["-m", "pip", "install", "--quiet", PACKAGE])));
            is_there.then_some(python)
        })
        .as_deref()
}

/// [`python`], or a line that says what is skipped.
pub(crate) fn python_or_say() -> Option<&'static Path> {
    let python = python();
    if python.is_none() {
        println!("skipped: no Python with {PACKAGE} (python3 -m venv, pip install)");
    }
    python
}

/// A ROS domain that parallel tests do not share; `offset`, below 8, tells those of one process apart.
pub(crate) fn domain_id(offset: u32) -> u32 {
    10 + std::process::id() % 11 * 8 + offset
}
