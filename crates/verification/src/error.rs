//! Why a verification could not be carried out. What it found, good or bad, is a record, never an error.

use barrier::{DynamicsKind, KernelError, QpError};
use dynamics::InputBoxError;

/// Why a verification ended without a record.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum VerificationError {
    /// The kernel does not run here.
    #[error(transparent)]
    Kernel(#[from] KernelError),
    /// The model's disturbance box is none.
    #[error("the model's disturbance box: {0}; train it again")]
    Disturbance(#[from] InputBoxError),
    /// The QP of the closed loop cannot be set up.
    #[error(transparent)]
    Qp(#[from] QpError),
    /// The model's box lies inside its failure disc.
    #[error(
        "the trained box reaches {reach_m} m, the failure radius is {radius_m} m: nothing to verify outside"
    )]
    NothingOutside {
        /// Distance of the farthest corner, m.
        reach_m: f64,
        /// Failure radius, m.
        radius_m: f64,
    },
    /// The truth belongs to another game.
    #[error(
        "the reference was solved for another {what} ({reference}) than the model's ({model}); \
         solve for the model's true bounds, without slack scales"
    )]
    AnotherGame {
        /// In what they differ.
        what: &'static str,
        /// Of the reference.
        reference: String,
        /// Of the model.
        model: String,
    },
    /// No closed form is known for the pair.
    #[error("no closed form is known for `{dynamics}`; give a solved value file instead")]
    NoClosedForm {
        /// The model's pair.
        dynamics: DynamicsKind,
    },
    /// The reference covers none of the model's box.
    #[error(
        "the reference covers none of the {states} states drawn from the model's box; solve it on that box"
    )]
    NothingCovered {
        /// States drawn.
        states: usize,
    },
    /// A setting without sense.
    #[error("{field} is {value}; choose {expected}")]
    Setting {
        /// Name of the setting.
        field: &'static str,
        /// Value given.
        value: f64,
        /// What would be taken.
        expected: &'static str,
    },
    /// The model calls almost nothing safe.
    #[error(
        "no state with h >= 0 among {drawn} drawn outside the failure disc; the model calls everything unsafe"
    )]
    NoSafeState {
        /// States drawn.
        drawn: usize,
    },
    /// The progress callback asked to stop.
    #[error("stopped as asked, nothing is recorded; run again")]
    Stopped,
}

/// Refuses a setting that is not positive and finite.
pub(crate) fn require_positive(field: &'static str, value: f64) -> Result<(), VerificationError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(VerificationError::Setting { field, value, expected: "a positive, finite number" })
    }
}
