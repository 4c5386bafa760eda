//! What stands between a process' `step` function and the operating system: typed ports, clocks, the loop with its pacing and
//! its rights, health, orderly shutdown, and removal of what crashed processes leave behind.
//!
//! This is the only crate that knows iceoryx2. It holds no physics and no decision about the robot; a process decides with its
//! own `step(inputs, now)`, which knows neither a clock nor a port.
//!
//! # Delivery
//! Every service is *latest wins*: a full queue drops its oldest entry, a sender never waits, and whoever subscribes late
//! is handed the last sample at the next sending (or [`Publisher::serve_late_joiners`]). Publishers and subscribers may start in
//! any order. One process at a time may write a service (only [`messages::Health`] and [`messages::Cycle`] have many writers), so
//! that two filters can never drive one robot; the place of a writer that was killed is free again as soon as its successor opens
//! its [`Node`].
//!
//! The same ports run over ROS 2's DDS where the environment says so ([`Transport`]), to compare with.
//!
//! # The loop
//! Every process runs the same [`ProcessLoop`]: its [`Pacing`] says when a cycle begins (due times, inputs, or both), its
//! [`Work`] is done, and the cycle is counted in [`messages::Health`] and recorded as [`messages::Cycle`].
//!
//! # Allocation
//! After construction, sending, receiving, waking, waiting, the pacing and the clocks allocate nothing over iceoryx2. The
//! exception: the first call after a peer has come or gone sets up or takes down the connection. `tests/allocations.rs` counts.
//!
//! # A whole process
//! ```no_run
//! use std::time::Duration;
//!
//! use messages::{Goal, NominalCommand, ProcessId, Reason};
//! use node_runtime::{
//!     Clock, HealthReporter, Node, Pacing, ProcessLoop, Publisher, RealClock, Shutdown, Subscriber, Tick, Work,
//! };
//!
//! struct MyController {
//!     goals: Subscriber<Goal>,
//!     commands: Publisher<NominalCommand>,
//! }
//!
//! # fn step(_: Option<Goal>, _now_ns: u64) -> NominalCommand { loop {} }
//! impl Work for MyController {
//!     fn cycle(&mut self, tick: &Tick, health: &mut HealthReporter) {
//!         let command = step(self.goals.newest(), tick.woke_ns);
//!         match self.commands.send(&command) {
//!             Ok(()) => health.accepted(1),
//!             Err(_) => health.error(Reason::PortFailed),
//!         }
//!     }
//! }
//!
//! fn main() -> Result<(), Box<dyn std::error::Error>> {
//!     let shutdown = Shutdown::install()?;
//!     let node = Node::open("demo", ProcessId::Nominal)?;
//!     let mut work = MyController { goals: node.subscriber()?, commands: node.publisher()? };
//!     let pacing = Pacing::timer(RealClock.now_ns(), Duration::from_millis(50));
//!     ProcessLoop::new(&node)?.run(&mut work, pacing, None, None, &shutdown);
//!     Ok(())
//! }
//! ```
//! A process that its inputs drive gives the loop [`Node::wake_up`]; its senders hold a [`Waker`] of it.

mod clock;
mod cycle_meter;
mod cyclic_schedule;
#[cfg(feature = "dds")]
mod dds;
pub mod doctor;
mod domain;
mod health_reporter;
mod iceoryx;
mod leftovers;
mod logging;
mod node;
mod notices;
mod pacer;
mod pacing;
mod process_loop;
mod processor_share;
mod publisher;
pub mod realtime;
mod services;
mod shutdown;
mod subscriber;
mod thread_usage;
mod transport;
mod wake;

pub use clock::{Clock, RealClock, SteppedClock};
pub use cycle_meter::CycleMeter;
pub use cyclic_schedule::{CyclicSchedule, Tick};
pub use domain::{Domain, DomainError};
pub use health_reporter::HealthReporter;
pub use leftovers::{CleanUpError, Leftover, Member, ScopedDomain, clean_up, leftovers, members};
pub use logging::start_logging;
pub use node::{Node, NodeError};
pub use notices::Notices;
pub use pacer::{Pacer, Waiting};
pub use pacing::Pacing;
pub use process_loop::{ProcessLoop, Work};
pub use publisher::{PortError, Publisher};
pub use services::check_instance;
pub use shutdown::{PARENT_PID_VARIABLE, Shutdown, ShutdownError};
pub use subscriber::Subscriber;
pub use thread_usage::{ThreadUsage, UsageMeter};
pub use transport::{Transport, TransportError};
pub use wake::{WakeUp, Waker, Woken};
