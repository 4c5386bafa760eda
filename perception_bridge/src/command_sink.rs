//! The last link before the motors: applies the newest safe command, or brakes when none comes. For a simulated robot whose filter
//! only watches it applies the nominal command instead.

use messages::{ControlKind, Reason, SafeCommand, SafetyStatus};
use settings::{RobotKind, Settings};

/// Filter periods of silence after which the sink brakes by itself.
const SILENT_PERIODS: u64 = 5;
const NS_PER_MS: u64 = 1_000_000;
const S_PER_NS: f64 = 1e-9;

/// Whether the sink follows the filter or brakes, and why.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SinkState {
    /// No command has come yet: the robot is kept standing.
    Waiting,
    /// The filter's newest command is applied.
    Following,
    /// The sink brakes by itself for this reason.
    Braking(Reason),
}

/// Whom a robot obeys.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Obedience {
    /// The filter: u*.
    Filter,
    /// The nominal controller, as if there were no filter: u_nom.
    Nominal,
}

/// Holds the newest usable command and knows when it has become too old. Pure: time is passed in.
#[derive(Debug, Clone)]
pub struct CommandSink {
    kind: ControlKind,
    obeys: Obedience,
    silence_ns: u64,
    deceleration_mps2: f64,
    /// When the inputs of the newest usable command were judged, stack clock, ns, and its control.
    newest: Option<(u64, [f64; 2])>,
    /// Why the newest message could not be used, if it could not.
    refused: Option<Reason>,
    refusals: u64,
    state: SinkState,
}

impl CommandSink {
    /// A sink for the robot and filter period of `settings` that obeys the filter.
    pub fn new(settings: &Settings) -> Self {
        Self::obeying(settings, Obedience::Filter)
    }

    /// The same for a robot that obeys `whom`.
    ///
    /// Who obeys the nominal controller does what that one wants, whatever the filter says; where the filter had no usable
    /// nominal command, the robot comes to a halt, and where the filter mistrusted something else, it goes on as it did.
    pub fn obeying(settings: &Settings, whom: Obedience) -> Self {
        Self {
            obeys: whom,
            kind: match settings.robot.kind {
                RobotKind::Unicycle => ControlKind::Unicycle,
                RobotKind::DoubleIntegrator => ControlKind::DoubleIntegrator,
            },
            silence_ns: SILENT_PERIODS * settings.filter.period_ms * NS_PER_MS,
            deceleration_mps2: settings.robot.brake_deceleration_mps2,
            newest: None,
            refused: None,
            refusals: 0,
            state: SinkState::Waiting,
        }
    }

    /// Takes a command that arrived at `now_ns`. Its age counts from when the filter's cycle began, the moment at which its
    /// inputs were judged: what waited in a queue while this process slept is old, and so is what a filter held up in the
    /// middle of its cycle made of inputs that have aged since. One that is not finite or for another robot is refused and
    /// counted; the robot then brakes until a good one comes.
    pub fn take(&mut self, command: &SafeCommand, now_ns: u64) {
        let finite = command.control.iter().all(|value| value.is_finite());
        self.refused = match (finite, ControlKind::try_from(command.control_kind)) {
            (true, Ok(kind)) if kind == self.kind => None,
            (true, Ok(_) | Err(_)) => Some(Reason::WrongControlKind),
            (false, _) => Some(Reason::MalformedInput),
        };
        match self.refused {
            None => {
                let judged_ns = command.ledger.filter_woke_ns.min(now_ns);
                self.newest = match self.obeys {
                    Obedience::Filter => Some((judged_ns, command.control)),
                    Obedience::Nominal => self.nominal(command).map(|control| (judged_ns, control)),
                };
            }
            Some(_) => self.refusals += 1,
        }
    }

    /// What the nominal controller wants, as the filter heard it; nothing where it wants a halt or said nothing usable.
    fn nominal(&self, command: &SafeCommand) -> Option<[f64; 2]> {
        match SafetyStatus::try_from(command.status) {
            Ok(SafetyStatus::Filtered | SafetyStatus::Relaxed) => Some(command.nominal),
            // The filter looks at obstacles last and does not tell u_nom then.
            Ok(SafetyStatus::Braking | SafetyStatus::Stopped)
                if Reason::try_from(command.reason).is_ok_and(has_good_nominal) =>
            {
                self.newest.map(|(_, control)| control)
            }
            Ok(SafetyStatus::Braking | SafetyStatus::Stopped) | Err(_) => None,
        }
    }

