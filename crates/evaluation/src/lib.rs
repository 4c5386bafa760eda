//! The stack in one process and virtual time, and tables over many of its runs.
//!
//! [`VirtualStack`] calls the four processes' own steps, one after the other, on a clock that it owns. Nothing depends on
//! scheduling, so the same source gives the same bytes on every run, at many times real time. `cncbf replay --lockstep`
//! is this.
//!
//! [`run`] drives one method ([`Variant`]) through one world ([`Scenario`]) on it and judges what came of it: a [`Row`].
//! [`Campaign`] does so for many of both on all cores into a [`Store`]; [`statistics`] and [`summary`] say what the rows
//! show. `cncbf evaluate` is this.
//!
//! Not here: ports, sleep, any second implementation of what a process does, and pages (crate `report`).

mod baseline;
mod campaign;
mod cause;
mod columns;
mod hash;
mod motion;
mod overrides;
mod partition;
mod row;
mod run;
mod scenario;
mod seat;
pub mod statistics;
mod stopwatch;
mod store;
pub mod summary;
mod table_file;
mod tally;
mod variant;
mod virtual_stack;
mod watched;

pub use baseline::BaselineError;
pub use campaign::{Campaign, CampaignError, Done, Progress};
pub use cause::Cause;
pub use hash::short_hash;
pub use overrides::OverrideError;
pub use partition::{Partition, PartitionError};
pub use row::{Key, Row};
pub use run::{RunError, run};
pub use scenario::Scenario;
pub use stopwatch::Stopwatch;
pub use store::{Store, StoreError, merged};
pub use table_file::{TableError, read_table, write_table};
pub use variant::{Robot, Variant, VariantError, WORLD};
pub use virtual_stack::{START_NS, SetupError, VirtualStack};
pub use watched::ALLOWED_OVERLAPS_M;
