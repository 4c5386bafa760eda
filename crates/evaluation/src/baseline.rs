//! The paper's other methods in the filter's place: as published, tuned, or with single parameters changed.
//!
//! Not here: the methods and their parameters (crate `baselines`), and how their answers reach the robot (`seat`).

use std::path::Path;

use barrier::Model;
use baselines::{MethodKind, MethodParameters};
use serde::{Deserialize, Serialize};
use settings::{RobotKind, Settings, SettingsError};

use crate::overrides::{OverrideError, overridden};
use crate::seat::Seat;
use crate::variant::Robot;

pub use baselines::MethodSetupError as BaselineError;

/// A method of the paper with its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Baseline {
    parameters: MethodParameters,
}

impl Baseline {
    /// The method `name` as its authors published it, or tuned if the name ends so, if it is one for `robot`.
    pub(crate) fn named(robot: Robot, name: &str) -> Option<Self> {
        kinds(robot).find_map(|kind| {
            let parameters = if name == kind.name() {
                MethodParameters::published(kind)
            } else if name == kind.tuned_name() {
                MethodParameters::tuned(kind)
            } else {
                return None;
            };
            Some(Self { parameters })
        })
    }

    /// The same method with each of `sets` (`method.key=value`) in turn.
    pub(crate) fn with(self, sets: &[&str]) -> Result<Self, OverrideError> {
        let origin = Path::new("parameters of the method");
        let text = toml::to_string(&Section { method: self.parameters })
            .map_err(|source| SettingsError::Write { source: Box::new(source) })?;
        let changed: Section = toml::from_str(&overridden(&text, origin, sets)?)
            .map_err(|source| SettingsError::Parse { path: origin.to_owned(), source: Box::new(source) })?;
        if changed.method.kind() != self.parameters.kind() {
            // The tag is no parameter: another method has another name.
            return Err(OverrideError::Malformed(sets.join(" ")));
        }
        Ok(Self { parameters: changed.method })
    }

    /// Sets it up in the filter's place.
    pub(crate) fn seat(&self, settings: &Settings, model: &Model) -> Result<Seat, BaselineError> {
        let method = self.parameters.build(settings, Some(model))?;
        let kind = self.parameters.kind();
        let corrects_nominal = kind.robot() == RobotKind::DoubleIntegrator;
        Ok(Seat::new(settings, method, corrects_nominal, kind.published_period_ns()))
    }
}

/// Parameters of a method as the section of a settings file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Section {
    method: MethodParameters,
}

/// Names of the methods for `robot`, each as published and then tuned.
pub(crate) fn names(robot: Robot) -> Vec<&'static str> {
    kinds(robot).flat_map(|kind| [kind.name(), kind.tuned_name()]).collect()
}

fn kinds(robot: Robot) -> impl Iterator<Item = MethodKind> {
    MethodKind::ALL.into_iter().filter(move |kind| match kind.robot() {
        RobotKind::Unicycle => robot == Robot::Ground,
        RobotKind::DoubleIntegrator => robot == Robot::Quadrotor,
    })
}
