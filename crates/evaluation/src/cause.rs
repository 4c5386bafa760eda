//! Why a contact came about, by exact definitions. `docs/evaluation.md` holds them in words.

use std::collections::BTreeMap;

use barrier::Model;
use bytemuck::Zeroable;
use cbf_filter::{FilterSetupError, SafetyFilter};
use messages::{
    ControlKind, Intent, NominalCommand, Obstacle, Obstacles, RobotState, SafeCommand, SafetyStatus,
};
use node_runtime::Tick;
use settings::{RobotKind, Settings};

use crate::virtual_stack::START_NS;
use crate::watched::{Contact, Watched};

/// Gaps of feasible cycles up to this long do not end a stretch of infeasible ones, ns.
const BRIDGED_GAP_NS: u64 = 100_000_000;
/// A stretch that ended longer than this before the contact has nothing to do with it, ns.
const LATEST_BEFORE_CONTACT_NS: u64 = 500_000_000;
/// How long before the stretch the touched person's motion counts, ns.
const LOOK_BACK_NS: u64 = 500_000_000;

/// Class of a contact's cause. The first that applies, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// Nobody filtered: the robot obeyed its nominal controller.
    NotFiltered,
    /// The touched person was never seen, or when it came into sight its own pairwise barrier was already negative.
    AppearedInside,
    /// The touched person left the modelled bounds in the half second before the method became infeasible, or between that
    /// and the contact.
    BoundsExceeded,
    /// When the method became infeasible, two people or more were in sight and each of them alone could have been avoided (each
    /// pairwise margin ≥ 0).
    BoxedIn,
    /// None of these: the method, its barrier, the estimator or the plant.
    FilterFault,
}

impl Cause {
    /// Every cause, in the order in which they are tried.
    pub const ALL: [Self; 5] =
        [Self::NotFiltered, Self::AppearedInside, Self::BoundsExceeded, Self::BoxedIn, Self::FilterFault];

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NotFiltered => "not_filtered",
            Self::AppearedInside => "appeared_inside",
            Self::BoundsExceeded => "bounds_exceeded",
            Self::BoxedIn => "boxed_in",
            Self::FilterFault => "filter_fault",
        }
    }
}

/// What was known at one moment.
struct Snapshot {
    now_ns: u64,
    robot_state: RobotState,
    obstacles: Obstacles,
}

/// How someone came into sight.
struct Appearance {
    now_ns: u64,
    robot_state: RobotState,
    obstacle: Obstacle,
    /// Cycle in which the person was last in sight.
    last_cycle: u64,
}

/// Follows a run closely enough to tell causes afterwards.
pub(crate) struct Investigator<'a> {
    settings: &'a Settings,
    model: &'a Model,
    filtered: bool,
    sensing_range_m: f64,
    cycle: u64,
    seen: BTreeMap<u64, Appearance>,
    /// Beginning of the newest stretch of infeasible cycles, and the last cycle of it, ns.
    onset: Option<(Box<Snapshot>, u64)>,
}

impl<'a> Investigator<'a> {
    /// One for runs under `settings`; without `filtered` every contact is [`Cause::NotFiltered`].
    pub(crate) fn new(settings: &'a Settings, model: &'a Model, filtered: bool) -> Self {
        Self {
            settings,
            model,
            filtered,
            sensing_range_m: settings.filter.sensing_range_m.unwrap_or(f64::INFINITY),
            cycle: 0,
            seen: BTreeMap::new(),
            onset: None,
        }
    }

    /// Notes one cycle with what it was computed from.
    pub(crate) fn note(
        &mut self,
        command: &SafeCommand,
        robot_state: Option<&RobotState>,
        obstacles: Option<&Obstacles>,
        now_ns: u64,
    ) {
        let (Some(robot_state), Some(obstacles), true) = (robot_state, obstacles, self.filtered) else {
            return;
        };
        self.cycle += 1;
        for obstacle in obstacles.as_slice() {
            if !self.in_range(robot_state, obstacle) {
                continue;
            }
            match self.seen.get_mut(&obstacle.track_id) {
                Some(known) if known.last_cycle + 1 == self.cycle => known.last_cycle = self.cycle,
                Some(_) | None => {
                    let appearance = Appearance {
                        now_ns,
                        robot_state: *robot_state,
                        obstacle: *obstacle,
                        last_cycle: self.cycle,
                    };
                    self.seen.insert(obstacle.track_id, appearance);
                }
            }
        }
        if is_infeasible(command) {
            match &mut self.onset {
                Some((_, last_ns)) if now_ns - *last_ns <= BRIDGED_GAP_NS => *last_ns = now_ns,
                onset => {
                    let snapshot = Snapshot { now_ns, robot_state: *robot_state, obstacles: *obstacles };
                    *onset = Some((Box::new(snapshot), now_ns));
                }
            }
        }
    }

