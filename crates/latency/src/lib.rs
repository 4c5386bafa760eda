//! Latency histograms and the per-hop ledger.
//!
//! Every [`messages::SafeCommand`] carries the times of everything it rests on. A [`Recorder`] reads them one command
//! after the other and keeps one histogram per [`Hop`] of the path from sensor to command, together with the counts
//! that tell whether the filter kept its period. A [`Summary`] holds the figures and prints them.
//!
//! Nothing is filtered: outliers stay in, and the smallest and the largest value are kept exactly, beside the
//! percentiles, which HdrHistogram gives to three significant digits.
//!
//! What is deliberately absent: clocks and ports. All times come out of the messages, on the stack clock, in ns.
//!
//! ```
//! # let commands: Vec<messages::SafeCommand> = Vec::new();
//! let mut recorder = latency::Recorder::new(4_000_000);
//! for command in &commands {
//!     recorder.record(command);
//! }
//! let table = recorder.summary().to_string();
//! # assert!(table.contains("end to end"));
//! ```

mod histogram;
mod hop;
mod recorder;
mod summary;

pub use histogram::QuantilePoint;
pub use hop::Hop;
pub use recorder::{MergeError, Recorder};
pub use summary::{HopSummary, Summary};
