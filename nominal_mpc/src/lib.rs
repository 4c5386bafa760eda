//! Process 3: the nominal controller, which drives to the goal as if nobody else were there.
//!
//! [`NominalController::step`] answers the newest robot state and goal with a [`messages::NominalCommand`], or says why
//! it stays silent ([`Silence`]); the filter brakes on silence. It is pure: no clock, no port. [`shell::run`] gives it
//! both, 20 times a second.
//!
//! What is deliberately absent: obstacles. This process does not even subscribe to them; keeping clear of people is
//! the filter's task, and mixing the two would blur what the filter is worth.

mod lqr_drive;
mod mpc_drive;
mod pure_pursuit_drive;
pub mod shell;
mod silence;
mod step;

pub use silence::{NominalSetupError, Silence};
pub use step::{Inputs, NominalController};