    /// The control to apply over the next `dt_ns` for a robot that moves with `velocity_mps` (`[forward, left]` in `base` for
    /// a unicycle, `[x, y]` in `odom` for a double integrator).
    pub fn control(&mut self, now_ns: u64, dt_ns: u64, velocity_mps: [f64; 2]) -> [f64; 2] {
        self.state = match (self.newest, self.refused) {
            (_, Some(reason)) => SinkState::Braking(reason),
            (None, None) => SinkState::Waiting,
            (Some((judged_ns, _)), None) if now_ns.saturating_sub(judged_ns) > self.silence_ns => {
                SinkState::Braking(Reason::SilentFilter)
            }
            (Some(_), None) => SinkState::Following,
        };
        match (self.state, self.newest) {
            (SinkState::Following, Some((_, control))) => control,
            (SinkState::Following | SinkState::Waiting | SinkState::Braking(_), _) => {
                self.brake(dt_ns as f64 * S_PER_NS, velocity_mps)
            }
        }
    }

    /// What the sink did when it was last asked.
    pub const fn state(&self) -> SinkState {
        self.state
    }

    /// Commands refused so far.
    pub const fn refusals(&self) -> u64 {
        self.refusals
    }

    /// Slows down along the present motion, not beyond a halt.
    fn brake(&self, dt_s: f64, velocity_mps: [f64; 2]) -> [f64; 2] {
        let speed = velocity_mps[0].hypot(velocity_mps[1]);
        if speed <= 0.0 || dt_s <= 0.0 {
            return [0.0; 2];
        }
        let slower = (speed - self.deceleration_mps2 * dt_s).max(0.0);
        match self.kind {
            ControlKind::Unicycle => [velocity_mps[0] * slower / speed, 0.0],
            ControlKind::DoubleIntegrator => velocity_mps.map(|v| (v * slower / speed - v) / dt_s),
        }
    }
}

