//! Value functions known without a grid, the judges of those that need one.
//!
//! Only the double-integrator pair has one. The relative unicycle has none; optimal play judges it.

mod approach;
mod double_integrator;

pub use double_integrator::{ClosedFormError, DoubleIntegratorValue};
