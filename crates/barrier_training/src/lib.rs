//! Fits the residual network `r_Θ` to a solved value function and measures the fit.
//!
//! The paper learns `r = ℓ - V ≥ 0`, so that `h̄ = ℓ - r_Θ` never exceeds the failure function `ℓ`. [`train`] takes the
//! residual on a grid ([`ResidualGrid`]) and returns weights with a report; [`fit_error`] and [`barrier_condition`]
//! measure any weights. The result is reproducible to the bit: see [`train`].
//!
//! Not here: solving for `V` (crate `reachability`), evaluating a model in the filter (crate `barrier`).

mod adam;
mod block;
mod error;
mod export;
mod kernel;
pub mod network;
mod packed;
mod panel;
mod pool;
mod recipe;
mod report;
mod residual_grid;
mod sine;
mod step;
mod train;
mod verify;

pub use error::{TargetError, TrainError};
pub use export::{ExportError, parameters_of, to_model};
pub use recipe::Recipe;
pub use report::{ConditionReport, ErrorSummary, FitError, TrainedModel, TrainingReport};
pub use residual_grid::{ResidualGrid, failure_function};
pub use train::{Progress, train};
pub use verify::{barrier_condition, evaluate, fit_error};