    /// Why `contact`, which has just begun, came about.
    ///
    /// # Errors
    /// [`FilterSetupError`] if the filter that is asked about one person alone cannot be set up.
    pub(crate) fn cause(&self, contact: &Contact, watched: &Watched) -> Result<Cause, FilterSetupError> {
        if !self.filtered {
            return Ok(Cause::NotFiltered);
        }
        if self.appeared_inside(contact.person_id)? {
            return Ok(Cause::AppearedInside);
        }
        let contact_ns = START_NS + contact.time_ns;
        let onset_ns = self.onset.as_ref().and_then(|(snapshot, last_ns)| {
            (contact_ns.saturating_sub(*last_ns) <= LATEST_BEFORE_CONTACT_NS).then_some(snapshot.now_ns)
        });
        let from_ns = onset_ns.unwrap_or(contact_ns).saturating_sub(START_NS).saturating_sub(LOOK_BACK_NS);
        if watched.left_bounds_between(contact.person_id, from_ns, contact.time_ns) {
            return Ok(Cause::BoundsExceeded);
        }
        if onset_ns.is_some() && self.several_and_each_alone_avoidable()? {
            return Ok(Cause::BoxedIn);
        }
        Ok(Cause::FilterFault)
    }

    /// Whether `person` was never in sight, or came into sight within its own unsafe set.
    fn appeared_inside(&self, person: u64) -> Result<bool, FilterSetupError> {
        let Some(Appearance { now_ns, robot_state, obstacle, .. }) = self.seen.get(&person) else {
            return Ok(true);
        };
        let alone = self.alone(obstacle, robot_state, *now_ns)?;
        Ok(alone.is_some_and(|command| command.h_m < 0.0))
    }

    /// Whether at the onset there were several people in sight and every single one left some admissible control. A method
    /// that gives up in front of one person who could have been avoided was not boxed in.
    fn several_and_each_alone_avoidable(&self) -> Result<bool, FilterSetupError> {
        let Some((snapshot, _)) = &self.onset else { return Ok(false) };
        let Snapshot { now_ns, robot_state, obstacles } = &**snapshot;
        let in_sight = || obstacles.as_slice().iter().filter(|obstacle| self.in_range(robot_state, obstacle));
        if in_sight().count() < 2 {
            return Ok(false);
        }
        for obstacle in in_sight() {
            let alone = self.alone(obstacle, robot_state, *now_ns)?;
            if !alone.is_some_and(|command| command.hard_margin_mps >= 0.0) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// What a fresh look of the CN-CBF filter says about one obstacle alone. h̄ and margin do not depend on u_nom.
    fn alone(
        &self,
        obstacle: &Obstacle,
        robot_state: &RobotState,
        now_ns: u64,
    ) -> Result<Option<SafeCommand>, FilterSetupError> {
        let control_kind = match self.settings.robot.kind {
            RobotKind::Unicycle => ControlKind::Unicycle,
            RobotKind::DoubleIntegrator => ControlKind::DoubleIntegrator,
        };
        let mut probe = SafetyFilter::new(self.settings, self.model)?;
        let mut obstacles = Obstacles { count: 1, ..Obstacles::zeroed() };
        obstacles.items[0] = *obstacle;
        obstacles.stamp = robot_state.stamp;
        obstacles.stamp.valid_at_ns = now_ns;
        obstacles.stamp.ingress_ns = now_ns;
        obstacles.stamp.published_ns = now_ns;
        let mut nominal = NominalCommand {
            control_kind: control_kind.code(),
            intent: Intent::Drive.code(),
            ..NominalCommand::zeroed()
        };
        nominal.stamp = obstacles.stamp;
        let mut state = *robot_state;
        state.stamp.published_ns = now_ns;
        let inputs = cbf_filter::Inputs {
            robot_state: Some(&state),
            obstacles: Some(&obstacles),
            nominal: Some(&nominal),
            goal: None,
        };
        let command = probe.step(&inputs, Tick::event(now_ns));
        let corrected = matches!(
            SafetyStatus::try_from(command.status),
            Ok(SafetyStatus::Filtered | SafetyStatus::Relaxed)
        );
        Ok(corrected.then_some(command))
    }

    fn in_range(&self, robot_state: &RobotState, obstacle: &Obstacle) -> bool {
        let [x, y] = obstacle.position_in_odom_m;
        let [robot_x, robot_y] = robot_state.position_in_odom_m;
        (x - robot_x).hypot(y - robot_y) <= self.sensing_range_m
    }
}

/// Whether the method found no control that meets its demands.
fn is_infeasible(command: &SafeCommand) -> bool {
    match SafetyStatus::try_from(command.status) {
        Ok(SafetyStatus::Relaxed) => true,
        Ok(SafetyStatus::Filtered) => command.hard_margin_mps < 0.0,
        Ok(SafetyStatus::Braking | SafetyStatus::Stopped) | Err(_) => false,
    }
}
