//! Time and ports around a [`crate::Source`].

use std::time::Duration;

use anyhow::Context;
use messages::{Detections, Goal, NominalCommand, ProcessId, Reason, RobotState, SafeCommand, SourceStatus};
use node_runtime::{
    Clock, HealthReporter, Node, Notices, Pacing, ProcessLoop, Publisher, RealClock, Shutdown, Subscriber,
    Tick, Waker, Work,
};
use settings::Settings;

use crate::command_sink::SinkState;
use crate::live::ZeroLevelOf;
use crate::source::{BridgeEvent, Source, open_source};

/// How often the source's status is published, ns.
const STATUS_PERIOD_NS: u64 = 100_000_000;
/// Events handed over in one cycle. What is left begins the next one at once, which takes commands and a wish to stop first: a
/// source that cannot keep up with the clock would otherwise give more in every cycle than in the one before.
const MOST_EVENTS: usize = 64;
/// Longest sleep, so that a wish to stop is heard.
const LONGEST_WAIT: Duration = Duration::from_millis(50);

pub use crate::source::SourceChoice;

/// Runs the bridge of stack `instance` until told to stop. A source that has ended keeps saying so.
///
/// It wakes when its source has something due, and at once when a command arrives. `zero_level` draws the barrier where the
/// source has somebody to show it to.
///
/// # Errors
/// If the source cannot be opened or a port not be opened; once the loop runs, only if the source has failed for good: whoever
/// started the bridge then starts it anew.
pub fn run(
    settings: &Settings,
    instance: &str,
    choice: &SourceChoice,
    zero_level: Option<ZeroLevelOf>,
) -> anyhow::Result<()> {
    let _span = tracing::error_span!("bridge", instance).entered();
    let shutdown = Shutdown::install()?;
    let node = Node::open(instance, ProcessId::Bridge)?;
    let mut source = open_source(settings, choice)?;
    source.wake_with(node.waker(ProcessId::Bridge).context("the bridge's own wake-up")?);
    source.serve(instance, zero_level);
    let mut process = BridgeProcess::open(source, &node)?;
    let wake_up = node.wake_up().context("the bridge's wake-up")?;
    let pacing = Pacing::event(RealClock.now_ns(), LONGEST_WAIT);
    let realtime = settings.realtime.as_ref().and_then(|realtime| realtime.bridge.as_ref());
    ProcessLoop::new(&node)?.run(&mut process, pacing, Some(wake_up), realtime, &shutdown);
    anyhow::ensure!(
        !process.is_over(),
        "a thread that hears or commands the robot has ended; its last words stand above"
    );
    Ok(())
}

/// The bridge with its source and ports.
pub struct BridgeProcess {
    source: Box<dyn Source>,
    commands: Subscriber<SafeCommand>,
    robot_states: Publisher<RobotState>,
    detections: Publisher<Detections>,
    goals: Publisher<Goal>,
    /// Only where the robot's own controller is the nominal one.
    nominal_commands: Option<Publisher<NominalCommand>>,
    /// When the newest robot state was published, ns.
    robot_published_ns: u64,
    status: Publisher<SourceStatus>,
    estimator: Waker,
    nominal: Waker,
    notices: Notices,
    status_due_ns: u64,
    /// Why the command sink brakes by itself; [`Reason::None`] while it does not.
    braking: Reason,
}

impl BridgeProcess {
    /// Opens the ports on `node` for what `source` gives.
    ///
    /// # Errors
    /// If one of them cannot be opened.
    pub fn open(source: Box<dyn Source>, node: &Node) -> anyhow::Result<Self> {
        let nominal_commands = source.gives_nominal_commands().then(|| node.publisher()).transpose();
        Ok(Self {
            source,
            commands: node.subscriber().context("safe commands")?,
            robot_states: node.publisher().context("robot states")?,
            detections: node.publisher().context("detections")?,
            goals: node.publisher().context("goals")?,
            nominal_commands: nominal_commands
                .context("nominal commands, which source.ros2.nominal_topic makes the bridge's own")?,
            robot_published_ns: 0,
            status: node.publisher().context("source status")?,
            estimator: node.waker(ProcessId::Estimator).context("the estimator's wake-up")?,
            nominal: node.waker(ProcessId::Nominal).context("the nominal controller's wake-up")?,
            notices: Notices::start(|reason| match reason {
                Reason::None => tracing::info!("the command sink follows the filter again"),
                reason => tracing::warn!(%reason, "the command sink brakes by itself"),
            }),
            status_due_ns: 0,
            braking: Reason::None,
        })
    }

    fn publish(&mut self, event: &BridgeEvent, health: &mut HealthReporter) {
        let published_ns = RealClock.now_ns();
        let sent = match event {
            BridgeEvent::RobotState(message) => {
                let mut message = *message;
                message.stamp.published_ns = published_ns;
                self.robot_published_ns = published_ns;
                let sent = self.robot_states.send(&message);
                self.nominal.wake();
                sent
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
            BridgeEvent::NominalCommand(message) => {
                let mut message = *message;
                message.stamp.published_ns = published_ns;
                message.bridge_published_ns = self.robot_published_ns;
                self.nominal_commands.as_mut().map_or(Ok(()), |port| port.send(&message))
            }
        };
        match sent {
            Ok(()) => health.accepted(1),
            Err(_) => health.error(Reason::PortFailed),
        }
    }

    /// Counts each time that the command sink begins to brake by itself, and posts what it does.
    fn watch_sink(&mut self, health: &mut HealthReporter) {
        let braking = match self.source.sink_state() {
            Some(SinkState::Braking(reason)) => reason,
            Some(SinkState::Waiting | SinkState::Following) | None => Reason::None,
        };
        if braking != self.braking && braking != Reason::None {
            health.error(braking);
        }
        self.notices.post(braking);
        self.braking = braking;
    }

    /// Tells how far the source is, and hands the goal, which is sent rarely, to a nominal controller that has just started.
    fn report(&mut self, now_ns: u64, health: &mut HealthReporter) {
        let sent = self.status.send(&self.source.status(now_ns));
        if sent.and(self.goals.serve_late_joiners()).is_err() {
            health.error(Reason::PortFailed);
        }
    }
}

impl Work for BridgeProcess {
    fn cycle(&mut self, tick: &Tick, health: &mut HealthReporter) {
        let now_ns = tick.woke_ns;
        if let Some(command) = self.commands.newest() {
            self.source.command(&command, now_ns);
        }
        for _ in 0..MOST_EVENTS {
            let Some(event) = self.source.poll(now_ns) else { break };
            self.publish(&event, health);
        }
        self.watch_sink(health);
        if now_ns >= self.status_due_ns {
            self.status_due_ns = now_ns + STATUS_PERIOD_NS;
            self.report(now_ns, health);
        }
    }

    fn next_due_ns(&self) -> Option<u64> {
        self.source.next_due_ns()
    }

    fn is_over(&self) -> bool {
        self.source.has_failed()
    }
}
