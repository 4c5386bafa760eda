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
/// A goal sent before this process started, or restarted, is heard when its sender sends again: senders repeat goals.
///
/// # Errors
/// If the controller cannot be set up or a port cannot be opened; never once the loop runs.
pub fn run(settings: &Settings, instance: &str) -> anyhow::Result<()> {
    let _span = tracing::error_span!("nominal", instance).entered();
    let shutdown = Shutdown::install()?;
    let node = Node::open(instance, ProcessId::Nominal)?;
    let mut process = NominalProcess::open(settings, &node)?;
    let period_ms = settings.nominal.period_ms;
    tracing::info!(controller = %process.controller.controller(), period_ms, "nominal controller runs");
    let period = Duration::from_millis(period_ms);
    let pacing = Pacing::timer(RealClock.now_ns() + period_ms * 1_000_000, period);
    ProcessLoop::new(&node)?.run(
        &mut process,
        pacing,
        None,
        settings.realtime.as_ref().and_then(|realtime| realtime.nominal.as_ref()),
        &shutdown,
    );
    Ok(())
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
        Ok(Self {
            controller: NominalController::new(settings)?,
            robot_states: node.subscriber().context("robot states")?,
            goals: node.subscriber().context("goals")?,
            commands: node.publisher().context("nominal commands")?,
            notices: Notices::start(|reason| match reason {
                Reason::None => tracing::info!("nominal commands flow again"),
                reason => tracing::warn!(%reason, "no nominal command"),
            }),
            robot_state: None,
            received_ns: 0,
            goal: None,
        })
    }
}

impl Work for NominalProcess {
    fn cycle(&mut self, tick: &Tick, health: &mut HealthReporter) {
        if let Some(newer) = self.robot_states.newest() {
            (self.robot_state, self.received_ns) = (Some(newer), tick.woke_ns);
        }
        self.goal = self.goals.newest().or(self.goal);
        let inputs = Inputs {
            robot_state: self.robot_state.as_ref(),
            robot_state_received_ns: self.received_ns,
            goal: self.goal.as_ref(),
        };
        match self.controller.step(&inputs, tick.woke_ns) {
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
