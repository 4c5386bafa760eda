//! What shall run, and how eagerly it is started again.

use std::{ffi::OsString, path::PathBuf, time::Duration};

use messages::ProcessId;
use node_runtime::Domain;

/// Everything that one stack consists of.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Where the children meet; handed to them in their environment, and cleared when the stack has stopped.
    pub domain: Domain,
    /// The processes, in the order of their start. Each [`ProcessId`] at most once.
    pub children: Vec<Child>,
    /// Folder for one log file per process, created if absent; without it children write to the launcher's own output.
    pub log_dir: Option<PathBuf>,
}

/// One process of the plan.
#[derive(Debug, Clone)]
pub struct Child {
    /// Which process it is.
    pub id: ProcessId,
    /// The program.
    pub program: PathBuf,
    /// Its arguments, without the program's name.
    pub args: Vec<OsString>,
    /// Variables added to the launcher's environment.
    pub env: Vec<(OsString, OsString)>,
    /// What to do when it ends unasked.
    pub restart: RestartPolicy,
}

/// What to do when a child ends unasked. A child that ends with exit code 0 has finished and is never started again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RestartPolicy {
    /// Report its end, nothing else.
    Never,
    /// Start it again.
    OnFailure {
        /// Restarts within `window` after which the launcher gives up.
        limit: u32,
        /// Time that a failure counts for.
        window: Duration,
        /// Pause before the second restart in a window; the first one is immediate. Doubles with each further one.
        first_pause: Duration,
        /// Longest pause.
        longest_pause: Duration,
    },
}

impl Default for RestartPolicy {
    /// At once, then after 0.1 s, 0.2 s, … up to 2 s; at most ten times in a minute.
    fn default() -> Self {
        Self::OnFailure {
            limit: 10,
            window: Duration::from_secs(60),
            first_pause: Duration::from_millis(100),
            longest_pause: Duration::from_secs(2),
        }
    }
}

/// Why a plan could not be started. Nothing of it runs then.
#[derive(Debug, thiserror::Error)]
pub enum LaunchError {
    /// The plan names a process twice.
    #[error("the plan holds {id} twice; a stack has one of each")]
    Twice {
        /// The process.
        id: ProcessId,
    },
    /// A program could not be started.
    #[error("cannot start {id} (`{program}`): {source}; is it built, and may this user run it?")]
    Spawn {
        /// The process.
        id: ProcessId,
        /// Its program.
        program: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A log file could not be opened.
    #[error("cannot write the log `{path}`: {source}; choose another folder")]
    Log {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
}
