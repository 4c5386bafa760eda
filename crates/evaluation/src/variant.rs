//! The methods that can be compared: a name, settings, and what stands in the filter's place.

use std::path::{Path, PathBuf};

use barrier::Model;
use cbf_filter::{FilterSetupError, load_model};
use perception_bridge::Obedience;
use settings::{RobotKind, Settings, SettingsError};

use crate::baseline::{self, Baseline};
use crate::hash::short_hash;
use crate::overrides::{OverrideError, overridden};

/// The robots of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Robot {
    /// Unicycle with MPC.
    Ground,
    /// Double integrator with LQR.
    Quadrotor,
}

impl Robot {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Ground, Self::Quadrotor];

    /// Its name in tables and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ground => "ground",
            Self::Quadrotor => "quadrotor",
        }
    }

    /// Crowd sizes of the paper.
    pub const fn crowds(self) -> &'static [u32] {
        match self {
            Self::Ground => &[5, 10, 15],
            Self::Quadrotor => &[5, 10, 15, 20],
        }
    }

    const fn of(kind: RobotKind) -> Self {
        match kind {
            RobotKind::Unicycle => Self::Ground,
            RobotKind::DoubleIntegrator => Self::Quadrotor,
        }
    }

    /// Settings as published, and those the product runs with.
    const fn settings(self) -> [&'static str; 2] {
        match self {
            Self::Ground => [
                include_str!("../../../config/ground_robot_paper.toml"),
                include_str!("../../../config/ground_robot.toml"),
            ],
            Self::Quadrotor => [
                include_str!("../../../config/quadrotor_paper.toml"),
                include_str!("../../../config/quadrotor.toml"),
            ],
        }
    }

    /// What the grid search that the other methods get too (`baselines::MethodParameters::tuned`, example `tune`, folder
    /// `tuning/`) changes in CN-CBF's published settings.
    const fn tuned(self) -> &'static [&'static str] {
        match self {
            Self::Ground => &["filter.sdf_buffer_m=0.3"],
            Self::Quadrotor => &["filter.sdf_buffer_m=0.2", "filter.beta_per_m=8.0"],
        }
    }
}

/// The world of the tables, over whatever the settings say of theirs: 16 m by 10 m, people of 0.8 to 1.5 m/s, 60 s, and a
/// robot whose state is known at every tick of the filter. The paper names none of these; `docs/evaluation.md` says why.
pub const WORLD: &[&str] = &[
    "simulation.arena_min_m=[0.0, -5.0]",
    "simulation.arena_max_m=[16.0, 5.0]",
    "simulation.desired_speed_mps=[0.8, 1.5]",
    "simulation.start=[-2.0, 0.0, 0.0]",
    "simulation.goal=[13.0, 0.0, 0.0]",
    "simulation.start_clearance_m=2.0",
    "simulation.step_ms=2",
    "simulation.robot_state_period_ms=4",
    "simulation.detections_period_ms=50",
    "simulation.timeout_s=60.0",
    "nominal.goal_tolerance_m=0.3",
];

/// What answers in the filter's place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Mind {
    /// The filter of the settings.
    Filter,
    /// Nobody: the robot obeys its nominal controller.
    Nobody,
    /// Another method.
    Baseline(Baseline),
}

/// A method, ready to be run in any scenario.
#[derive(Debug)]
pub struct Variant {
    pub(crate) name: String,
    pub(crate) robot: Robot,
    pub(crate) settings: Settings,
    pub(crate) settings_hash: String,
    pub(crate) model: Model,
    pub(crate) mind: Mind,
}