/// Whether the nominal controller had spoken and could be believed where the filter brakes for `reason`.
const fn has_good_nominal(reason: Reason) -> bool {
    match reason {
        Reason::NoObstacles
        | Reason::SilentEstimator
        | Reason::StaleDetections
        | Reason::UnsoundObstacle
        | Reason::BackwardStamp
        | Reason::NonFiniteBarrier
        | Reason::SolverFailed => true,
        Reason::None
        | Reason::SlackNeeded
        | Reason::JointEscape
        | Reason::StopRequested
        | Reason::NoRobotState
        | Reason::StaleRobotState
        | Reason::NonFiniteRobotState
        | Reason::NoNominalCommand
        | Reason::StaleNominalCommand
        | Reason::NonFiniteNominalCommand
        | Reason::WrongControlKind
        | Reason::NoGoal
        | Reason::FutureStamp
        | Reason::ForeignClock
        | Reason::ClockJump
        | Reason::SilentFilter
        | Reason::MalformedInput
        | Reason::NoTransform
        | Reason::Duplicate
        | Reason::Teleport
        | Reason::CapacityExceeded
        | Reason::PortFailed => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    const MS: u64 = 1_000_000;

    fn sink() -> CommandSink {
        let text = include_str!("../../config/ground_robot.toml");
        CommandSink::new(&Settings::parse(text, "x".as_ref(), ".".as_ref()).expect("shipped settings"))
    }

    /// Of a cycle that began at `began_ns` and was over at once.
    fn command(control: [f64; 2], began_ns: u64) -> SafeCommand {
        let mut command =
            SafeCommand { control, control_kind: ControlKind::Unicycle.code(), ..SafeCommand::zeroed() };
        command.ledger.filter_woke_ns = began_ns;
        command.ledger.filter_published_ns = began_ns;
        command
    }

    #[test]
    fn a_command_that_waited_in_a_queue_is_as_old_as_it_is() {
        let mut sink = sink();
        sink.take(&command([0.7, 0.2], 100 * MS), 130 * MS);
        assert!(sink.control(131 * MS, 10 * MS, [0.7, 0.0])[0] < 0.7);
        assert_eq!(sink.state(), SinkState::Braking(Reason::SilentFilter));
    }

    #[test]
    fn a_command_is_as_old_as_what_it_rests_on_where_the_filter_was_held_up_in_its_cycle() {
        let mut sink = sink();
        let mut held_up = command([0.7, 0.2], 100 * MS);
        held_up.ledger.filter_published_ns = 130 * MS;
        sink.take(&held_up, 130 * MS);
        assert!(sink.control(131 * MS, 10 * MS, [0.7, 0.0])[0] < 0.7);
        assert_eq!(sink.state(), SinkState::Braking(Reason::SilentFilter));
    }

    #[test]
    fn a_fresh_command_is_applied_and_an_old_one_brakes() {
        let mut sink = sink();
        assert_eq!(sink.control(0, 10 * MS, [0.0; 2]), [0.0; 2]);
        assert_eq!(sink.state(), SinkState::Waiting);
        sink.take(&command([0.7, 0.2], 100 * MS), 100 * MS);
        assert_eq!(sink.control(120 * MS, 10 * MS, [0.7, 0.0]), [0.7, 0.2]);
        assert_eq!(sink.state(), SinkState::Following);
        let [speed, yaw_rate] = sink.control(121 * MS, 10 * MS, [0.7, 0.0]);
        assert!((speed - 0.685).abs() < 1e-12 && yaw_rate == 0.0, "{speed}");
        assert_eq!(sink.state(), SinkState::Braking(Reason::SilentFilter));
        sink.take(&command([0.5, 0.0], 130 * MS), 130 * MS);
        assert_eq!(sink.control(131 * MS, 10 * MS, [0.6, 0.0]), [0.5, 0.0]);
    }

    #[test]
    fn a_command_that_cannot_be_used_brakes_at_once() {
        let mut sink = sink();
        sink.take(&command([0.7, 0.2], 0), 0);
        sink.take(&command([f64::NAN, 0.0], MS), MS);
        let [speed, _] = sink.control(2 * MS, 10 * MS, [0.7, 0.0]);
        assert!(speed < 0.7 && sink.refusals() == 1);
        let mut foreign = command([0.7, 0.2], 3 * MS);
        foreign.control_kind = ControlKind::DoubleIntegrator.code();
        sink.take(&foreign, 3 * MS);
        sink.control(4 * MS, 10 * MS, [0.7, 0.0]);
        assert_eq!(sink.state(), SinkState::Braking(Reason::WrongControlKind));
    }

    #[test]
    fn who_obeys_the_nominal_controller_does_not_brake_for_the_filter() {
        let text = include_str!("../../config/ground_robot.toml");
        let settings = Settings::parse(text, "x".as_ref(), ".".as_ref()).expect("shipped settings");
        let mut sink = CommandSink::obeying(&settings, Obedience::Nominal);
        let told = |status: SafetyStatus, reason: Reason, nominal: [f64; 2], began_ns: u64| SafeCommand {
            status: status.code(),
            reason: reason.code(),
            nominal,
            ..command([0.25, 0.8], began_ns)
        };
        sink.take(&told(SafetyStatus::Filtered, Reason::None, [1.0, 0.1], MS), MS);
        assert_eq!(sink.control(2 * MS, 10 * MS, [1.0, 0.0]), [1.0, 0.1]);
        sink.take(&told(SafetyStatus::Braking, Reason::StaleDetections, [0.0; 2], 30 * MS), 30 * MS);
        assert_eq!(sink.control(31 * MS, 10 * MS, [1.0, 0.0]), [1.0, 0.1]);
        sink.take(&told(SafetyStatus::Braking, Reason::StopRequested, [0.0; 2], 40 * MS), 40 * MS);
        let [speed, yaw_rate] = sink.control(41 * MS, 10 * MS, [1.0, 0.0]);
        assert!((speed - 0.985).abs() < 1e-12 && yaw_rate == 0.0, "{speed}");
    }

    #[test]
    fn braking_ends_in_a_halt() {
        let mut sink = sink();
        sink.take(&command([1.0, 0.0], 0), 0);
        let mut speed = 1.0;
        for step in 0..100 {
            speed = sink.control((50 + 10 * step) * MS, 10 * MS, [speed, 0.0])[0];
        }
        assert_eq!(speed, 0.0);
    }
}
