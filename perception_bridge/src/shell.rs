//! Time and ports around a [`crate::Source`].

use std::time::Duration;

use anyhow::Context;
use messages::{Detections, Goal, ProcessId, Reason, RobotState, SafeCommand, SourceStatus};
use node_runtime::{Clock, HealthReporter, Node, Publisher, RealClock, Shutdown, WakeUp};
use settings::Settings;

use crate::command_sink::SinkState;
use crate::source::{BridgeEvent, open_source};

/// How often the source's status is published, ns.
const STATUS_PERIOD_NS: u64 = 100_000_000;
/// Longest sleep, so that a wish to stop is heard.
const LONGEST_WAIT_NS: u64 = 50_000_000;

pub use crate::source::SourceChoice;

/// Runs the bridge of stack `instance` until told to stop. A source that has ended keeps saying so.
///
/// # Errors
/// If the source cannot be opened or a port not be opened; never once the loop runs.
pub fn run(settings: &Settings, instance: &str, choice: &SourceChoice) -> anyhow::Result<()> {
    let shutdown = Shutdown::install()?;
    let node = Node::open(instance, ProcessId::Bridge)?;
    let mut source = open_source(settings, choice)?;
    let mut commands = node.subscriber::<SafeCommand>().context("safe commands")?;
    let mut ports = Ports::open(&node)?;
    let mut status_due_ns = 0;
    let mut braking = None;
    while !shutdown.requested() {
        let woke_ns = RealClock.now_ns();
        if let Some(command) = commands.newest() {
            source.command(&command, woke_ns);
        }
        // The time stands still in this loop, so that a source slower than the clock cannot keep it busy for ever.
        while let Some(event) = source.poll(woke_ns) {
            ports.publish(&event);
        }
        braking = ports.complain(braking, source.sink_state());
        if woke_ns >= status_due_ns {
            status_due_ns = woke_ns + STATUS_PERIOD_NS;
            ports.publish_status(&source.status(woke_ns));
            ports.serve_late_joiners();
        }
        ports.health.woken_cycle();
        ports.health.report(woke_ns);
        let now_ns = RealClock.now_ns();
        let due_ns = source.next_due_ns().unwrap_or(u64::MAX).min(now_ns + LONGEST_WAIT_NS);
        // Returns early when a command arrives.
        ports.wake_up.wait(Duration::from_nanos(due_ns.saturating_sub(now_ns)));
    }
    Ok(())
}

struct Ports {
    robot_states: Publisher<RobotState>,
    detections: Publisher<Detections>,
    goals: Publisher<Goal>,
    status: Publisher<SourceStatus>,
    estimator: node_runtime::Waker,
    wake_up: WakeUp,
    health: HealthReporter,
}

impl Ports {
    fn open(node: &Node) -> anyhow::Result<Self> {
        Ok(Self {
            robot_states: node.publisher().context("robot states")?,
            detections: node.publisher().context("detections")?,
            goals: node.publisher().context("goals")?,
            status: node.publisher().context("source status")?,
            estimator: node.waker(ProcessId::Estimator).context("the estimator's wake-up")?,
            wake_up: node.wake_up().context("the bridge's wake-up")?,
            health: HealthReporter::new(node)?,
        })
    }

    fn publish(&mut self, event: &BridgeEvent) {
        let published_ns = RealClock.now_ns();
        let sent = match event {
            BridgeEvent::RobotState(message) => {
                let mut message = *message;
                message.stamp.published_ns = published_ns;
                self.robot_states.send(&message)
            }
            BridgeEvent::Detections(message) => {
                let mut message = *message;
                message.stamp.published_ns = published_ns;
                let sent = self.detections.send(&message);
                self.estimator.wake();
                sent
            }
            BridgeEvent::Goal(message) => {
                let mut message = *message;
                message.stamp.published_ns = published_ns;
                self.goals.send(&message)
            }
        };
        match sent {
            Ok(()) => self.health.accepted(1),
            Err(_) => self.health.error(Reason::PortFailed),
        }
    }

    /// Counts each time that the command sink begins to brake by itself, and returns why it does now.
    fn complain(&mut self, before: Option<Reason>, sink: Option<SinkState>) -> Option<Reason> {
        let now = match sink {
            Some(SinkState::Braking(reason)) => Some(reason),
            Some(SinkState::Waiting | SinkState::Following) | None => None,
        };
        if let (Some(reason), true) = (now, now != before) {
            tracing::warn!(%reason, "the command sink brakes by itself");
            self.health.error(reason);
        }
        now
    }

    /// Hands the goal, which is sent rarely, to a nominal controller that has just been started.
    fn serve_late_joiners(&mut self) {
        if self.goals.serve_late_joiners().is_err() {
            self.health.error(Reason::PortFailed);
        }
    }

    fn publish_status(&mut self, status: &SourceStatus) {
        if self.status.send(status).is_err() {
            self.health.error(Reason::PortFailed);
        }
    }
}
