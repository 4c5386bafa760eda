//! Which model the filter uses, and whether it fits the settings.

use std::path::Path;

use barrier::{
    Bounds, CompositeSetupError, DynamicsKind, Expected, Model, ModelFileError, ModelMismatch, QpError,
};
use dynamics::{DoubleIntegratorPair, InputBox, InputBoxError, UnicyclePair};
use settings::{EMBEDDED_PREFIX, ObstacleMotion, RobotKind, Settings};

use crate::filter::Pair;

/// Models built into the program: name, file.
pub const EMBEDDED_MODELS: &[(&str, &[u8])] = &[
    ("ground_robot", include_bytes!("../../models/ground_robot.safetensors")),
    ("ground_robot_paper", include_bytes!("../../models/ground_robot_paper.safetensors")),
    ("quadrotor", include_bytes!("../../models/quadrotor.safetensors")),
    ("quadrotor_paper", include_bytes!("../../models/quadrotor_paper.safetensors")),
    ("static_obstacles", include_bytes!("../../models/static_obstacles.safetensors")),
    ("cyclist", include_bytes!("../../models/cyclist.safetensors")),
];

/// Why the filter refuses to start.
#[derive(Debug, thiserror::Error)]
pub enum FilterSetupError {
    /// The file is missing, truncated, foreign or altered.
    #[error("model {name}: {source}")]
    File {
        /// As written in `filter.model`.
        name: String,
        /// What is wrong with it.
        source: ModelFileError,
    },
    /// No model of this name is built in.
    #[error("no model named {name} is built in; there are: {known}")]
    NotEmbedded {
        /// The name asked for.
        name: String,
        /// The names there are.
        known: String,
    },
    /// The model was made for something else.
    #[error("the model does not fit the settings: {0}")]
    Mismatch(#[from] ModelMismatch),
    /// A model of `filter.class_models` is for another robot than `filter.model`.
    #[error("model {name} of filter.class_models does not fit: {source}")]
    ClassMismatch {
        /// As written in the settings.
        name: String,
        /// In what it differs.
        source: ModelMismatch,
    },
    /// The control or disturbance bounds are no box.
    #[error("robot or obstacle bounds: {0}")]
    Bounds(#[from] InputBoxError),
    /// The composite cannot be set up, for instance because the forced kernel does not run here.
    #[error(transparent)]
    Composite(#[from] CompositeSetupError),
    /// The quadratic program cannot be set up.
    #[error(transparent)]
    Qp(#[from] QpError),
}

/// Loads the model a `filter.model` entry names: a path, or `embedded:NAME`.
///
/// # Errors
/// [`FilterSetupError::File`] and [`FilterSetupError::NotEmbedded`].
pub fn load_model(name: &str) -> Result<Model, FilterSetupError> {
    let loaded = match name.strip_prefix(EMBEDDED_PREFIX) {
        None => Model::load(Path::new(name)),
        Some(embedded) => Model::from_bytes(embedded_model(embedded)?),
    };
    loaded.map_err(|source| FilterSetupError::File { name: name.to_owned(), source })
}

fn embedded_model(name: &str) -> Result<&'static [u8], FilterSetupError> {
    let found = EMBEDDED_MODELS.iter().find(|(known, _)| *known == name);
    found.map(|(_, bytes)| *bytes).ok_or_else(|| {
        let known: Vec<_> = EMBEDDED_MODELS.iter().map(|(known, _)| *known).collect();
        FilterSetupError::NotEmbedded { name: name.to_owned(), known: known.join(", ") }
    })
}

/// The pair of dynamics the settings describe, if `model` was made for that: same dynamics, obstacle bounds and failure
/// radius, controls that the robot has (it may have more), and if it is the pinned one and covers obstacles and buffer.
pub(crate) fn pair_that_fits(settings: &Settings, model: &Model) -> Result<Pair, FilterSetupError> {
    let (robot, obstacle) = (&settings.robot, &settings.obstacle);
    if let Some(sha256) = &settings.filter.model_sha256 {
        model.check_hash(sha256)?;
    }
    let control = InputBox::new(robot.control_min, robot.control_max)?;
    let dynamics = match (robot.kind, obstacle.motion) {
        (RobotKind::Unicycle, ObstacleMotion::Walking) => DynamicsKind::UnicyclePair,
        (RobotKind::Unicycle, ObstacleMotion::Static) => DynamicsKind::UnicycleStaticPair,
        (RobotKind::DoubleIntegrator, ObstacleMotion::Walking | ObstacleMotion::Static) => {
            DynamicsKind::DoubleIntegratorPair
        }
    };
    let disturbance = Bounds { min: obstacle.disturbance_min.clone(), max: obstacle.disturbance_max.clone() };
    let failure_radius_m = Some(settings.failure_radius_m());
    model.check_fits(&Expected { dynamics, control, disturbance, failure_radius_m })?;
    model.check_covers(obstacle.max_speed_mps, contact_radius_m(settings))?;
    let (min, max) = (&obstacle.disturbance_min, &obstacle.disturbance_max);
    Ok(match robot.kind {
        // The geometry of walking obstacles serves static ones too, whose models look at the position alone.
        RobotKind::Unicycle => {
            let [min, max] = [min, max].map(|ends| [ends.first().copied().unwrap_or(0.0)]);
            Pair::Unicycle(UnicyclePair { control, disturbance: InputBox::new(min, max)? })
        }
        RobotKind::DoubleIntegrator => Pair::DoubleIntegrator(DoubleIntegratorPair {
            control,
            disturbance: InputBox::new([min[0], min[1]], [max[0], max[1]])?,
        }),
    })
}

/// Distance of the centres at which contact counts for an obstacle of the default radius, buffer included, m.
pub(crate) fn contact_radius_m(settings: &Settings) -> f64 {
    settings.failure_radius_m() + settings.filter.sdf_buffer_m
}
