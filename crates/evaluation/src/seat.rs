//! The filter's place in the virtual stack, taken by another method: holds its control between its own due times and writes
//! what it says as the filter would.

use baselines::{Inputs, Method, MethodOutput};
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
            // The method knows its own tolerance; a slack within it is no failure, nor is a search that ended early with a plan
            // that meets every demand.
            let (status, reason) = if held.demands_met {
                (SafetyStatus::Filtered, Reason::None)
            } else {
                (SafetyStatus::Relaxed, Reason::SlackNeeded)
            };
            command.status = status.code();
            command.reason = reason.code();
            command.control = held.control;
            command.nominal = inputs.nominal.map_or(held.control, |nominal| nominal.control);
            command.slack_mps = held.slack;
            // A margin below zero means that the demands could not be met; a tolerated one was met.
            command.hard_margin_mps = if held.demands_met {
                held.hard_feasibility_margin.max(0.0)
            } else {
                held.hard_feasibility_margin
            };
            command.obstacle_count = held.obstacle_count;
        }
        command
    }
}

#[cfg(test)]
mod tests {
    use baselines::{NoControl, Verdict};

    use super::*;
    use crate::variant::{Robot, Variant};

    /// Says the same at every step.
    struct Fixed(MethodOutput);

    impl Method for Fixed {
        fn step(&mut self, _: &Inputs<'_>, _: u64) -> Result<MethodOutput, NoControl> {
            Ok(self.0)
        }

        fn reset(&mut self) {}
    }

    /// What the robot's log says of a planner that ended so.
    fn told(verdict: Verdict, demands_met: bool, margin: f64) -> SafeCommand {
        let variant = Variant::named(Robot::Ground, "no_filter", &[]).expect("a method of the tables");
        let output = MethodOutput {
            control: [0.5, 0.0],
            verdict,
            demands_met,
            slack: (-margin).max(0.0),
            hard_feasibility_margin: margin,
            cost: 1.0,
            iterations: 1,
            obstacle_count: 1,
        };
        let mut seat = Seat::new(variant.settings(), Box::new(Fixed(output)), false, 50_000_000);
        let inputs = cbf_filter::Inputs::default();
        let (command, heard) = seat.step(&inputs, None, 0, &mut Stopwatch::stopped());
        assert!(heard);
        command
    }

    #[test]
    fn a_search_that_ended_early_is_judged_by_its_plan() {
        let met = told(Verdict::IterationLimit, true, 0.2);
        assert_eq!((met.status, met.reason), (SafetyStatus::Filtered.code(), Reason::None.code()));
        let missed = told(Verdict::IterationLimit, false, -0.2);
        assert_eq!(
            (missed.status, missed.reason),
            (SafetyStatus::Relaxed.code(), Reason::SlackNeeded.code())
        );
        assert_eq!((missed.slack_mps, missed.hard_margin_mps), (0.2, -0.2));
    }

    #[test]
    fn what_the_method_tolerates_is_no_missed_demand() {
        let tolerated = told(Verdict::Feasible, true, -1e-5);
        assert_eq!(tolerated.status, SafetyStatus::Filtered.code());
        assert!(tolerated.hard_margin_mps >= 0.0 && tolerated.slack_mps == 1e-5, "{tolerated:?}");
        assert_eq!(told(Verdict::SolverFailed, false, 0.3).status, SafetyStatus::Relaxed.code());
    }
}
