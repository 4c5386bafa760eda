//! The filter's place in the virtual stack, taken by another method: holds its control between its own due times and writes
//! what it says as the filter would.

use bytemuck::Zeroable;
use messages::{ControlKind, Goal, Reason, SafeCommand, SafetyStatus};
use settings::{RobotKind, Settings};

use crate::stopwatch::Stopwatch;
use crate::whole_method::{MethodCommand, MethodInputs, WholeMethod};

/// A method with its rate.
pub(crate) struct Seat {
    method: Box<dyn WholeMethod>,
    control_kind: ControlKind,
    period_ns: u64,
    due_ns: u64,
    held: Option<MethodCommand>,
    sequence: u64,
}

impl Seat {
    pub(crate) fn new(settings: &Settings, method: Box<dyn WholeMethod>, period_ns: u64) -> Self {
        Self {
            method,
            control_kind: match settings.robot.kind {
                RobotKind::Unicycle => ControlKind::Unicycle,
                RobotKind::DoubleIntegrator => ControlKind::DoubleIntegrator,
            },
            period_ns,
            due_ns: 0,
            held: None,
            sequence: 0,
        }
    }

    /// Whether a nominal controller has to run beside the method.
    pub(crate) fn needs_nominal(&self) -> bool {
        self.method.corrects_nominal()
    }

    /// Steps the method where it is due, and says what the robot hears: the command, and whether it hears any. Where the
    /// method has no answer the robot hears nothing, hence brakes.
    pub(crate) fn step(
        &mut self,
        inputs: &cbf_filter::Inputs<'_>,
        goal: Option<&Goal>,
        now_ns: u64,
        stopwatch: &mut Stopwatch,
    ) -> (SafeCommand, bool) {
        if now_ns >= self.due_ns {
            self.due_ns = self.due_ns.max(now_ns - now_ns % self.period_ns.max(1)) + self.period_ns;
            let inputs = MethodInputs {
                robot_state: inputs.robot_state,
                obstacles: inputs.obstacles,
                goal,
                nominal: inputs.nominal,
            };
            let method = &mut self.method;
            self.held = stopwatch.tick(|| method.step(&inputs, now_ns));
        }
        self.sequence += 1;
        (self.told(inputs), self.held.is_some())
    }

    /// The held answer in the filter's words. A planner corrects nothing: its u_nom is u.
    fn told(&self, inputs: &cbf_filter::Inputs<'_>) -> SafeCommand {
        let mut command = SafeCommand {
            sequence: self.sequence,
            control_kind: self.control_kind.code(),
            status: SafetyStatus::Braking.code(),
            reason: Reason::MalformedInput.code(),
            h_m: f64::INFINITY,
            sdf_m: f64::INFINITY,
            critical_h_m: f64::INFINITY,
            hard_margin_mps: f64::INFINITY,
            ..SafeCommand::zeroed()
        };
        if let Some(held) = self.held {
            let (status, reason) = if held.feasible {
                (SafetyStatus::Filtered, Reason::None)
            } else {
                (SafetyStatus::Relaxed, Reason::SlackNeeded)
            };
            command.status = status.code();
            command.reason = reason.code();
            command.control = held.control;
            command.nominal = inputs.nominal.map_or(held.control, |nominal| nominal.control);
            command.slack_mps = held.slack;
            command.hard_margin_mps = held.hard_margin;
            command.obstacle_count = held.obstacle_count;
        }
        command
    }
}
