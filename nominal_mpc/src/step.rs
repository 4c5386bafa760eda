//! One cycle of the nominal controller: from the newest robot state and goal to one command, or to silence.

use messages::{ControlKind, Controller, Goal, Intent, NominalCommand, RobotState, Stamp};
use settings::{ControllerKind, RobotKind, Settings};

use crate::lqr_drive::LqrDrive;
use crate::mpc_drive::MpcDrive;
use crate::pure_pursuit_drive::PurePursuitDrive;
use crate::{NominalSetupError, Silence};

const NS_PER_MS: u64 = 1_000_000;
/// A robot that has reached its goal drives on only when it is farther away than this many tolerances: it may
/// overshoot while it brakes, and noise must not make it start again.
const RELEASE_TOLERANCES: f64 = 2.0;

/// The newest message of each kind; `None` where none has arrived yet.
#[derive(Debug, Clone, Copy, Default)]
pub struct Inputs<'a> {
    /// Where the robot is.
    pub robot_state: Option<&'a RobotState>,
    /// When that state was taken from its port, stack clock, ns.
    pub robot_state_received_ns: u64,
    /// Where it shall go.
    pub goal: Option<&'a Goal>,
}

enum Drive {
    Mpc(Box<MpcDrive>),
    Lqr(LqrDrive),
    PurePursuit(PurePursuitDrive),
    Hold,
}

/// The nominal controller: constructed once, stepped once per period. See [`NominalController::step`].
pub struct NominalController {
    drive: Drive,
    control_kind: ControlKind,
    max_state_age_ns: u64,
    goal_tolerance_m: f64,
    /// The goal that was reached, `[x_m, y_m, heading_rad]` in `odom`.
    reached: Option<[f64; 3]>,
    sequence: u64,
}

impl NominalController {
    /// Sets up the controller that `settings.nominal.controller` names.
    ///
    /// # Errors
    /// [`NominalSetupError`] if its weights or bounds make no controller.
    pub fn new(settings: &Settings) -> Result<Self, NominalSetupError> {
        let nominal = &settings.nominal;
        let drive = match nominal.controller {
            ControllerKind::Mpc => Drive::Mpc(Box::new(MpcDrive::new(&nominal.mpc, &settings.robot)?)),
            ControllerKind::Lqr => Drive::Lqr(LqrDrive::new(&nominal.lqr)?),
            ControllerKind::PurePursuit => {
                let pursuit = nominal.pure_pursuit.as_ref().ok_or(NominalSetupError::NoPurePursuit)?;
                Drive::PurePursuit(PurePursuitDrive::new(pursuit, &settings.robot))
            }
            ControllerKind::Hold => Drive::Hold,
            ControllerKind::External => return Err(NominalSetupError::External),
        };
        Ok(Self {
            drive,
            control_kind: match settings.robot.kind {
                RobotKind::Unicycle => ControlKind::Unicycle,
                RobotKind::DoubleIntegrator => ControlKind::DoubleIntegrator,
            },
            max_state_age_ns: nominal.max_state_age_ms * NS_PER_MS,
            goal_tolerance_m: nominal.goal_tolerance_m,
            reached: None,
            sequence: 0,
        })
    }

    /// Runs one cycle at `now_ns`, stack clock.
    ///
    /// Within `goal_tolerance_m` of the goal the command asks for a stop, and goes on doing so until the goal changes
    /// or the robot is twice as far away. `hold` always asks for a stop and needs no goal. The command is stamped as
    /// published at `now_ns`; a sender that hands it over later stamps it anew.
    ///
    /// Goals may lie far beyond the horizon: the MPC takes the goal pose itself as its reference, as the paper does,
    /// and then drives towards it at full speed. Its plan starts at the robot state's own time.
    ///
    /// Allocates nothing itself; with `mpc` Clarabel allocates once for each QP it solves.
    ///
    /// # Errors
    /// [`Silence`] where no command can be answered for. Nothing is to be sent then: the filter brakes on silence.
    pub fn step(&mut self, inputs: &Inputs<'_>, now_ns: u64) -> Result<NominalCommand, Silence> {
        let state = self.fresh(inputs.robot_state, now_ns)?;
        let (intent, control, effort) = self.decide(state, inputs.goal)?;
        self.sequence += 1;
        Ok(NominalCommand {
            stamp: Stamp { sequence: self.sequence, published_ns: now_ns, ..state.stamp },
            bridge_published_ns: state.stamp.published_ns,
            received_ns: inputs.robot_state_received_ns,
            control,
            control_kind: self.control_kind.code(),
            intent: intent.code(),
            controller: self.controller().code(),
            effort,
        })
    }

