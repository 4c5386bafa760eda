//! What the launcher saw and did.

use std::{fmt, os::unix::process::ExitStatusExt, process::ExitStatus, time::Duration};

use messages::ProcessId;

/// One change of one child, in the order in which they happened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Event {
    /// A child ended with exit code 0 and stays down.
    Finished {
        /// Which.
        id: ProcessId,
    },
    /// A child ended otherwise and will be started again.
    Failed {
        /// Which.
        id: ProcessId,
        /// How it ended.
        status: ExitStatus,
        /// Pause before its restart.
        restart_in: Duration,
    },
    /// A child was started again.
    Restarted {
        /// Which.
        id: ProcessId,
        /// Its new process id.
        pid: u32,
    },
    /// A child failed and stays down.
    GaveUp {
        /// Which.
        id: ProcessId,
        /// How it ended last.
        status: ExitStatus,
    },
    /// A child could not be started again and stays down.
    RestartFailed {
        /// Which.
        id: ProcessId,
        /// Why.
        error: String,
    },
}

impl Event {
    /// The child it is about.
    pub const fn id(&self) -> ProcessId {
        match self {
            Self::Finished { id }
            | Self::Failed { id, .. }
            | Self::Restarted { id, .. }
            | Self::GaveUp { id, .. }
            | Self::RestartFailed { id, .. } => *id,
        }
    }
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Finished { id } => write!(f, "{id} has finished"),
            Self::Failed { id, status, restart_in } if restart_in.is_zero() => {
                write!(f, "{id} {}; starting it again", ending(*status))
            }
            Self::Failed { id, status, restart_in } => {
                write!(f, "{id} {}; starting it again in {restart_in:?}", ending(*status))
            }
            Self::Restarted { id, pid } => write!(f, "{id} runs again (pid {pid})"),
            Self::GaveUp { id, status } => {
                write!(f, "{id} {} and stays down; its log tells why", ending(*status))
            }
            Self::RestartFailed { id, error } => write!(f, "{id} could not be started again: {error}"),
        }
    }
}

fn ending(status: ExitStatus) -> String {
    match (status.code(), status.signal()) {
        (Some(code), _) => format!("ended with exit code {code}"),
        (None, Some(signal)) => format!("was killed by signal {signal}"),
        (None, None) => "ended".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_names_process_and_cause() {
        let killed = Event::Failed {
            id: ProcessId::Filter,
            status: ExitStatus::from_raw(9),
            restart_in: Duration::from_millis(200),
        };
        assert_eq!(killed.to_string(), "filter was killed by signal 9; starting it again in 200ms");
        let gave_up = Event::GaveUp { id: ProcessId::Bridge, status: ExitStatus::from_raw(2 << 8) };
        assert_eq!(gave_up.to_string(), "bridge ended with exit code 2 and stays down; its log tells why");
    }
}
