//! What stands between a process' `step` function and the operating system: typed ports over iceoryx2, clocks, the
//! cyclic timer, health, orderly shutdown, and removal of what crashed processes leave behind.
//!
//! This is the only crate that knows iceoryx2. It holds no physics, no decision about the robot and no scheduling
//! class; a process decides with its own `step(inputs, now)`, which knows neither a clock nor a port.
//!
//! # Delivery
//! Every service is *latest wins*: a full queue drops its oldest entry, a sender never waits, and whoever subscribes late
//! is handed the last sample at the next sending (or [`Publisher::serve_late_joiners`]). Publishers and subscribers may start in any order. One process at a time may write a
//! service (only [`messages::Health`] has many writers), so that two filters can never drive one robot; the place of a
//! writer that was killed is free again as soon as its successor opens its [`Node`].
//!
//! # Allocation
//! After construction, [`Subscriber::newest`], [`Subscriber::drain`], [`Waker::wake`], [`WakeUp::wait`], the timer and
//! the clocks allocate nothing. [`Publisher::send`] causes one allocation inside iceoryx2 (the loan). The exception: the
//! first call after a peer has come or gone sets up or takes down the connection. `tests/allocations.rs` counts.
//!
//! # A whole process
//! ```no_run
//! use std::time::Duration;
//!
//! use messages::{Obstacles, ProcessId, Reason, RobotState, SafeCommand};
//! use node_runtime::{CyclicTimer, HealthReporter, Node, RealClock, Shutdown};
//!
//! # fn step(_: Option<&RobotState>, _: Option<&Obstacles>, _due_ns: u64, _woke_ns: u64) -> SafeCommand { loop {} }
//! fn main() -> Result<(), Box<dyn std::error::Error>> {
//!     let shutdown = Shutdown::install()?;
//!     let node = Node::open("demo", ProcessId::Filter)?;
//!     let mut robot_states = node.subscriber::<RobotState>()?;
//!     let mut obstacles = node.subscriber::<Obstacles>()?;
//!     let commands = node.publisher::<SafeCommand>()?;
//!     let sink = node.waker(ProcessId::Bridge)?;
//!     let mut health = HealthReporter::new(&node)?;
//!
//!     let (mut robot_state, mut around) = (None, None);
//!     let mut timer = CyclicTimer::new(RealClock, Duration::from_millis(4));
//!     while !shutdown.requested() {
//!         let tick = timer.wait();
//!         robot_state = robot_states.newest().or(robot_state);
//!         around = obstacles.newest().or(around);
//!         let command = step(robot_state.as_ref(), around.as_ref(), tick.due_ns, tick.woke_ns);
//!         if commands.send(&command).is_err() {
//!             health.error(Reason::PortFailed);
//!         }
//!         sink.wake();
//!         health.cycle(&tick);
//!         health.report(tick.woke_ns);
//!     }
//!     Ok(())
//! }
//! ```
//! A process that is driven by its inputs instead waits on [`Node::wake_up`]; its senders hold a [`Waker`] of it.

mod clock;
mod cycle_meter;
mod cyclic_timer;
pub mod doctor;
mod domain;
mod health_reporter;
mod leftovers;
mod logging;
mod node;
mod pacer;
mod pacing;
mod publisher;
pub mod realtime;
mod services;
mod shutdown;
mod stillborn;
mod subscriber;
mod thread_usage;
mod wake;

pub use clock::{Clock, RealClock, SteppedClock};
pub use cycle_meter::CycleMeter;
pub use cyclic_timer::{CyclicSchedule, CyclicTimer, Tick};
pub use domain::{Domain, DomainError};
pub use health_reporter::HealthReporter;
pub use leftovers::{CleanUpError, Leftover, Member, ScopedDomain, clean_up, leftovers, members};
pub use logging::start_logging;
pub use node::{Node, NodeError};
pub use pacer::{Pacer, Waiting};
pub use pacing::Pacing;
pub use publisher::{PortError, Publisher};
pub use shutdown::{PARENT_PID_VARIABLE, Shutdown, ShutdownError};
pub use subscriber::Subscriber;
pub use thread_usage::{ThreadUsage, UsageMeter};
pub use wake::{WakeUp, Waker, Woken};
