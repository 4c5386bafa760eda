//! Process 2: detections in, obstacle states and their time derivatives out.
//!
//! [`Estimator`] is the whole of it, pure and free of allocation; the shell around it owns ports and time. Velocities
//! are the paper's backward differences over the *measured* interval, or what perception itself measured.
//!
//! Not here: perception, filtering of noise, and what the robot does about obstacles.

mod association;
mod counts;
mod estimator;
pub mod shell;
mod track;

pub use counts::EstimatorCounts;
pub use estimator::{Estimator, FIRST_ANONYMOUS_ID, FUTURE_TOLERANCE_NS};
