//! Four steps on one clock.

use barrier::{Kernel, Model};
use cbf_filter::{FilterSetupError, SafetyFilter};
use messages::{Goal, NominalCommand, Obstacles, RobotState, SafeCommand, SourceStatus};
use node_runtime::{Pacing, Tick};
use nominal_mpc::{NominalController, NominalSetupError};
use obstacle_estimator::Estimator;
use perception_bridge::{BridgeEvent, Source};
use recording::WireMessage;
use settings::Settings;

use crate::seat::Seat;
use crate::stopwatch::Stopwatch;

const NS_PER_MS: u64 = 1_000_000;

/// Virtual time at which every run begins, ns; not zero, which means "never" in a stamp.
pub const START_NS: u64 = 1_000_000_000;

/// Why a virtual stack cannot be built.
#[derive(Debug, thiserror::Error)]
pub enum SetupError {
    /// The filter refuses the settings or the model.
    #[error(transparent)]
    Filter(#[from] FilterSetupError),
    /// The nominal controller refuses the settings.
    #[error(transparent)]
    Nominal(#[from] NominalSetupError),
}

/// What answers at the filter's ticks.
enum Corrector {
    Filter(Box<SafetyFilter>),
    Method(Box<Seat>),
}

/// Bridge, estimator, nominal controller and filter in lockstep.
///
/// Hand-over takes no time: a message is used in the very instant it is made. At one instant the order is bridge,
/// estimator, nominal controller, filter.
pub struct VirtualStack<S: Source + ?Sized = dyn Source> {
    source: Box<S>,
    estimator: Estimator,
    nominal: NominalController,
    corrector: Corrector,
    kernel: Kernel,
    stopwatch: Stopwatch,
    heartbeat_ns: u64,
    nominal_period_ns: u64,
    heartbeat_due_ns: u64,
    nominal_due_ns: u64,
    filter_pacing: Pacing,
    /// When the newest filter cycle ran, ns.
    filter_ran_ns: u64,
    robot_state: Option<RobotState>,
    goal: Option<Goal>,
    obstacles: Option<Obstacles>,
    nominal_command: Option<NominalCommand>,
}

impl<S: Source + ?Sized> VirtualStack<S> {
    /// Sets up the stack of `settings` on `source`, with virtual time at [`START_NS`].
    ///
    /// # Errors
    /// [`SetupError`] if a process refuses its settings.
    pub fn new(settings: &Settings, model: &Model, source: Box<S>) -> Result<Self, SetupError> {
        let filter = SafetyFilter::new(settings, model)?;
        Self::with(settings, source, filter.kernel(), Corrector::Filter(Box::new(filter)))
    }

    /// The same with a method in the filter's place. It is stepped at the first of the filter's ticks at or after each of
    /// its own due times; between them its last control is held.
    ///
    /// # Errors
    /// [`SetupError`] if the nominal controller refuses its settings.
    pub(crate) fn with_method(settings: &Settings, source: Box<S>, seat: Seat) -> Result<Self, SetupError> {
        let kernel = cbf_filter::chosen_kernel(settings.filter.kernel);
        Self::with(settings, source, kernel, Corrector::Method(Box::new(seat)))
    }

    fn with(
        settings: &Settings,
        source: Box<S>,
        kernel: Kernel,
        corrector: Corrector,
    ) -> Result<Self, SetupError> {
        Ok(Self {
            source,
            estimator: Estimator::new(settings.estimator.clone()),
            nominal: NominalController::new(settings)?,
            corrector,
            kernel,
            stopwatch: Stopwatch::stopped(),
            heartbeat_ns: settings.estimator.heartbeat_ms * NS_PER_MS,
            nominal_period_ns: settings.nominal.period_ms * NS_PER_MS,
            heartbeat_due_ns: START_NS,
            nominal_due_ns: START_NS,
            filter_pacing: cbf_filter::shell::pacing(&settings.filter, START_NS),
            filter_ran_ns: START_NS,
            robot_state: None,
            goal: None,
            obstacles: None,
            nominal_command: None,
        })
    }

    /// Advances to the end of the next filter cycle, tells `observe` every message with its time, ns, and returns the
    /// cycle's command; nothing once the source has ended.
    pub fn cycle(&mut self, observe: &mut dyn FnMut(u64, WireMessage)) -> Option<SafeCommand> {
        self.source.next_due_ns()?;
        loop {
            let source_due_ns = self.source.next_due_ns().unwrap_or(u64::MAX);
            let now_ns = source_due_ns
                .max(START_NS)
                .min(self.heartbeat_due_ns)
                .min(self.nominal_due_ns)
                .min(self.filter_pacing.next_due_ns());
            let new_obstacles = self.bridge(now_ns, observe);
            self.heartbeat(now_ns, observe);
            self.nominal(now_ns, observe);
            if let Some(tick) = self.filter_pacing.begin(now_ns, new_obstacles) {
                return Some(self.filter(tick, observe));
            }
        }
    }

    /// Progress and truth, as the source knows them at the last filter cycle.
    pub fn status(&self) -> SourceStatus {
        self.source.status(self.filter_ran_ns)
    }

    /// Evaluation kernel of the filter.
    pub const fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// The source.
    pub const fn source(&self) -> &S {
        &self.source
    }

    /// Newest robot state.
    pub const fn robot_state(&self) -> Option<&RobotState> {
        self.robot_state.as_ref()
    }

    /// Newest obstacles.
    pub const fn obstacles(&self) -> Option<&Obstacles> {
        self.obstacles.as_ref()
    }

    /// Has the steps of controller and filter timed by the machine's clock from now on. Changes nothing else.
    pub fn start_timing(&mut self) {
        self.stopwatch = Stopwatch::running();
    }

    /// How long steps took since [`Self::start_timing`].
    pub const fn stopwatch(&self) -> &Stopwatch {
        &self.stopwatch
    }

    /// Hands on what the source gives. Returns whether there were new obstacles among it.
    fn bridge(&mut self, now_ns: u64, observe: &mut dyn FnMut(u64, WireMessage)) -> bool {
        let mut new_obstacles = false;
        while let Some(event) = self.source.poll(now_ns) {
            match event {
                BridgeEvent::RobotState(mut state) => {
                    state.stamp.published_ns = now_ns;
                    self.robot_state = Some(state);
                    observe(now_ns, state.into());
                }
                BridgeEvent::Detections(mut frame) => {
                    frame.stamp.published_ns = now_ns;
                    observe(now_ns, frame.into());
                    let obstacles = *self.estimator.step(&frame, now_ns);
                    self.publish(obstacles, now_ns, observe);
                    new_obstacles = true;
                }
                BridgeEvent::Goal(mut goal) => {
                    goal.stamp.published_ns = now_ns;
                    self.goal = Some(goal);
                    observe(now_ns, goal.into());
                }
                // Only a live robot's own controller gives these; its place is taken by the one of the settings here.
                BridgeEvent::NominalCommand(_) => {}
            }
        }
        new_obstacles
    }

    fn heartbeat(&mut self, now_ns: u64, observe: &mut dyn FnMut(u64, WireMessage)) {
        if now_ns >= self.heartbeat_due_ns {
            let obstacles = *self.estimator.heartbeat(now_ns);
            self.publish(obstacles, now_ns, observe);
        }
    }

    fn publish(&mut self, mut obstacles: Obstacles, now_ns: u64, observe: &mut dyn FnMut(u64, WireMessage)) {
        obstacles.stamp.published_ns = now_ns;
        self.obstacles = Some(obstacles);
        self.heartbeat_due_ns = now_ns + self.heartbeat_ns;
        observe(now_ns, obstacles.into());
    }

    fn nominal(&mut self, now_ns: u64, observe: &mut dyn FnMut(u64, WireMessage)) {
        if now_ns < self.nominal_due_ns {
            return;
        }
        self.nominal_due_ns += self.nominal_period_ns;
        if matches!(&self.corrector, Corrector::Method(seat) if !seat.needs_nominal()) {
            return;
        }
        let inputs = nominal_mpc::Inputs {
            robot_state: self.robot_state.as_ref(),
            robot_state_received_ns: now_ns,
            goal: self.goal.as_ref(),
        };
        // Silence is the controller's answer where it has none; the filter notices it by the age of the last command.
        let nominal = &mut self.nominal;
        if let Ok(command) = self.stopwatch.nominal(|| nominal.step(&inputs, now_ns)) {
            self.nominal_command = Some(command);
            observe(now_ns, command.into());
        }
    }

    fn filter(&mut self, tick: Tick, observe: &mut dyn FnMut(u64, WireMessage)) -> SafeCommand {
        let now_ns = tick.woke_ns;
        self.filter_ran_ns = now_ns;
        let inputs = cbf_filter::Inputs {
            robot_state: self.robot_state.as_ref(),
            obstacles: self.obstacles.as_ref(),
            nominal: self.nominal_command.as_ref(),
            goal: self.goal.as_ref(),
        };
        let (mut command, obeyed) = match &mut self.corrector {
            Corrector::Filter(filter) => (self.stopwatch.tick(|| filter.step(&inputs, tick)), true),
            Corrector::Method(seat) => seat.step(&inputs, self.goal.as_ref(), now_ns, &mut self.stopwatch),
        };
        command.ledger.filter_woke_ns = now_ns;
        command.ledger.filter_computed_ns = now_ns;
        command.ledger.filter_published_ns = now_ns;
        if obeyed {
            self.source.command(&command, now_ns);
        }
        observe(now_ns, command.into());
        command
    }
}
