//! The stack in one process and virtual time.
//!
//! [`VirtualStack`] calls the four processes' own steps, one after the other, on a clock that it owns. Nothing depends on
//! scheduling, so the same source gives the same bytes on every run, at many times real time. `cncbf replay --lockstep`
//! is this.
//!
//! Not here: ports, sleep, and any second implementation of what a process does.

mod virtual_stack;

pub use virtual_stack::{START_NS, SetupError, VirtualStack};
