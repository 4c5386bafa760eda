//! A program under test: started with its output kept, asked to end, and never left behind.

use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;

use node_runtime::{Clock, RealClock};
use rustix::process::{Pid, Signal, kill_process, kill_process_group};

/// Between two looks at a process that is to end.
const LOOK: Duration = Duration::from_millis(5);

/// Why a program could not be started.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// Nothing to start.
    #[error("no command was given; put it after `--`, such as `-- python3 my_controller.py`")]
    NoCommand,
    /// The system refused.
    #[error("cannot start `{program}`: {source}; is it installed, and is its path right?")]
    Spawn {
        /// The program.
        program: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// There is no room for its output.
    #[error("cannot keep the program's output: {0}; is the folder for temporary files writable?")]
    Output(#[source] std::io::Error),
}

/// A running program. Dropped, it and its children are killed.
#[derive(Debug)]
pub struct Candidate {
    child: Child,
    output: File,
    status: Option<ExitStatus>,
}

/// How a program ended that was asked to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ending {
    /// Time from the request to its end, ns; to the kill if it did not end by itself.
    pub after_ns: u64,
    /// Its exit status; `None` if it had to be killed.
    pub status: Option<ExitStatus>,
}

impl Candidate {
    /// Starts `command`, the program and its arguments, with more variables in its environment.
    ///
    /// # Errors
    /// [`StartError`].
    pub fn start(command: &[OsString], environment: &[(&str, &OsStr)]) -> Result<Self, StartError> {
        let [program, arguments @ ..] = command else { return Err(StartError::NoCommand) };
        let output = tempfile::tempfile().map_err(StartError::Output)?;
        let [out, err] = [output.try_clone(), output.try_clone()].map(|end| end.map_err(StartError::Output));
        let child = Command::new(program)
            .args(arguments)
            .envs(environment.iter().copied())
            .stdin(Stdio::null())
            .stdout(out?)
            .stderr(err?)
            .process_group(0)
            .spawn()
            .map_err(|source| StartError::Spawn {
                program: program.to_string_lossy().into_owned(),
                source,
            })?;
        Ok(Self { child, output, status: None })
    }

    /// Its exit status once it has ended.
    pub fn ended(&mut self) -> Option<ExitStatus> {
        if self.status.is_none() {
            self.status = self.child.try_wait().ok().flatten();
        }
        self.status
    }

    /// Asks it to end with SIGTERM, and kills it after `patience`.
    pub fn end(&mut self, patience: Duration) -> Ending {
        let asked_ns = RealClock.now_ns();
        if self.ended().is_none() {
            // It may end in this very moment; then there is nobody to ask.
            let _ = kill_process(Pid::from_child(&self.child), Signal::TERM);
        }
        loop {
            let after_ns = RealClock.now_ns() - asked_ns;
            if let Some(status) = self.ended() {
                return Ending { after_ns, status: Some(status) };
            }
            if after_ns > patience.as_nanos() as u64 {
                self.kill();
                return Ending { after_ns, status: None };
            }
            std::thread::sleep(LOOK);
        }
    }

    /// What it said so far on both channels, as text.
    pub fn output(&mut self) -> String {
        let mut bytes = Vec::new();
        let read = self.output.seek(SeekFrom::Start(0)).and_then(|_| self.output.read_to_end(&mut bytes));
        match read {
            Ok(_) => String::from_utf8_lossy(&bytes).into_owned(),
            Err(error) => format!("(its output cannot be read: {error})"),
        }
    }

    /// Ends it and whatever it has started.
    fn kill(&mut self) {
        let _ = kill_process_group(Pid::from_child(&self.child), Signal::KILL);
        self.status = self.child.wait().ok();
    }
}

impl Drop for Candidate {
    fn drop(&mut self) {
        if self.ended().is_none() {
            self.kill();
        }
    }
}
