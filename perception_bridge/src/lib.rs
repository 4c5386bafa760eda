//! Process 1: sources in, commands out.
//!
//! A [`Source`] turns the outside world into [`messages::RobotState`], [`messages::Detections`] and [`messages::Goal`] in
//! `odom`. Time is passed in and no source sleeps, so that one implementation serves real time, lockstep and evaluation;
//! [`shell::run`] gives it time and ports. Commands come back through the [`CommandSink`], which brakes by itself when
//! the filter falls silent.
//!
//! [`decode`] and [`Frames`] turn ROS 2 messages into the stack's own; they serve recordings ([`McapSource`]) and live topics
//! ([`RosSource`]) alike.
//!
//! Not here: estimation of velocities, and any decision about the robot beyond that brake.

mod command_sink;
pub mod decode;
mod frames;
mod live;
mod markers;
mod nearest;
mod obstacle_frames;
mod plausible;
mod playback;
mod recorded;
mod sensor;
pub mod shell;
mod simulated_crowd;
mod source;

pub use command_sink::{CommandSink, Obedience, SinkState};
pub use frames::Frames;
pub use live::{GraphSurvey, RosError, RosSource, SurveyedTopic, ZeroLevelOf, survey};
pub use playback::{Playback, PlaybackError};
pub use recorded::{
    IntakeReport, McapSource, PlaybackCounts, RecordedCrowd, RecordedCrowdError, SourceError,
    scenarios_of_recording,
};
pub use simulated_crowd::{SimulatedCrowd, SimulationError, simulated_scenario};
pub use source::{BridgeEvent, OpenSourceError, Source, SourceChoice, open_source};
