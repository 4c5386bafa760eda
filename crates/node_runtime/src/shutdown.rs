//! The wish to stop: SIGINT, SIGTERM, or the death of the launcher.

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

use rustix::process::{Pid, Signal, getppid, set_parent_process_death_signal};
use signal_hook::consts::{SIGINT, SIGTERM};

/// Environment variable with the process id of the launcher, set for its children.
pub const PARENT_PID_VARIABLE: &str = "CNCBF_PARENT_PID";

/// Why the handlers could not be installed.
#[derive(Debug, thiserror::Error)]
pub enum ShutdownError {
    /// The kernel refused a signal handler.
    #[error("cannot handle SIGINT and SIGTERM: {0}; is a sandbox forbidding sigaction?")]
    Signal(#[source] std::io::Error),
    /// The kernel refused to tell us when the launcher dies.
    #[error("cannot ask the kernel for a signal when the launcher dies: {0}; is a sandbox forbidding prctl?")]
    ParentDeath(#[source] std::io::Error),
}

/// A flag that SIGINT and SIGTERM raise. Clones share it.
#[derive(Debug, Clone)]
pub struct Shutdown {
    requested: Arc<AtomicBool>,
}

impl Shutdown {
    /// Installs the handlers. Call it first thing in `main`.
    ///
    /// A process started by the launcher (it finds [`PARENT_PID_VARIABLE`]) also receives SIGTERM when the launcher dies,
    /// however that happens. A second SIGINT ends the process at once.
    ///
    /// # Errors
    /// [`ShutdownError`] if the kernel refuses.
    pub fn install() -> Result<Self, ShutdownError> {
        let requested = Arc::new(AtomicBool::new(false));
        // 128 + SIGINT is what a shell reports for a process that died of it.
        signal_hook::flag::register_conditional_shutdown(SIGINT, 128 + SIGINT, Arc::clone(&requested))
            .map_err(ShutdownError::Signal)?;
        for signal in [SIGINT, SIGTERM] {
            signal_hook::flag::register(signal, Arc::clone(&requested)).map_err(ShutdownError::Signal)?;
        }
        let shutdown = Self { requested };
        if let Some(launcher) = launcher_pid() {
            set_parent_process_death_signal(Some(Signal::TERM))
                .map_err(|errno| ShutdownError::ParentDeath(errno.into()))?;
            // The launcher may have died before the kernel was asked.
            if getppid() != Some(launcher) {
                shutdown.request();
            }
        }
        Ok(shutdown)
    }

    /// Whether the process shall stop.
    pub fn requested(&self) -> bool {
        self.requested.load(Ordering::Relaxed)
    }

    /// Raises the flag from inside, for example when a source has ended.
    pub fn request(&self) {
        self.requested.store(true, Ordering::Relaxed);
    }
}

/// The launcher that started this process, if one did.
fn launcher_pid() -> Option<Pid> {
    let value = std::env::var(PARENT_PID_VARIABLE).ok()?;
    Pid::from_raw(value.parse().ok()?)
}
