//! Hamilton–Jacobi–Isaacs variational inequality on grids: from relative dynamics to the value function.
//!
//! Here live the grid, the upwind schemes, the time integration with its convergence test and checkpoints, the file
//! that carries a solved value function, and the closed form that judges it all. Not here: the dynamics themselves (`dynamics`), the network that
//! replaces the table (`barrier_training`), and any clock or terminal: progress goes to a callback.
//!
//! ```text
//! dynamics ─┐
//! grid ─────┼─> solve ──> Solution ──> ValueFunction ──> file, interpolation, gradient
//! settings ─┘
//! ```

// Only inlined code is compiled for the vector width that `pulp` finds at run time.
#![allow(clippy::inline_always)]

mod checkpoint;
pub mod closed_form;
mod coefficients;
mod dissipation;
mod failure;
mod from_settings;
mod grid;
mod integrate;
mod interior;
mod memory;
mod operator;
mod settings;
mod solve;
mod stencil;
mod upwind;
mod value_file;
mod value_function;

pub use checkpoint::{Checkpoint, CheckpointError};
pub use failure::disc_failure_function;
pub use from_settings::{
    SettingsSolveError, memory_of_settings_bytes, solve_settings, solve_settings_resumable,
};
pub use grid::{Axis, Cell, Grid, GridError, MIN_NODES};
pub use integrate::Stepper;
pub use memory::{memory_available_bytes, memory_needed_at_most_bytes};
pub use settings::{
    Convergence, Dissipation, SettingsError, SolverSettings, TimeIntegrator, TubeForm, UpwindScheme,
};
pub use solve::{HistoryEntry, Outcome, Progress, Solution, SolveError, solve, solve_resumable};
pub use value_file::ValueFileError;
pub use value_function::{InputLimits, ProblemDescription, ValueFunction, ValueMetadata};
