//! What every source of the bridge can do.

use messages::{Detections, Goal, RobotState, SafeCommand, SourceStatus};

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
}

/// A source of sensor messages: a recording, a simulation, a live graph.
///
/// All times are on the stack clock, ns. The caller polls until nothing more is due, then waits until
/// [`Source::next_due_ns`] or until a command arrives.
pub trait Source {
    /// When the next event is due; `None` once the source has nothing more to give.
    fn next_due_ns(&self) -> Option<u64>;

    /// The next event that is due at `now_ns`, if any. Events of one poll sequence come in the order of their time.
    fn poll(&mut self, now_ns: u64) -> Option<BridgeEvent>;

    /// Takes a command that arrived at `now_ns`. A source without a robot of its own ignores it.
    fn command(&mut self, command: &SafeCommand, now_ns: u64);

    /// How far the source has come, and what it knows of the truth.
    fn status(&self, now_ns: u64) -> SourceStatus;
}
