//! Starts, watches, restarts and stops the processes of one stack.
//!
//! A child that ends with an error is started again, after a pause that grows while it keeps failing, until it has failed
//! too often; [`Supervisor`] decides that without a clock or a process. The launcher decides nothing about the robot: a
//! command sink brakes by itself when the filter falls silent.
//!
//! ```no_run
//! use std::time::Duration;
//!
//! use launcher::{Child, Launcher, Plan, RestartPolicy};
//! use messages::ProcessId;
//! use node_runtime::{Domain, Shutdown};
//!
//! fn main() -> Result<(), Box<dyn std::error::Error>> {
//!     let shutdown = Shutdown::install()?;
//!     let filter = Child {
//!         id: ProcessId::Filter,
//!         program: std::env::current_exe()?,
//!         args: vec!["filter".into()],
//!         env: vec![],
//!         restart: RestartPolicy::default(),
//!     };
//!     let mut launcher = Launcher::start(Plan {
//!         domain: Domain::from_env()?,
//!         children: vec![filter],
//!         log_dir: None,
//!     })?;
//!     while !shutdown.requested() && launcher.any_running() {
//!         for event in launcher.poll() {
//!             eprintln!("{event}");
//!         }
//!         std::thread::sleep(Duration::from_millis(20));
//!     }
//!     launcher.stop(Duration::from_secs(2));
//!     Ok(())
//! }
//! ```
//!
//! # When the launcher itself dies
//! Children find its process id in [`node_runtime::PARENT_PID_VARIABLE`]; those that call
//! [`node_runtime::Shutdown::install`] then receive SIGTERM when it dies, however that happens. The kernel ties that
//! signal to the *thread* that started the child, therefore a [`Launcher`] cannot be moved to another thread.

mod event;
mod launcher;
mod plan;
mod supervisor;

pub use event::Event;
pub use launcher::{Launcher, StopReport};
pub use plan::{Child, LaunchError, Plan, RestartPolicy};
pub use supervisor::{Supervisor, Verdict};