    /// Which controller this is.
    pub const fn controller(&self) -> Controller {
        match &self.drive {
            Drive::Mpc(_) => Controller::Mpc,
            Drive::Lqr(_) => Controller::Lqr,
            Drive::PurePursuit(_) => Controller::PurePursuit,
            Drive::Hold => Controller::Hold,
        }
    }

    fn fresh<'a>(&self, state: Option<&'a RobotState>, now_ns: u64) -> Result<&'a RobotState, Silence> {
        let state = state.ok_or(Silence::NoRobotState)?;
        if !state.is_finite() {
            return Err(Silence::NonFiniteRobotState);
        }
        if state.stamp.valid_at_ns > now_ns.saturating_add(self.max_state_age_ns) {
            return Err(Silence::FutureRobotState);
        }
        if state.stamp.age_ns(now_ns) > self.max_state_age_ns {
            return Err(Silence::StaleRobotState);
        }
        Ok(state)
    }

    fn decide(
        &mut self,
        state: &RobotState,
        goal: Option<&Goal>,
    ) -> Result<(Intent, [f64; 2], u32), Silence> {
        const STOP: (Intent, [f64; 2], u32) = (Intent::Stop, [0.0; 2], 0);
        if matches!(self.drive, Drive::Hold) {
            return Ok(STOP);
        }
        let goal = goal.ok_or(Silence::NoGoal)?;
        if !goal.is_finite() {
            return Err(Silence::NonFiniteGoal);
        }
        let arrived = self.has_arrived(state, goal);
        let [x, y] = state.position_in_odom_m;
        let [goal_x, goal_y] = goal.position_in_odom_m;
        match &mut self.drive {
            Drive::Mpc(mpc) if arrived => {
                mpc.reset();
                Ok(STOP)
            }
            Drive::Mpc(mpc) => {
                let pose = [x, y, state.heading_rad];
                let target = [goal_x, goal_y, goal.heading_rad];
                let (control, iterations) = mpc.control(&pose, &target, state.stamp.valid_at_ns)?;
                Ok((Intent::Drive, control, iterations))
            }
            Drive::Lqr(_) | Drive::PurePursuit(_) if arrived => Ok(STOP),
            Drive::Lqr(lqr) => {
                let control = lqr.control([x, y], state.velocity_in_odom_mps(), [goal_x, goal_y]);
                Ok((Intent::Drive, control, 1))
            }
            Drive::PurePursuit(pursuit) => {
                let control = pursuit.control(&[x, y, state.heading_rad], [goal_x, goal_y]);
                Ok((Intent::Drive, control, 1))
            }
            Drive::Hold => Ok(STOP),
        }
    }

    /// Whether the robot is at its goal, or still counts as being there.
    fn has_arrived(&mut self, state: &RobotState, goal: &Goal) -> bool {
        let [x, y] = state.position_in_odom_m;
        let [goal_x, goal_y] = goal.position_in_odom_m;
        let target = [goal_x, goal_y, goal.heading_rad];
        let tolerances = if self.reached == Some(target) { RELEASE_TOLERANCES } else { 1.0 };
        let arrived = (x - goal_x).hypot(y - goal_y) <= tolerances * self.goal_tolerance_m;
        self.reached = arrived.then_some(target);
        arrived
    }
}
