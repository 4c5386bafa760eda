//! Load beside the stack: a child process that ends with this one, and what it says it did.

use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use anyhow::Context;
use load_generator::{LoadKind, LoadReport, generate};
use node_runtime::{Clock, PARENT_PID_VARIABLE, RealClock, Shutdown};
use rustix::process::{Pid, Signal, kill_process};

use crate::cli::LoadArgs;

/// Longest wait for the load to end: one block may be on its way to a slow disk, ns.
const PATIENCE_NS: u64 = 30_000_000_000;
/// Between two looks.
const LOOK: Duration = Duration::from_millis(5);

/// `cncbf load-generator`: makes load until told to stop, then says what it did.
pub(crate) fn load_generator(args: &LoadArgs) -> anyhow::Result<bool> {
    let kind = args.load.kind().context("`none` makes no load; use cpu, memory or io")?;
    let shutdown = Shutdown::install()?;
    let report = generate(kind, &args.folder, &RealClock, &|| shutdown.requested())?;
    // Fails only where nobody listens any more: whoever asked for the load was killed.
    let _ = writeln!(std::io::stdout(), "{}", serde_json::to_string(&report)?);
    Ok(true)
}

/// A load generator that runs. Dropping it ends it.
pub(super) struct Load {
    kind: LoadKind,
    child: Child,
}

impl Load {
    /// Starts one that writes, if it writes, below `folder`.
    ///
    /// It begins before the stack and ends after it. Call it on the main thread: the kernel ties its life to the thread that
    /// started it.
    pub(super) fn start(kind: LoadKind, folder: &Path) -> anyhow::Result<Self> {
        let program = std::env::current_exe().context("cannot find this program's own file")?;
        let child = Command::new(program)
            .args(["load-generator", kind.label(), "--folder"])
            .arg(folder)
            .env(PARENT_PID_VARIABLE, std::process::id().to_string())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .context("cannot start the load generator")?;
        Ok(Self { kind, child })
    }

    /// # Errors
    /// If it has ended: what runs now runs without load.
    pub(super) fn ensure_it_runs(&mut self) -> anyhow::Result<()> {
        match self.child.try_wait()? {
            None => Ok(()),
            Some(status) => {
                anyhow::bail!("the load generator ({}) ended ({status}); it said why above", self.kind)
            }
        }
    }

    /// Ends it and returns what it did.
    ///
    /// # Errors
    /// If it had ended before, or cannot tell what it did.
    pub(super) fn stop(mut self) -> anyhow::Result<LoadReport> {
        let kind = self.kind;
        self.ensure_it_runs()?;
        kill_process(Pid::from_child(&self.child), Signal::TERM)?;
        let give_up_ns = RealClock.now_ns() + PATIENCE_NS;
        let status = loop {
            if let Some(status) = self.child.try_wait()? {
                break status;
            }
            anyhow::ensure!(
                RealClock.now_ns() < give_up_ns,
                "the load generator ({kind}) does not end; is the disk stuck?"
            );
            std::thread::sleep(LOOK);
        };
        anyhow::ensure!(status.success(), "the load generator ({kind}) failed ({status}); it said why above");
        let mut said = String::new();
        self.child.stdout.take().context("its output is a pipe")?.read_to_string(&mut said)?;
        serde_json::from_str(&said).with_context(|| format!("the load generator said {said:?}"))
    }
}

impl Drop for Load {
    fn drop(&mut self) {
        // Both fail only for a process that is gone.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
