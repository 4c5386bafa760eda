//! Process 1: sources in, commands out.
//!
//! A [`Source`] turns the outside world into [`messages::RobotState`], [`messages::Detections`] and [`messages::Goal`] in
//! `odom`. Time is passed in and no source sleeps, so that one implementation serves real time, lockstep and evaluation;
//! [`shell::run`] gives it time and ports. Commands come back through the [`CommandSink`], which brakes by itself when
//! the filter falls silent.
//!
//! Not here: estimation of velocities, and any decision about the robot beyond that brake.

mod command_sink;
pub mod shell;
mod simulated_crowd;
mod source;

pub use command_sink::{CommandSink, SinkState};
pub use simulated_crowd::{SimulatedCrowd, SimulationError};
pub use source::{BridgeEvent, Source};
