//! Fits the residual network `r_Θ` to a value function and measures the fit.
//!
//! The paper learns `r = ℓ - V ≥ 0`, so that `h̄ = ℓ - r_Θ` never exceeds the failure function `ℓ`. [`train`] takes a
//! [`Target`] (the residual on a grid, or a closed form) and returns a network with a report; [`fit_error`] and
//! [`barrier_condition`] measure any network. The result is reproducible to the bit: see [`train`].
//!
//! Not here: solving for `V` (crate `reachability`), evaluating a model in the filter (crate `barrier`).

mod adam;
mod block;
mod checkpoint;
mod closed_form;
mod condition;
mod condition_block;
mod error;
mod export;
mod features;
mod judge;
mod kernel;
pub mod network;
mod packed;
mod panel;
mod pass;
mod pool;
mod report;
mod residual_grid;
mod sampler;
mod setup;
mod sine;
mod step;
mod strata;
mod target;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests_support;
mod train;
mod verify;
mod worst_case;

pub use checkpoint::CheckpointError;
pub use closed_form::{ClosedForm, ValueFn};
pub use error::{TargetError, TrainError};
pub use export::{ExportError, network_of};
pub use judge::{Judge, uniform_states};
pub use network::FittedNetwork;
pub use report::{ConditionReport, ErrorSummary, FitError, TrainedNetwork, TrainingReport};
pub use residual_grid::{ResidualGrid, failure_function};
pub use setup::{TrainSettingsError, Trained, Values, train_settings};
pub use target::Target;
pub use train::{Job, Progress, train};
pub use verify::{barrier_condition, evaluate, fit_error};
pub use worst_case::{WorstCase, game};
