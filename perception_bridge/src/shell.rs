//! Time and ports around a [`Source`].

use std::path::PathBuf;
use std::time::Duration;

use anyhow::Context;
use messages::{Detections, Goal, ProcessId, Reason, RobotState, SafeCommand, SourceStatus};
use node_runtime::{Clock, HealthReporter, Node, Publisher, RealClock, Shutdown, WakeUp};
use settings::Settings;

use crate::simulated_crowd::SimulatedCrowd;
use crate::source::{BridgeEvent, Source};

/// How often the source's status is published, ns.
const STATUS_PERIOD_NS: u64 = 100_000_000;
/// Longest sleep, so that a wish to stop is heard.
const LONGEST_WAIT_NS: u64 = 50_000_000;

/// Where the bridge takes the world from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SourceChoice {
    /// The simulated crowd of the settings.
    Simulation,
    /// A recording, played at its own pace.
    Mcap {
        /// The file.
        file: PathBuf,
        /// Whether a simulated robot that obeys the filter replaces the recorded one.
        closed_loop: bool,
    },
}

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
    while !shutdown.requested() {
        let woke_ns = RealClock.now_ns();
        if let Some(command) = commands.newest() {
            source.command(&command, woke_ns);
        }
        while let Some(event) = source.poll(RealClock.now_ns()) {
            ports.publish(event);
        }
        if woke_ns >= status_due_ns {
            status_due_ns = woke_ns + STATUS_PERIOD_NS;
            ports.publish_status(&source.status(woke_ns));
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

/// Opens the source that `choice` names.
fn open_source(settings: &Settings, choice: &SourceChoice) -> anyhow::Result<Box<dyn Source>> {
    Ok(match choice {
        SourceChoice::Simulation => Box::new(SimulatedCrowd::new(settings)?),
        SourceChoice::Mcap { .. } => anyhow::bail!("recordings"),
    })
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

    fn publish(&mut self, event: BridgeEvent) {
        let published_ns = RealClock.now_ns();
        let sent = match event {
            BridgeEvent::RobotState(mut message) => {
                message.stamp.published_ns = published_ns;
                self.robot_states.send(&message)
            }
            BridgeEvent::Detections(mut message) => {
                message.stamp.published_ns = published_ns;
                let sent = self.detections.send(&message);
                self.estimator.wake();
                sent
            }
            BridgeEvent::Goal(mut message) => {
                message.stamp.published_ns = published_ns;
                self.goals.send(&message)
            }
        };
        match sent {
            Ok(()) => self.health.accepted(1),
            Err(_) => self.health.error(Reason::PortFailed),
        }
    }

    fn publish_status(&mut self, status: &SourceStatus) {
        if self.status.send(status).is_err() {
            self.health.error(Reason::PortFailed);
        }
    }
}
