//! What the benchmarks, the percentile program and the instruction counter run: the shipped ground robot among people.
//!
//! Here: inputs that are the same in every run, and steps over them that only call the processes' own. Not here: clocks
//! and statistics.
#![allow(dead_code, unused_imports, unreachable_pub, missing_docs)] // each program that includes this uses its part
#![allow(clippy::unwrap_used)] // a benchmark may panic

mod codec;
mod drive;
mod filter;
mod frames;

pub use codec::{Recordings, Ros2Coding};
pub use drive::{Drive, GOALS_IN_ODOM_M, PERIOD_NS, STEPS_PER_GOAL};
pub use filter::{
    BarrierStep, FilterStep, NetworkStep, QpStep, SearchStep, VARIANTS, nominal_control, person, robot_pose,
};
pub use frames::{ESTIMATORS, EstimatorStep};

use messages::Stamp;
use settings::Settings;

pub const NS_PER_MS: u64 = 1_000_000;
/// A stack clock that has run for a while.
pub const START_NS: u64 = 1_000 * NS_PER_MS;

/// The shipped ground robot. Part of the program, so that it cannot change between build and run.
pub fn settings() -> Settings {
    let text = include_str!("../../config/ground_robot.toml");
    Settings::parse(text, "ground_robot.toml".as_ref(), "config".as_ref()).unwrap()
}

pub fn stamp(at_ns: u64) -> Stamp {
    Stamp { sequence: 1, source_ns: at_ns, valid_at_ns: at_ns, ingress_ns: at_ns, published_ns: at_ns }
}
