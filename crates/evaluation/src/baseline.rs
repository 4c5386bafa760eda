//! The paper's other methods in the filter's place.
//!
//! Not here: the methods (crate `baselines`), and how their answers reach the robot (`seat`).

use barrier::Model;
use baselines::{MethodKind, MethodParameters};
use settings::{RobotKind, Settings};

use crate::seat::Seat;
use crate::variant::Robot;

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

    /// Sets it up in the filter's place.
    pub(crate) fn seat(&self, settings: &Settings, model: &Model) -> Result<Seat, BaselineError> {
        let method = self.parameters.build(settings, Some(model))?;
        let kind = self.parameters.kind();
        let corrects_nominal = kind.robot() == RobotKind::DoubleIntegrator;
        Ok(Seat::new(settings, method, corrects_nominal, kind.published_period_ns()))
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
