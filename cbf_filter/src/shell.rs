//! Time and ports around [`SafetyFilter::step`].

use std::time::Duration;

use anyhow::Context;
use messages::{NominalCommand, Obstacles, ProcessId, Reason, RobotState, SafeCommand, SafetyStatus};
use node_runtime::{Clock, CyclicTimer, HealthReporter, Node, RealClock, Shutdown};
use settings::Settings;

use crate::{Inputs, SafetyFilter, load_model};

/// Runs the filter of stack `instance` until told to stop.
///
/// # Errors
/// If the model cannot be used or a port cannot be opened; never once the loop runs.
pub fn run(settings: &Settings, instance: &str) -> anyhow::Result<()> {
    let model = load_model(&settings.filter.model)?;
    let mut filter = SafetyFilter::new(settings, &model)?;
    let shutdown = Shutdown::install()?;
    let node = Node::open(instance, ProcessId::Filter)?;
    let mut robot_states = node.subscriber::<RobotState>().context("robot states")?;
    let mut obstacle_lists = node.subscriber::<Obstacles>().context("obstacles")?;
    let mut nominal_commands = node.subscriber::<NominalCommand>().context("nominal commands")?;
    let safe_commands = node.publisher::<SafeCommand>().context("safe commands")?;
    let sink = node.waker(ProcessId::Bridge).context("the command sink's wake-up")?;
    let mut health = HealthReporter::new(&node)?;
    tracing::info!(kernel = %filter.kernel(), period_ms = settings.filter.period_ms, "filter runs");

    let (mut robot_state, mut obstacles, mut nominal) = (None, None, None);
    let mut timer = CyclicTimer::new(RealClock, Duration::from_millis(settings.filter.period_ms));
    while !shutdown.requested() {
        let tick = timer.wait();
        robot_state = robot_states.newest().or(robot_state);
        obstacles = obstacle_lists.newest().or(obstacles);
        nominal = nominal_commands.newest().or(nominal);
        let inputs = Inputs {
            robot_state: robot_state.as_ref(),
            obstacles: obstacles.as_ref(),
            nominal: nominal.as_ref(),
        };
        let mut command = filter.step(&inputs, tick);
        command.ledger.filter_published_ns = RealClock.now_ns();
        if safe_commands.send(&command).is_err() {
            health.error(Reason::PortFailed);
        }
        sink.wake();
        count(&command, &mut health);
        health.cycle(&tick);
        health.report(tick.woke_ns);
    }
    Ok(())
}

/// Counts a cycle whose inputs could not be used.
fn count(command: &SafeCommand, health: &mut HealthReporter) {
    let braking = [SafetyStatus::Braking.code(), SafetyStatus::Stopped.code()].contains(&command.status);
    match Reason::try_from(command.reason) {
        Ok(Reason::StopRequested | Reason::None | Reason::SlackNeeded) | Err(_) => health.accepted(1),
        Ok(reason) if braking => health.refused(reason),
        Ok(_) => {}
    }
}
