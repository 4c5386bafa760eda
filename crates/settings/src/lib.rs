//! One validated settings file for every process and offline tool.
//!
//! A TOML file has one table per part. Keys that no part knows, missing keys and values out of range are refused when the
//! file is read, with the key's full name; nothing downstream checks again. There is no `Default`: what a person must
//! choose stands in the file, and `config/` holds files to start from.
//!
//! What is deliberately absent: everything a command-line option chooses (source, instance name, recording path).

mod anticipation;
mod classes;
mod covered;
mod error;
mod estimator;
mod filter;
mod filter_options;
mod joint;
mod nominal;
mod offline;
mod realtime;
mod robot;
mod ros2;
mod samples;
mod sensing;
mod simulation;
mod slack;
mod sources;
mod training;

use std::path::Path;

use serde::{Deserialize, Serialize};

pub use anticipation::AnticipationSettings;
pub use classes::ClassesSettings;
pub use error::SettingsError;
pub use estimator::{
    EstimatorKind, EstimatorSettings, ImmSettings, KalmanSettings, LearnedNoiseSettings, ManoeuvreSettings,
    NoiseSettings,
};
pub use filter::{ClassName, FilterSettings, FilterTrigger, KernelChoice};
pub use filter_options::{Composition, ObstacleInput, SoftminOffset};
pub use joint::{JointSettings, JointUse};
pub use nominal::{ControllerKind, LqrSettings, MpcSettings, NominalSettings, PurePursuitSettings};
pub use offline::{Accuracy, Formulation, GridSettings, OfflineSettings, SolverSettings};
pub use realtime::{ProcessRealtime, RealtimeSettings, SchedulerKind, WaitKind};
pub use robot::{ObstacleMotion, ObstacleSettings, RobotKind, RobotSettings};
pub use ros2::{CommandMessage, ObstacleMessage, Reliability, Ros2Settings};
pub use samples::SampleSettings;
pub use sensing::{DriftSettings, SensingSettings};
pub use simulation::{ActuatorSettings, ScenarioSettings, SimulationSettings};
pub use slack::{SlackSettings, TrainingGame};
pub use sources::SourceSettings;
pub use training::{ConditionSettings, Encoding, TargetSource, TrainingSettings};

use error::{Checked, positive};

/// Prefix of a model path that names a model built into the program, as in `embedded:ground_robot_paper`.
pub const EMBEDDED_PREFIX: &str = "embedded:";

/// Everything the stack and the offline tools are told.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// The robot that is driven.
    pub robot: RobotSettings,
    /// What is assumed of the obstacles; also the bounds of the reachability game.
    pub obstacle: ObstacleSettings,
    /// Process 1: how sources are read.
    pub source: SourceSettings,
    /// Process 1: the simulated crowd.
    pub simulation: SimulationSettings,
    /// Process 2.
    pub estimator: EstimatorSettings,
    /// Process 3.
    pub nominal: NominalSettings,
    /// Process 4.
    pub filter: FilterSettings,
    /// What each process asks of the kernel; nothing if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub realtime: Option<RealtimeSettings>,
    /// How the model is computed; only `solve` and `train` need it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offline: Option<OfflineSettings>,
}

impl Settings {
    /// Reads and validates a settings file. A relative model path is resolved against the file's folder.
    ///
    /// # Errors
    /// [`SettingsError`] if the file cannot be read, is no TOML, has an unknown or missing key or a value out of range.
    pub fn load(path: &Path) -> Result<Self, SettingsError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| SettingsError::Read { path: path.to_owned(), source })?;
        let folder = path.parent().unwrap_or(Path::new("."));
        Self::parse(&text, path, folder)
    }

    /// Validates settings given as text; `origin` only names them in errors, `folder` is where relative paths start.
    ///
    /// # Errors
    /// As [`Settings::load`].
    pub fn parse(text: &str, origin: &Path, folder: &Path) -> Result<Self, SettingsError> {
        let mut settings: Self = toml::from_str(text)
            .map_err(|source| SettingsError::Parse { path: origin.to_owned(), source: Box::new(source) })?;
        settings.filter.resolve(folder);
        settings.simulation.resolve(folder);
        settings.validate()?;
        Ok(settings)
    }

    /// The settings as TOML, such that [`Settings::parse`] gives them back.
    ///
    /// # Errors
    /// [`SettingsError::Write`] if a value has no TOML form.
    pub fn to_toml(&self) -> Result<String, SettingsError> {
        toml::to_string_pretty(self).map_err(|source| SettingsError::Write { source: Box::new(source) })
    }

    /// Radius of the failure set the model was made for: robot plus default obstacle, without buffer, m.
    pub fn failure_radius_m(&self) -> f64 {
        self.robot.radius_m + self.obstacle.radius_m
    }

    fn validate(&self) -> Checked {
        self.robot.validate()?;
        self.obstacle.validate(self.robot.kind)?;
        self.source.validate()?;
        self.simulation.validate()?;
        self.estimator.validate()?;
        self.nominal.validate(self.robot.kind)?;
        if let Some(ros2) = &self.source.ros2 {
            ros2.validate_controller(self.nominal.controller)?;
            ros2.validate_lookahead(self.nominal.goal_tolerance_m)?;
        }
        self.filter.validate(self.robot.kind)?;
        positive("robot.radius_m + obstacle.radius_m", self.failure_radius_m())?;
        self.realtime.as_ref().map_or(Ok(()), |realtime| realtime.validate(self))?;
        self.offline.as_ref().map_or(Ok(()), |offline| {
            offline.validate()?;
            covered::validate(&offline.grid, self)
        })
    }
}

#[cfg(test)]
mod tests;
