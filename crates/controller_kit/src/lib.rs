//! A test bench for nominal controllers, in whatever language they are written.
//!
//! [`check`] starts a candidate in a domain of its own, plays the stack's part over the stack's own services – robot states, goals,
//! no obstacles – with a small simulated robot that does what the candidate says, and judges what it heard against what
//! `docs/own_controller.md` asks; `docs/controller_kit.md` lists the rules. The script is in `script`, the rules are in `rules`, one file per concern.
//!
//! Not here: the filter, and any judgement of how well a controller drives; `cncbf compare` shows that.

mod bench;
mod candidate;
mod check;
mod findings;
mod observations;
mod robot;
mod rules;
mod script;

pub use candidate::{Candidate, Ending, StartError};
pub use check::{KitError, Plan, check};
pub use findings::{Check, Findings, Outcome};
