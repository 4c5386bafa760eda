//! Why no certificate was attempted or kept. What a search found, good or bad, is a record, never an error.

use std::path::PathBuf;

use barrier::KernelError;

use crate::error::VerificationError;

/// Why [`super::certify`] gave no record.
#[derive(Debug, thiserror::Error)]
pub enum AffineError {
    /// The region is no box.
    #[error("axis {axis} of the region runs from {min} to {max}; write finite limits in increasing order")]
    Region {
        /// Index of the axis.
        axis: usize,
        /// Lower end given.
        min: f64,
        /// Upper end given.
        max: f64,
    },
    /// The region leaves the trained box, beyond which the filter does not use the network as it is.
    #[error(
        "axis {axis} of the region runs from {min} to {max}, the model was trained from {trained_min} to \
         {trained_max}; choose a region inside"
    )]
    OutsideDomain {
        /// Index of the axis.
        axis: usize,
        /// Lower end given.
        min: f64,
        /// Upper end given.
        max: f64,
        /// Lower end of the trained box.
        trained_min: f64,
        /// Upper end of the trained box.
        trained_max: f64,
    },
    /// A number that must be positive is not.
    #[error("`{name}` is {value}; give a finite number above zero")]
    NotPositive {
        /// Name of the field.
        name: &'static str,
        /// Value given.
        value: f64,
    },
    /// Sums in the network may become so large that their sine is known to no digit.
    #[error(
        "sums before a sine may reach {sum}, bounds hold up to {limit}; this network was not trained, it diverged"
    )]
    Weights {
        /// Largest possible sum.
        sum: f64,
        /// Largest sum for which the sines' error is known.
        limit: f64,
    },
    /// The kernel does not run here.
    #[error(transparent)]
    Kernel(#[from] KernelError),
    /// The model's boxes make no game.
    #[error(transparent)]
    Game(#[from] Box<VerificationError>),
    /// A file of the search cannot be read or written.
    #[error("cannot access the checkpoint {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// The file is no checkpoint, or a damaged one.
    #[error("{} is no checkpoint of a certificate ({reason}); remove it to start again", path.display())]
    NoCheckpoint {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The checkpoint belongs to another question.
    #[error(
        "{} belongs to another {what} than asked for; ask for the same again, or name another file",
        path.display()
    )]
    AnotherQuestion {
        /// The file.
        path: PathBuf,
        /// In what they differ.
        what: &'static str,
    },
}
