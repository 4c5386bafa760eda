//! Process 2: detections in, obstacle states and their time derivatives out.
//!
//! [`Estimator`] is the whole of it, pure and free of allocation; the shell around it owns ports and time. Velocities
//! are the paper's backward differences over the *measured* interval, what perception itself measured, or what a Kalman
//! filter or several side by side ([`motion`]) believe.
//!
//! Not here: perception, and what the robot does about obstacles. Who relies on an answer later than the time it holds for
//! predicts it that far, as `cbf_filter` does: the delay of perception is made up for there, once.

mod assignment;
mod association;
mod beliefs;
mod counts;
mod estimator;
pub mod motion;
mod noise_level;
mod recent;
pub mod shell;
mod track;

pub use counts::EstimatorCounts;
pub use estimator::{Estimator, FIRST_ANONYMOUS_ID, FUTURE_TOLERANCE_NS};
