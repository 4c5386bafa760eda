//! From a fitted network to a model of `barrier`: what the filter loads and what the file says about itself.
//!
//! Not here: reading and writing the file (crate `barrier`).

use crate::network::{FittedNetwork, LAYERS, Shape};
use crate::report::TrainedNetwork;
use crate::setup::domain;
use barrier::{
    Bounds, DynamicsKind, FORMAT_VERSION, GridRecord, InputEncoding, LayerWeights, Model, ModelFileError,
    ModelMetadata, NetworkWeights, TrainingRecord, WeightsError,
};
use dynamics::{InputBox, InputBoxError};
use reachability::ValueFunction;
use serde::Serialize;
use serde_json::{Value, json};
use settings::{Encoding, OfflineSettings, Settings};
use std::collections::BTreeMap;

/// Why a fitted network makes no model.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The value function was solved for other dynamics than the settings'.
    #[error(
        "the value function is for `{found}`, the settings are for `{expected}`; run `cncbf solve` again"
    )]
    Dynamics {
        /// Name in the value file.
        found: String,
        /// Name that the settings make it.
        expected: DynamicsKind,
    },
    /// The control box is empty or not finite.
    #[error("the control box is unusable: {0}")]
    ControlBox(#[from] InputBoxError),
    /// The parameters are not those of the network.
    #[error(transparent)]
    Weights(#[from] WeightsError),
    /// The metadata cannot be sealed.
    #[error(transparent)]
    Model(#[from] ModelFileError),
    /// A record cannot be written as JSON.
    #[error("the training record is no JSON: {0}; train again")]
    Json(#[from] serde_json::Error),
}

/// What a network was fitted to.
pub(crate) struct Source<'a> {
    pub(crate) settings: &'a Settings,
    pub(crate) offline: &'a OfflineSettings,
    pub(crate) dynamics: DynamicsKind,
    /// The fitted value function; absent where it is a closed form.
    pub(crate) value: Option<&'a ValueFunction>,
    /// The value function the errors are against, where it is another.
    pub(crate) truth: Option<&'a ValueFunction>,
}

/// The model of `trained`. It states the true input boxes, which the filter works with; the boxes that were solved, if they
/// differ, stand in the details of its training. The same arguments give the same bytes.
///
/// # Errors
/// [`ExportError`] where the value function is of other dynamics, or numbers are not finite.
pub(crate) fn to_model(source: &Source<'_>, trained: &TrainedNetwork) -> Result<Model, ExportError> {
    let (robot, obstacle) = (&source.settings.robot, &source.settings.obstacle);
    let axes = source.value.map_or_else(|| domain(source.offline), |value| *value.grid().axes());
    let (mut solver, mut value_sha256) = (BTreeMap::new(), String::new());
    if let Some(value) = source.value {
        let metadata = value.metadata();
        let found = &metadata.problem.dynamics;
        if *found != source.dynamics.to_string() {
            return Err(ExportError::Dynamics { found: found.clone(), expected: source.dynamics });
        }
        solver = record(&metadata.solver)?;
        solver.insert("horizon_s".to_owned(), serde_json::to_value(metadata.horizon_s)?);
        solver.insert("outcome".to_owned(), serde_json::to_value(metadata.outcome)?);
        value_sha256.clone_from(&metadata.value_sha256);
    }
    let metadata = ModelMetadata {
        format_version: FORMAT_VERSION,
        dynamics: source.dynamics,
        encoding: input_encoding(trained.network.encoding),
        control: InputBox::new(robot.control_min, robot.control_max)?,
        disturbance: Bounds { min: obstacle.disturbance_min.clone(), max: obstacle.disturbance_max.clone() },
        failure_radius_m: source.settings.failure_radius_m(),
        grid: GridRecord {
            min: axes.map(|a| a.min),
            max: axes.map(|a| a.max),
            count: axes.map(|a| a.count),
            periodic: axes.map(|a| a.periodic),
        },
        solver,
        training: training_record(source, trained)?,
        verification: BTreeMap::new(),
        value_sha256,
        hash: String::new(),
    };
    Ok(Model::new(weights(&trained.network)?, metadata)?)
}

fn training_record(source: &Source<'_>, trained: &TrainedNetwork) -> Result<TrainingRecord, ExportError> {
    let report = &trained.report;
    let fit = &report.fit;
    let solved = source.settings.training_game();
    let errors_against = match (source.value, source.truth) {
        (None, _) => "closed form of the true game, random states",
        (Some(_), Some(_)) => "nodes of the true game's grid",
        (Some(_), None) => "nodes of the fitted grid",
    };
    let mut details = BTreeMap::from([
        ("settings".to_owned(), serde_json::to_value(&source.offline.training)?),
        ("fit".to_owned(), serde_json::to_value(fit)?),
        ("errors_against".to_owned(), json!(errors_against)),
        ("final_loss_m2".to_owned(), serde_json::to_value(report.loss_history.last())?),
    ]);
    if let Some(condition) = &report.condition {
        details.insert("condition".to_owned(), serde_json::to_value(condition)?);
    }
    if let Some(slack) = &source.offline.slack {
        details.insert("slack".to_owned(), serde_json::to_value(slack)?);
        let boxes = json!({
            "control": { "min": solved.control_min, "max": solved.control_max },
            "disturbance": { "min": solved.disturbance_min, "max": solved.disturbance_max },
        });
        details.insert("solved_game".to_owned(), boxes);
    }
    Ok(TrainingRecord {
        epochs: report.epochs,
        seed: source.offline.training.seed,
        samples: report.samples_per_epoch as u64,
        error_mean_m: fit.outside.mean_m,
        error_p99_m: fit.outside.p99_m,
        error_max_m: fit.outside.max_m,
        false_safe_share: fit.false_safe_share,
        false_unsafe_share: fit.false_unsafe_share,
        details,
    })
}

fn record(value: &impl Serialize) -> Result<BTreeMap<String, Value>, serde_json::Error> {
    serde_json::from_value(serde_json::to_value(value)?)
}

const fn input_encoding(encoding: Encoding) -> InputEncoding {
    match encoding {
        Encoding::Raw => InputEncoding::Raw,
        Encoding::HeadingCosSin => InputEncoding::HeadingCosSin,
        Encoding::Position => InputEncoding::Position,
    }
}

fn weights(network: &FittedNetwork) -> Result<NetworkWeights, WeightsError> {
    let (shape, parameters) = (Shape::of(network.encoding), &network.parameters);
    let layers = (0..LAYERS).map(|layer| LayerWeights {
        weight: parameters[shape.offset(layer)..shape.bias_offset(layer)].to_vec(),
        bias: parameters[shape.bias_offset(layer)..][..shape.output(layer)].to_vec(),
    });
    NetworkWeights::new(input_encoding(network.encoding), layers.collect())
}

/// The network of a model, to measure it or to compare it.
pub fn network_of(model: &Model) -> FittedNetwork {
    let encoding = match model.weights().encoding() {
        InputEncoding::Raw => Encoding::Raw,
        InputEncoding::HeadingCosSin => Encoding::HeadingCosSin,
        InputEncoding::Position => Encoding::Position,
    };
    let layers = model.weights().layers().iter();
    let parameters = layers.flat_map(|layer| layer.weight.iter().chain(&layer.bias).copied()).collect();
    FittedNetwork { encoding, parameters }
}
