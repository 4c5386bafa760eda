//! Time and ports around [`NominalController::step`].

use std::time::Duration;

use anyhow::Context;
use messages::{Goal, NominalCommand, ProcessId, Reason, RobotState};
use node_runtime::{
    Clock, HealthReporter, Node, Notices, Pacing, ProcessLoop, Publisher, RealClock, Shutdown, Subscriber,
    Tick, Work,
};
use settings::Settings;

use crate::{Inputs, NominalController};

/// Runs the nominal controller of stack `instance` until told to stop.
///
/// While somebody else commands, it waits, and takes over once that one has gone. The log and its health tell so.
///
/// A goal sent before this process started, or restarted, is heard when its sender sends again: senders repeat goals.
///
/// # Errors
/// If the controller cannot be set up or a port cannot be opened; never once the loop runs.
pub fn run(settings: &Settings, instance: &str) -> anyhow::Result<()> {
    let _span = tracing::error_span!("nominal", instance).entered();
    let shutdown = Shutdown::install()?;
    let node = Node::open(instance, ProcessId::Nominal)?;
    let mut cycles = ProcessLoop::new(&node)?;
    let began_ns = RealClock.now_ns();
    let mut wait = Wait { since_ns: began_ns, cycles: &mut cycles, is_said: false };
    let opened = NominalProcess::open_when_free(settings, &node, || {
        wait.tell(RealClock.now_ns());
        shutdown.requested()
    });
    let Some(mut process) = opened? else { return Ok(()) };
    let period_ms = settings.nominal.period_ms;
    tracing::info!(controller = %process.controller.controller(), period_ms, "nominal controller runs");
    let period = Duration::from_millis(period_ms);
    let now_ns = RealClock.now_ns();
    // Who has waited has heard the robot, and a robot that drives waits for it. Who has not gives the robot a period to speak.
    let waited = now_ns - began_ns > 2 * period_ms * NS_PER_MS;
    let pacing = Pacing::timer(if waited { now_ns } else { now_ns + period_ms * NS_PER_MS }, period);
    cycles.run(
        &mut process,
        pacing,
        None,
        settings.realtime.as_ref().and_then(|realtime| realtime.nominal.as_ref()),
        &shutdown,
    );
    Ok(())
}

const NS_PER_MS: u64 = 1_000_000;
/// Who waits for longer says so: a change of controllers takes less, ns.
const UNSAID_WAIT_NS: u64 = 200 * NS_PER_MS;

/// What is told while somebody else commands.
struct Wait<'a> {
    since_ns: u64,
    /// Says that the process lives and has had no cycle.
    cycles: &'a mut ProcessLoop,
    is_said: bool,
}

impl Wait<'_> {
    fn tell(&mut self, now_ns: u64) {
        if now_ns.saturating_sub(self.since_ns) < UNSAID_WAIT_NS {
            return;
        }
        if !self.is_said {
            self.is_said = true;
            tracing::warn!(
                "waits: another program has the nominal controller's place, and this one takes over when that ends \
                 (`iox2 node list` names it)"
            );
        }
        self.cycles.report(now_ns);
    }
}

/// The nominal controller with its ports.
pub struct NominalProcess {
    controller: NominalController,
    robot_states: Subscriber<RobotState>,
    goals: Subscriber<Goal>,
    commands: Publisher<NominalCommand>,
    notices: Notices,
    robot_state: Option<RobotState>,
    /// When `robot_state` was taken, stack clock, ns.
    received_ns: u64,
    goal: Option<Goal>,
}

impl NominalProcess {
    /// Sets up the controller and opens the ports on `node`.
    ///
    /// # Errors
    /// If the controller cannot be set up or a port cannot be opened.
    pub fn open(settings: &Settings, node: &Node) -> anyhow::Result<Self> {
        let ears = Ears::open(settings, node)?;
        Ok(ears.with(node.publisher().context("nominal commands")?))
    }

    /// The same, but waits for the place while somebody else commands, and asks `give_up` every few milliseconds whether to go on;
    /// `None` if not.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_when_free(
        settings: &Settings,
        node: &Node,
        give_up: impl FnMut() -> bool,
    ) -> anyhow::Result<Option<Self>> {
        let ears = Ears::open(settings, node)?;
        let commands = node.publisher_when_free(give_up).context("nominal commands")?;
        Ok(commands.map(|commands| ears.with(commands)))
    }
}

/// A controller that hears and cannot speak yet.
struct Ears {
    controller: NominalController,
    robot_states: Subscriber<RobotState>,
    goals: Subscriber<Goal>,
}

impl Ears {
    fn open(settings: &Settings, node: &Node) -> anyhow::Result<Self> {
        Ok(Self {
            controller: NominalController::new(settings)?,
            robot_states: node.subscriber().context("robot states")?,
            goals: node.subscriber().context("goals")?,
        })
    }

    fn with(self, commands: Publisher<NominalCommand>) -> NominalProcess {
        NominalProcess {
            controller: self.controller,
            robot_states: self.robot_states,
            goals: self.goals,
            commands,
            notices: Notices::start(|reason| match reason {
                Reason::None => tracing::info!("nominal commands flow again"),
                reason => tracing::warn!(%reason, "no nominal command"),
            }),
            robot_state: None,
            received_ns: 0,
            goal: None,
        }
    }
}

impl Work for NominalProcess {
    fn cycle(&mut self, _: &Tick, health: &mut HealthReporter) {
        let newer = self.robot_states.newest();
        self.goal = self.goals.newest().or(self.goal);
        // Not when the cycle began: a state that came while the process was held up since then would be from the future.
        let now_ns = RealClock.now_ns();
        if newer.is_some() {
            (self.robot_state, self.received_ns) = (newer, now_ns);
        }
        let inputs = Inputs {
            robot_state: self.robot_state.as_ref(),
            robot_state_received_ns: self.received_ns,
            goal: self.goal.as_ref(),
        };
        match self.controller.step(&inputs, now_ns) {
            Ok(mut command) => {
                command.stamp.published_ns = RealClock.now_ns();
                if self.commands.send(&command).is_err() {
                    health.error(Reason::PortFailed);
                }
                health.accepted(1);
                self.notices.post(Reason::None);
            }
            Err(silence) => {
                health.refused(silence.reason());
                self.notices.post(silence.reason());
            }
        }
    }
}
