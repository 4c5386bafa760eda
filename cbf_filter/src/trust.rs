//! Which inputs may reach the barrier. Everything else becomes a [`Reason`].

use messages::{ControlKind, Intent, NominalCommand, Obstacles, Reason, RobotState};
use settings::FilterSettings;

use crate::Inputs;

const NS_PER_MS: u64 = 1_000_000;

/// Inputs that passed every check of this module.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Trusted<'a> {
    pub(crate) robot_state: &'a RobotState,
    pub(crate) obstacles: &'a Obstacles,
    pub(crate) nominal: &'a NominalCommand,
}

/// How old and how early an input may be, ns.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    robot_state_age_ns: u64,
    estimator_silence_ns: u64,
    detections_age_ns: u64,
    nominal_silence_ns: u64,
    future_ns: u64,
}

impl Limits {
    pub(crate) fn new(settings: &FilterSettings) -> Self {
        Self {
            robot_state_age_ns: settings.robot_state_max_age_ms * NS_PER_MS,
            estimator_silence_ns: settings.estimator_max_silence_ms * NS_PER_MS,
            detections_age_ns: settings.detections_max_age_ms * NS_PER_MS,
            nominal_silence_ns: settings.nominal_max_silence_ms * NS_PER_MS,
            future_ns: settings.future_tolerance_ms * NS_PER_MS,
        }
    }

    /// Checks all inputs at `now_ns`; the first thing found wrong is the reason.
    ///
    /// A wish to stop needs no barrier, so it is granted before obstacles are looked at.
    pub(crate) fn check<'a>(
        &self,
        inputs: &Inputs<'a>,
        expected: ControlKind,
        now_ns: u64,
    ) -> Result<Trusted<'a>, Reason> {
        let robot_state = self.robot_state(inputs.robot_state, now_ns)?;
        let nominal = self.nominal(inputs.nominal, expected, now_ns)?;
        let obstacles = self.obstacles(inputs.obstacles, now_ns)?;
        Ok(Trusted { robot_state, obstacles, nominal })
    }

    /// Whether `state` is recent enough to be believed at `now_ns`.
    pub(crate) fn is_fresh(&self, state: &RobotState, now_ns: u64) -> bool {
        self.robot_state(Some(state), now_ns).is_ok()
    }

    fn robot_state<'a>(&self, state: Option<&'a RobotState>, now_ns: u64) -> Result<&'a RobotState, Reason> {
        let state = state.ok_or(Reason::NoRobotState)?;
        if !state.is_finite() {
            return Err(Reason::NonFiniteRobotState);
        }
        self.not_from_the_future(state.stamp.valid_at_ns, now_ns)?;
        within(state.stamp.valid_at_ns, self.robot_state_age_ns, now_ns, Reason::StaleRobotState)?;
        Ok(state)
    }

    fn nominal<'a>(
        &self,
        command: Option<&'a NominalCommand>,
        expected: ControlKind,
        now_ns: u64,
    ) -> Result<&'a NominalCommand, Reason> {
        let command = command.ok_or(Reason::NoNominalCommand)?;
        if ControlKind::try_from(command.control_kind) != Ok(expected) {
            return Err(Reason::WrongControlKind);
        }
        if !command.control.iter().all(|value| value.is_finite()) {
            return Err(Reason::NonFiniteNominalCommand);
        }
        self.not_from_the_future(command.stamp.published_ns, now_ns)?;
        within(command.stamp.published_ns, self.nominal_silence_ns, now_ns, Reason::StaleNominalCommand)?;
        match Intent::try_from(command.intent) {
            Ok(Intent::Drive) => Ok(command),
            Ok(Intent::Stop) => Err(Reason::StopRequested),
            Err(_) => Err(Reason::WrongControlKind),
        }
    }

    fn obstacles<'a>(&self, obstacles: Option<&'a Obstacles>, now_ns: u64) -> Result<&'a Obstacles, Reason> {
        let obstacles = obstacles.ok_or(Reason::NoObstacles)?;
        let stamp = &obstacles.stamp;
        within(stamp.published_ns, self.estimator_silence_ns, now_ns, Reason::SilentEstimator)?;
        self.not_from_the_future(stamp.valid_at_ns, now_ns)?;
        within(stamp.valid_at_ns, self.detections_age_ns, now_ns, Reason::StaleDetections)?;
        for obstacle in obstacles.as_slice() {
            if !obstacle.is_sound() {
                return Err(Reason::UnsoundObstacle);
            }
            self.not_from_the_future(obstacle.valid_at_ns, now_ns)?;
            within(obstacle.valid_at_ns, self.detections_age_ns, now_ns, Reason::StaleDetections)?;
        }
        Ok(obstacles)
    }

    fn not_from_the_future(&self, stamp_ns: u64, now_ns: u64) -> Result<(), Reason> {
        if stamp_ns > now_ns.saturating_add(self.future_ns) { Err(Reason::FutureStamp) } else { Ok(()) }
    }
}

fn within(stamp_ns: u64, limit_ns: u64, now_ns: u64, otherwise: Reason) -> Result<(), Reason> {
    if now_ns.saturating_sub(stamp_ns) > limit_ns { Err(otherwise) } else { Ok(()) }
}
