//! Commands on their way out: a thread that publishes what the bridge's loop puts into a queue.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;

use recording::ros2::{Header, Twist, TwistStamped, Vector3};
use settings::{CommandMessage, Ros2Settings};

use super::error::RosError;
use super::graph::Graph;
use super::outlet::Outlet;
use super::timebase::RosTime;

/// Commands that may wait. More would only be older.
const PLACES: usize = 2;
/// The robot's own frame, in which velocities are given (REP-105).
const BASE_FRAME: &str = "base_link";
/// How long the last command is given to leave before DDS goes.
const FAREWELL: Duration = Duration::from_millis(20);

/// The bridge's end of the queue. Dropping it publishes a standstill.
pub(super) struct Commander {
    commands: Option<SyncSender<[f64; 2]>>,
    thread: Option<JoinHandle<()>>,
}

/// The topic, with the type that the settings name.
enum Port {
    Plain(Outlet<Twist>),
    Stamped(Outlet<TwistStamped>, RosTime),
}

impl Commander {
    /// Opens the topic and starts the thread. `time` is what commands are stamped with.
    pub(super) fn start(graph: &mut Graph, ros2: &Ros2Settings, time: RosTime) -> Result<Self, RosError> {
        let topic = ros2.absolute(&ros2.command_topic);
        let port = match ros2.command {
            CommandMessage::Twist => Port::Plain(graph.publish(&topic)?),
            CommandMessage::TwistStamped => Port::Stamped(graph.publish(&topic)?, time),
        };
        let (commands, queue) = sync_channel(PLACES);
        let span = tracing::Span::current();
        let thread = std::thread::Builder::new()
            .name("cncbf-ros2-out".to_owned())
            .spawn(move || span.in_scope(|| publish_all(&queue, &port, &topic)))
            .map_err(|error| RosError::Thread { cause: error.to_string() })?;
        Ok(Self { commands: Some(commands), thread: Some(thread) })
    }

    /// Puts `[speed m/s, yaw rate rad/s]` on its way. False if there was no place.
    pub(super) fn give(&self, control: [f64; 2]) -> bool {
        self.commands.as_ref().is_some_and(|commands| commands.try_send(control).is_ok())
    }

    /// Whether the thread has ended though nobody asked it to.
    pub(super) fn has_ended(&self) -> bool {
        self.thread.as_ref().is_some_and(JoinHandle::is_finished)
    }
}

impl Drop for Commander {
    fn drop(&mut self) {
        self.commands = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Publishes until the other end is gone, then a standstill. A change between failing and not is logged.
fn publish_all(queue: &Receiver<[f64; 2]>, port: &Port, topic: &str) {
    let mut failing = false;
    for control in queue {
        let failure = port.publish(control).err();
        match (&failure, failing) {
            (Some(cause), false) => tracing::warn!(topic, cause, "commands do not leave"),
            (None, true) => tracing::info!(topic, "commands leave again"),
            (Some(_), true) | (None, false) => {}
        }
        failing = failure.is_some();
    }
    if let Err(cause) = port.publish([0.0; 2]) {
        tracing::warn!(topic, cause, "the last command, a standstill, did not leave");
    }
    std::thread::sleep(FAREWELL);
}

impl Port {
    fn publish(&self, [speed_mps, yaw_rate_radps]: [f64; 2]) -> Result<(), String> {
        let twist = Twist {
            linear: Vector3 { x: speed_mps, ..Vector3::default() },
            angular: Vector3 { z: yaw_rate_radps, ..Vector3::default() },
        };
        match self {
            Self::Plain(port) => port.publish(twist),
            Self::Stamped(port, time) => {
                let header = Header { stamp: time.now(), frame_id: BASE_FRAME.to_owned() };
                port.publish(TwistStamped { header, twist })
            }
        }
    }
}
