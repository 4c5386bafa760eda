//! What every source of the bridge can do.

use std::path::PathBuf;

use messages::{Detections, Goal, NominalCommand, RobotState, SafeCommand, SourceStatus};
use node_runtime::Waker;
use settings::Settings;

use crate::command_sink::{Obedience, SinkState};
use crate::live::{RosError, RosSource, ZeroLevelOf};
use crate::playback::Playback;
use crate::recorded::{McapSource, SourceError};
use crate::simulated_crowd::{SimulatedCrowd, SimulationError};

/// Where the bridge takes the world from.
#[derive(Debug, Clone, PartialEq)]
pub enum SourceChoice {
    /// The simulated crowd of the settings.
    Simulation {
        /// Whom its robot obeys.
        obeys: Obedience,
    },
    /// A recording.
    Mcap {
        /// The file.
        file: PathBuf,
        /// Whether a simulated robot that obeys the filter replaces the recorded one.
        closed_loop: bool,
        /// How fast and how often it is played.
        playback: Playback,
    },
    /// A live ROS 2 graph: the one that the environment names.
    Ros2 {
        /// Whether the robot is left alone: no command is published, not even the topic for it opened.
        shadow: bool,
    },
}

/// Why a source could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenSourceError {
    /// The simulated crowd.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The recording.
    #[error(transparent)]
    Recording(#[from] SourceError),
    /// The live graph.
    #[error(transparent)]
    Ros2(#[from] RosError),
}

/// Opens the source that `choice` names.
///
/// # Errors
/// [`OpenSourceError`] if it cannot be set up.
pub fn open_source(settings: &Settings, choice: &SourceChoice) -> Result<Box<dyn Source>, OpenSourceError> {
    Ok(match choice {
        SourceChoice::Simulation { obeys } => Box::new(SimulatedCrowd::with_robot_obeying(settings, *obeys)?),
        SourceChoice::Mcap { file, closed_loop, playback } => {
            Box::new(McapSource::open(file, settings, *closed_loop)?.played(*playback)?)
        }
        SourceChoice::Ros2 { shadow } => Box::new(RosSource::open(settings, *shadow)?),
    })
}

/// Something the bridge publishes. Every stamp is set but `published_ns`, which belongs to the sender.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "events are handed over by value without allocation")]
pub enum BridgeEvent {
    /// Where the robot is.
    RobotState(RobotState),
    /// One frame of perception.
    Detections(Detections),
    /// Where the robot shall go.
    Goal(Goal),
    /// What the robot would do without this stack. `bridge_published_ns` is the sender's, too.
    NominalCommand(NominalCommand),
}

/// A source of sensor messages: a recording, a simulation, a live graph.
///
/// All times are on the stack clock, ns. The caller polls until nothing more is due, then waits until
/// [`Source::next_due_ns`] or until a command arrives.
pub trait Source {
    /// Is given what wakes the caller. A source whose events come at due times alone needs none.
    fn wake_with(&mut self, _waker: Waker) {}

    /// Is told which stack it serves, and what can draw that stack's barrier. Only a source with somebody to tell needs it.
    fn serve(&mut self, _instance: &str, _zero_level: Option<ZeroLevelOf>) {}

    /// Whether it gives nominal commands; nobody else may then give any.
    fn gives_nominal_commands(&self) -> bool {
        false
    }

    /// When the next event is due; `None` once the source has nothing more to give.
    fn next_due_ns(&self) -> Option<u64>;

    /// The next event that is due at `now_ns`, if any. Events of one poll sequence come in the order of their time.
    fn poll(&mut self, now_ns: u64) -> Option<BridgeEvent>;

    /// Takes a command that arrived at `now_ns`. A source without a robot of its own ignores it.
    fn command(&mut self, command: &SafeCommand, now_ns: u64);

    /// How far the source has come, and what it knows of the truth.
    fn status(&self, now_ns: u64) -> SourceStatus;

    /// Whether it has lost what it hears or commands with, and only a new one can help. Asked in every cycle.
    fn has_failed(&self) -> bool {
        false
    }

    /// What the command sink of the robot does; `None` for a source whose robot takes no commands.
    fn sink_state(&self) -> Option<SinkState>;
}
