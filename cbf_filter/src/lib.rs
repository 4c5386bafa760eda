//! Process 4: the composite neural CBF filter.
//!
//! [`SafetyFilter::step`] takes the newest robot state, obstacles and nominal command and always returns a finite
//! [`messages::SafeCommand`]: corrected by the CBF-QP where its inputs can be trusted, a brake where they cannot. It is
//! pure: no clock, no port, no allocation. [`shell::run`] gives it time and ports, 250 times a second.
//!
//! What is deliberately absent: where to go (the nominal controller's business; `[filter.anticipation]` only looks for a way
//! past people to the goal it is told), estimation (the estimator's), and any way to switch the filter off.

mod anticipation;
mod appearance;
mod brake;
mod class_models;
mod filter;
mod joint;
mod ladder;
mod model;
mod options;
mod pace;
mod prediction;
pub mod shell;
mod trust;

pub use filter::{Inputs, SafetyFilter, chosen_kernel};
pub use ladder::rung;
pub use model::{EMBEDDED_MODELS, FilterSetupError, load_model};