/// Why a method cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum VariantError {
    /// No method has this name.
    #[error(
        "no method for the {robot} robot is named `{name}`; choose among {known}, or give settings of your own as \
         NAME=FILE.toml"
    )]
    Unknown {
        /// The name.
        name: String,
        /// The robot.
        robot: &'static str,
        /// What there is.
        known: String,
    },
    /// A settings file of the user is for the other robot.
    #[error("{} is for the {found} robot; this is a table of the {robot} robot", path.display())]
    OtherRobot {
        /// The file.
        path: PathBuf,
        /// Its robot.
        found: &'static str,
        /// The table's.
        robot: &'static str,
    },
    /// The settings are unusable.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// An override is unusable.
    #[error(transparent)]
    Override(#[from] OverrideError),
    /// The model cannot be loaded.
    #[error(transparent)]
    Model(#[from] FilterSetupError),
}

impl Variant {
    /// CN-CBF as published, the same tuned, as the product has it, that with the published estimator, and the nominal
    /// controller alone.
    const OWN: [&'static str; 5] =
        ["cn_cbf", "cn_cbf_tuned", "cn_cbf_onboard", "cn_cbf_onboard_difference", "no_filter"];
    /// The published estimator: exact where positions are.
    const DIFFERENCE: &'static [&'static str] = &["estimator.kind=\"backward_difference\""];

    /// Names of the methods for `robot`, in the order of the tables.
    pub fn names(robot: Robot) -> Vec<&'static str> {
        let [published, tuned, onboard, difference, nobody] = Self::OWN;
        [&[published, tuned, onboard, difference][..], &baseline::names(robot), &[nobody]].concat()
    }

    /// The method `name` for `robot` in the [`WORLD`] of the tables, with `sets` (`section.key=value`) on top: a name of
    /// [`Self::names`], or `NAME=FILE.toml` for the filter with settings of one's own. For the paper's other methods
    /// `method.key=value` sets a parameter of `baselines::MethodParameters`.
    ///
    /// # Errors
    /// [`VariantError`] if there is no such method or its settings are unusable.
    pub fn named(robot: Robot, name: &str, sets: &[String]) -> Result<Self, VariantError> {
        let (name, text, origin, mind, changed) = if let Some((name, file)) = name.split_once('=') {
            let path = Path::new(file);
            let text = std::fs::read_to_string(path)
                .map_err(|source| SettingsError::Read { path: path.to_owned(), source })?;
            (name, text, path.to_owned(), Mind::Filter, &[][..])
        } else {
            let (text, mind, changed) = Self::built_in(robot, name)?;
            (name, text.to_owned(), PathBuf::from("built-in settings"), mind, changed)
        };
        let sets = sets.iter().map(String::as_str);
        let (mind, sets): (Mind, Vec<&str>) = match mind {
            Mind::Baseline(baseline) => {
                let (of_method, of_stack): (Vec<&str>, Vec<&str>) =
                    sets.partition(|set| set.trim_start().starts_with("method."));
                (Mind::Baseline(baseline.with(&of_method)?), of_stack)
            }
            Mind::Filter | Mind::Nobody => (mind, sets.collect()),
        };
        let sets: Vec<&str> = WORLD.iter().chain(changed).copied().chain(sets).collect();
        let folder = origin.parent().unwrap_or(Path::new("."));
        let mut settings = Settings::parse(&overridden(&text, &origin, &sets)?, &origin, folder)?;
        // Nothing of these enters a run, and a changed priority shall not make a table unusable.
        settings.realtime = None;
        settings.offline = None;
        let found = Robot::of(settings.robot.kind);
        if found != robot {
            let (found, robot) = (found.name(), robot.name());
            return Err(VariantError::OtherRobot { path: origin, found, robot });
        }
        Self::new(name.to_owned(), settings, mind)
    }

    /// The settings, the mind, and what the name changes in the former.
    fn built_in(
        robot: Robot,
        name: &str,
    ) -> Result<(&'static str, Mind, &'static [&'static str]), VariantError> {
        let [published, onboard] = robot.settings();
        Ok(match name {
            "cn_cbf" => (published, Mind::Filter, &[]),
            "cn_cbf_tuned" => (published, Mind::Filter, robot.tuned()),
            "cn_cbf_onboard" => (onboard, Mind::Filter, &[]),
            "cn_cbf_onboard_difference" => (onboard, Mind::Filter, Self::DIFFERENCE),
            "no_filter" => (published, Mind::Nobody, &[]),
            _ => match Baseline::named(robot, name) {
                Some(baseline) => (published, Mind::Baseline(baseline), &[]),
                None => return Err(Self::unknown(robot, name)),
            },
        })
    }

    fn new(name: String, settings: Settings, mind: Mind) -> Result<Self, VariantError> {
        let model = load_model(&settings.filter.model)?;
        let identity = format!("{}\n{}\n{mind:?}", settings.to_toml()?, model.metadata().hash);
        Ok(Self {
            name,
            robot: Robot::of(settings.robot.kind),
            settings_hash: short_hash(identity.as_bytes()),
            settings,
            model,
            mind,
        })
    }

    fn unknown(robot: Robot, name: &str) -> VariantError {
        VariantError::Unknown {
            name: name.to_owned(),
            robot: robot.name(),
            known: Self::names(robot).join(", "),
        }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The robot it drives.
    pub const fn robot(&self) -> Robot {
        self.robot
    }

    /// Its settings, scenario aside.
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// First 16 hexadecimal digits of the SHA-256 of its settings, parameters and model: equal for equal ones.
    pub fn settings_hash(&self) -> &str {
        &self.settings_hash
    }

    /// Whom the robot obeys.
    pub(crate) const fn obedience(&self) -> Obedience {
        match self.mind {
            Mind::Filter | Mind::Baseline(_) => Obedience::Filter,
            Mind::Nobody => Obedience::Nominal,
        }
    }
}
