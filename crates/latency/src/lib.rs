//! From recorded messages to figures: how long every hop took, how late every loop was, and what changed.
//!
//! Every [`messages::SafeCommand`] carries the times of everything it rests on. A [`Recorder`] reads them one command
//! after the other and keeps one histogram per [`Hop`] of the path from sensor to command, together with the counts
//! that tell whether the filter kept its period. A [`Summary`] holds the figures and prints them.
//!
//! A profile is several repeats of one run under stated [`Conditions`]:
//!
//! * [`RepeatFigures::of`] – one repeat from its [`RunMessages`]: hops, loops, faults, switches, memory, rights.
//! * [`ProfileFigures`] – all repeats and their pooled figures; versioned JSON, tables for the terminal.
//! * [`write_hlog`] – the same histograms in the standard HdrHistogram log.
//! * [`compare`] and [`judge`] – against a baseline, and against [`Budget`]s.
//! * [`chrome_trace`] – one run as a trace that Perfetto opens.
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

mod bootstrap;
mod budget;
mod compare;
mod conditions;
mod histogram;
mod histogram_text;
mod hlog;
mod hop;
mod judge;
mod loops;
mod process_key;
mod profile;
mod profile_display;
mod quantity;
mod recorder;
mod rights;
mod run_messages;
mod summary;
mod trace;

pub use bootstrap::{CONFIDENCE, FEWEST_REPEATS, RESAMPLES};
pub use budget::{Budget, BudgetError, Counter, Limit};
pub use compare::{Across, Change, CompareError, Comparison, QuantityChange, SHOWN, compare};
pub use conditions::{Conditions, Difference, Machine, RecordingIdentity};
pub use histogram::{Latencies, QuantilePoint, Statistic};
pub use histogram_text::HistogramTextError;
pub use hlog::write_hlog;
pub use hop::Hop;
pub use judge::{Judged, NoBaseline, Outcome, judge};
pub use loops::LoopFigures;
pub use profile::{
    HopLatencies, PROFILE_FORMAT, PooledFigures, ProfileFigures, ReadProfileError, RepeatFigures, StartUp,
};
pub use quantity::Quantity;
pub use recorder::{MergeError, Recorder};
pub use rights::Rights;
pub use run_messages::{Resident, RunMessages};
pub use summary::{Counts, HopSummary, LatencySummary, Summary};
pub use trace::chrome_trace;
