//! Time and ports around [`NominalController::step`].

use std::time::Duration;

use anyhow::Context;
use messages::{Goal, NominalCommand, ProcessId, Reason, RobotState};
use node_runtime::{Clock, CyclicTimer, HealthReporter, Node, RealClock, Shutdown};
use settings::Settings;

use crate::{Inputs, NominalController, Silence};

/// Runs the nominal controller of stack `instance` until told to stop.
///
/// A goal sent before this process started, or restarted, is heard when its sender sends again: senders repeat goals.
///
/// # Errors
/// If the controller cannot be set up or a port cannot be opened; never once the loop runs.
pub fn run(settings: &Settings, instance: &str) -> anyhow::Result<()> {
    let mut controller = NominalController::new(settings)?;
    let shutdown = Shutdown::install()?;
    let node = Node::open(instance, ProcessId::Nominal)?;
    let mut robot_states = node.subscriber::<RobotState>().context("robot states")?;
    let mut goals = node.subscriber::<Goal>().context("goals")?;
    let commands = node.publisher::<NominalCommand>().context("nominal commands")?;
    let mut health = HealthReporter::new(&node)?;
    let period_ms = settings.nominal.period_ms;
    tracing::info!(controller = %controller.controller(), period_ms, "nominal controller runs");

    let (mut robot_state, mut received_ns, mut goal) = (None, 0, None);
    let mut last_silence = None;
    let mut timer = CyclicTimer::new(RealClock, Duration::from_millis(period_ms));
    while !shutdown.requested() {
        let tick = timer.wait();
        if let Some(newer) = robot_states.newest() {
            (robot_state, received_ns) = (Some(newer), tick.woke_ns);
        }
        goal = goals.newest().or(goal);
        let inputs = Inputs {
            robot_state: robot_state.as_ref(),
            robot_state_received_ns: received_ns,
            goal: goal.as_ref(),
        };
        let silence = match controller.step(&inputs, tick.woke_ns) {
            Ok(mut command) => {
                command.stamp.published_ns = RealClock.now_ns();
                if commands.send(&command).is_err() {
                    health.error(Reason::PortFailed);
                }
                health.accepted(1);
                None
            }
            Err(silence) => {
                health.refused(silence.reason());
                Some(silence)
            }
        };
        tell_of_change(last_silence, silence);
        last_silence = silence;
        health.cycle(&tick);
        health.report(tick.woke_ns);
    }
    health.report_now(RealClock.now_ns());
    Ok(())
}

/// Logs once when silence begins, changes its reason, or ends.
fn tell_of_change(before: Option<Silence>, now: Option<Silence>) {
    match (before, now) {
        (before, now) if before == now => {}
        (_, Some(reason)) => tracing::warn!(%reason, "no nominal command"),
        (_, None) => tracing::info!("nominal commands flow again"),
    }
}
