//! Commands on their way out: a thread that publishes the newest one that the bridge's loop has given.

use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use recording::ros2::{Header, Twist, TwistStamped, Vector3};
use settings::{CommandMessage, Ros2Settings};

use super::error::RosError;
use super::graph::Graph;
use super::outbox::Outbox;
use super::outlet::Outlet;
use super::timebase::RosTime;

/// The robot's own frame, in which velocities are given (REP-105).
const BASE_FRAME: &str = "base_link";
/// How long the last command is given to leave before DDS goes.
const FAREWELL: Duration = Duration::from_millis(20);

/// The bridge's end. Dropping it publishes a standstill.
pub(super) struct Commander {
    commands: Arc<Outbox<[f64; 2]>>,
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
        let commands = Arc::new(Outbox::new());
        let (given, span) = (Arc::clone(&commands), tracing::Span::current());
        let thread = std::thread::Builder::new()
            .name("cncbf-ros2-out".to_owned())
            .spawn(move || span.in_scope(|| publish_all(&given, &port, &topic)))
            .map_err(|error| RosError::Thread { cause: error.to_string() })?;
        Ok(Self { commands, thread: Some(thread) })
    }

    /// Puts `[speed m/s, yaw rate rad/s]` on its way. False if the one before it had not left: nobody will hear that one.
    pub(super) fn give(&self, control: [f64; 2]) -> bool {
        self.thread.as_ref().is_some_and(|thread| self.commands.put(control, thread.thread()))
    }

    /// Whether the thread has ended though nobody asked it to.
    pub(super) fn has_ended(&self) -> bool {
        self.thread.as_ref().is_some_and(JoinHandle::is_finished)
    }
}

impl Drop for Commander {
    fn drop(&mut self) {
        if let Some(thread) = self.thread.take() {
            self.commands.close(thread.thread());
            let _ = thread.join();
        }
    }
}

/// Publishes until the other end is gone, then a standstill. A change between failing and not is logged.
fn publish_all(commands: &Outbox<[f64; 2]>, port: &Port, topic: &str) {
    let mut failing = false;
    commands.take_each(|control| {
        let failure = port.publish(control).err();
        match (&failure, failing) {
            (Some(cause), false) => tracing::warn!(topic, cause, "commands do not leave"),
            (None, true) => tracing::info!(topic, "commands leave again"),
            (Some(_), true) | (None, false) => {}
        }
        failing = failure.is_some();
    });
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
