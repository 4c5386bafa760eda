//! The paper's other methods in the filter's place.
//!
//! Not here: the methods (crate `baselines`); this is only their way into the closed loop.

use barrier::Model;
use baselines::{Inputs, Method, MethodKind, MethodParameters, Verdict};
use settings::{RobotKind, Settings};

use crate::variant::Robot;
use crate::whole_method::{MethodCommand, MethodInputs, WholeMethod};

pub use baselines::MethodSetupError as BaselineError;

/// A method of the paper with its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Baseline {
    parameters: MethodParameters,
}

impl Baseline {
    /// The method `name` as its authors published it, if it is one for `robot`.
    pub(crate) fn named(robot: Robot, name: &str) -> Option<Self> {
        let kind = kinds(robot).find(|kind| kind.name() == name)?;
        Some(Self { parameters: MethodParameters::published(kind) })
    }

    /// Sets it up, and says how often it is stepped, ns.
    pub(crate) fn build(
        &self,
        settings: &Settings,
        model: &Model,
    ) -> Result<(Box<dyn WholeMethod>, u64), BaselineError> {
        let method = self.parameters.build(settings, Some(model))?;
        let kind = self.parameters.kind();
        let corrects_nominal = kind.robot() == RobotKind::DoubleIntegrator;
        Ok((Box::new(Adapter { method, corrects_nominal }), kind.published_period_ns()))
    }
}

/// Names of the methods for `robot`.
pub(crate) fn names(robot: Robot) -> Vec<&'static str> {
    kinds(robot).map(MethodKind::name).collect()
}

fn kinds(robot: Robot) -> impl Iterator<Item = MethodKind> {
    MethodKind::ALL.into_iter().filter(move |kind| match kind.robot() {
        RobotKind::Unicycle => robot == Robot::Ground,
        RobotKind::DoubleIntegrator => robot == Robot::Quadrotor,
    })
}

struct Adapter {
    method: Box<dyn Method>,
    corrects_nominal: bool,
}

impl WholeMethod for Adapter {
    fn corrects_nominal(&self) -> bool {
        self.corrects_nominal
    }

    fn step(&mut self, inputs: &MethodInputs<'_>, now_ns: u64) -> Option<MethodCommand> {
        let inputs = Inputs {
            robot_state: inputs.robot_state,
            obstacles: inputs.obstacles,
            goal: inputs.goal,
            nominal: inputs.nominal,
        };
        let output = self.method.step(&inputs, now_ns).ok()?;
        Some(MethodCommand {
            control: output.control,
            feasible: match output.verdict {
                // The verdict knows the method's own tolerance; a slack within it is no failure.
                Verdict::Feasible => true,
                Verdict::IterationLimit | Verdict::Infeasible | Verdict::SolverFailed => false,
            },
            slack: output.slack,
            hard_margin: output.hard_feasibility_margin,
            obstacle_count: output.obstacle_count,
        })
    }
}
