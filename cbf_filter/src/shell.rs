//! Time and ports around [`SafetyFilter::step`].

use std::time::Duration;

use anyhow::Context;
use messages::{Goal, NominalCommand, Obstacles, ProcessId, Reason, RobotState, SafeCommand, SafetyStatus};
use node_runtime::{
    Clock, HealthReporter, Node, Pacing, ProcessLoop, Publisher, RealClock, Shutdown, Subscriber, Tick,
    UsageMeter, Waker, Work,
};
use settings::{FilterSettings, FilterTrigger, Settings};

use crate::{Inputs, SafetyFilter, load_model};

/// Runs the filter of stack `instance` until told to stop.
///
/// # Errors
/// If the model cannot be used or a port cannot be opened; never once the loop runs.
pub fn run(settings: &Settings, instance: &str) -> anyhow::Result<()> {
    let _span = tracing::error_span!("filter", instance).entered();
    let shutdown = Shutdown::install()?;
    let node = Node::open(instance, ProcessId::Filter)?;
    let mut process = FilterProcess::open(settings, &node)?;
    let pacing = pacing(&settings.filter, RealClock.now_ns());
    let wake_up = match settings.filter.trigger {
        FilterTrigger::Timer => None,
        FilterTrigger::Event | FilterTrigger::Both => Some(node.wake_up().context("the filter's wake-up")?),
    };
    let filter = &process.filter;
    tracing::info!(kernel = %filter.kernel(), period_ms = settings.filter.period_ms, "filter runs");
    ProcessLoop::new(&node)?.run(
        &mut process,
        pacing,
        wake_up,
        settings.realtime.as_ref().and_then(|realtime| realtime.filter.as_ref()),
        &shutdown,
    );
    Ok(())
}

/// When cycles begin for `settings`, the first one at `first_due_ns`.
pub fn pacing(settings: &FilterSettings, first_due_ns: u64) -> Pacing {
    let period = Duration::from_millis(settings.period_ms);
    match settings.trigger {
        FilterTrigger::Timer => Pacing::timer(first_due_ns, period),
        FilterTrigger::Event => Pacing::event(first_due_ns, period),
        FilterTrigger::Both => Pacing::both(first_due_ns, period),
    }
}

/// The filter with its ports.
pub struct FilterProcess {
    filter: SafetyFilter,
    robot_states: Subscriber<RobotState>,
    obstacle_lists: Subscriber<Obstacles>,
    nominal_commands: Subscriber<NominalCommand>,
    goals: Subscriber<Goal>,
    safe_commands: Publisher<SafeCommand>,
    sink: Waker,
    usage: UsageMeter,
    robot_state: Option<RobotState>,
    obstacles: Option<Obstacles>,
    nominal: Option<NominalCommand>,
    goal: Option<Goal>,
}

impl FilterProcess {
    /// Loads the model and opens the ports on `node`.
    ///
    /// # Errors
    /// If the model cannot be used or a port cannot be opened.
    pub fn open(settings: &Settings, node: &Node) -> anyhow::Result<Self> {
        let model = load_model(&settings.filter.model)?;
        Ok(Self {
            filter: SafetyFilter::new(settings, &model)?,
            robot_states: node.subscriber().context("robot states")?,
            obstacle_lists: node.subscriber().context("obstacles")?,
            nominal_commands: node.subscriber().context("nominal commands")?,
            goals: node.subscriber().context("goals")?,
            safe_commands: node.publisher().context("safe commands")?,
            sink: node.waker(ProcessId::Bridge).context("the command sink's wake-up")?,
            usage: UsageMeter::new(),
            robot_state: None,
            obstacles: None,
            nominal: None,
            goal: None,
        })
    }

    /// Completes the ledger with what only this side of the step knows.
    fn complete(&mut self, command: &mut SafeCommand) {
        let ledger = &mut command.ledger;
        ledger.filter_computed_ns = RealClock.now_ns();
        let usage = self.usage.since_last();
        ledger.minor_faults = usage.minor_faults;
        ledger.major_faults = usage.major_faults;
        ledger.voluntary_switches = usage.voluntary_switches;
        ledger.involuntary_switches = usage.involuntary_switches;
        ledger.filter_published_ns = RealClock.now_ns();
    }
}

impl Work for FilterProcess {
    fn cycle(&mut self, tick: &Tick, health: &mut HealthReporter) {
        self.robot_state = self.robot_states.newest().or(self.robot_state);
        self.obstacles = self.obstacle_lists.newest().or(self.obstacles);
        self.nominal = self.nominal_commands.newest().or(self.nominal);
        self.goal = self.goals.newest().or(self.goal);
        let inputs = Inputs {
            robot_state: self.robot_state.as_ref(),
            obstacles: self.obstacles.as_ref(),
            nominal: self.nominal.as_ref(),
            goal: self.goal.as_ref(),
        };
        let mut command = self.filter.step(&inputs, *tick);
        self.complete(&mut command);
        if self.safe_commands.send(&command).is_err() {
            health.error(Reason::PortFailed);
        }
        self.sink.wake();
        count(&command, health);
    }
}

/// Counts a cycle whose inputs could not be used.
fn count(command: &SafeCommand, health: &mut HealthReporter) {
    let braking = [SafetyStatus::Braking.code(), SafetyStatus::Stopped.code()].contains(&command.status);
    match Reason::try_from(command.reason) {
        Ok(Reason::StopRequested | Reason::None | Reason::SlackNeeded | Reason::JointEscape) | Err(_) => {
            health.accepted(1);
        }
        Ok(reason) if braking => health.refused(reason),
        Ok(_) => {}
    }
}
