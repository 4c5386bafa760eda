//! The filter's place in the virtual stack, taken by another method: holds its control between its own due times and writes
//! what it says as the filter would.

use baselines::{Inputs, Method, MethodOutput, Verdict};
use bytemuck::Zeroable;
use messages::{ControlKind, Goal, Reason, SafeCommand, SafetyStatus};
use settings::{RobotKind, Settings};

use crate::stopwatch::Stopwatch;

/// A method with its rate.
pub(crate) struct Seat {
    method: Box<dyn Method>,
    corrects_nominal: bool,
    control_kind: ControlKind,
    period_ns: u64,
    due_ns: u64,
    held: Option<MethodOutput>,
    sequence: u64,
}

impl Seat {
    /// `method`, stepped every `period_ns`. A planner corrects no nominal command, so that no nominal controller runs beside it.
    pub(crate) fn new(
        settings: &Settings,
        method: Box<dyn Method>,
        corrects_nominal: bool,
        period_ns: u64,
    ) -> Self {
        Self {
            method,
            corrects_nominal,
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
    pub(crate) const fn needs_nominal(&self) -> bool {
        self.corrects_nominal
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
            let inputs = Inputs {
                robot_state: inputs.robot_state,
                obstacles: inputs.obstacles,
                goal,
                nominal: inputs.nominal,
            };
            let method = &mut self.method;
            self.held = stopwatch.tick(|| method.step(&inputs, now_ns)).ok();
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
            let (status, reason) = match held.verdict {
                // The verdict knows the method's own tolerance; a slack within it is no failure.
                Verdict::Feasible => (SafetyStatus::Filtered, Reason::None),
                Verdict::IterationLimit | Verdict::Infeasible | Verdict::SolverFailed => {
                    (SafetyStatus::Relaxed, Reason::SlackNeeded)
                }
            };
            command.status = status.code();
            command.reason = reason.code();
            command.control = held.control;
            command.nominal = inputs.nominal.map_or(held.control, |nominal| nominal.control);
            command.slack_mps = held.slack;
            command.hard_margin_mps = held.hard_feasibility_margin;
            command.obstacle_count = held.obstacle_count;
        }
        command
    }
}
