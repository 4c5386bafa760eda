//! From trained parameters to a model file's contents: weights by layer, and metadata that names everything the model
//! depends on.
//!
//! Not here: the bytes of the file (crate `barrier`).

use crate::network::{LAYERS, WIDTHS, bias_offset, offset};
use crate::recipe::Recipe;
use crate::report::TrainedModel;
use barrier::{
    Bounds, DynamicsKind, FORMAT_VERSION, GridRecord, InputEncoding, LayerWeights, Model, ModelFileError,
    ModelMetadata, NetworkWeights, TrainingRecord, WeightsError,
};
use dynamics::{InputBox, InputBoxError};
use reachability::ValueFunction;
use serde::Serialize;
use serde_json::Value;
use settings::TrainingSettings;
use std::collections::BTreeMap;

/// Why trained parameters and their value function make no model.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The value function was solved for dynamics that no filter knows.
    #[error("the value function is for `{dynamics}`; solve for `unicycle_pair` or `double_integrator_pair`")]
    Dynamics {
        /// Name in the value file.
        dynamics: String,
    },
    /// The value function names another number of controls.
    #[error("the value function has {found} controls, 2 are needed; solve again for one of the pairs")]
    Controls {
        /// Number of controls in the value file.
        found: usize,
    },
    /// The value function's control box is empty or not finite.
    #[error("the value function's control box is unusable: {0}")]
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

/// The model of `trained`, which was fitted to `value` with `settings` and `recipe`. The same arguments give the same
/// bytes.
///
/// # Errors
/// [`ExportError`] where the value function is not for a pair the filter knows, or numbers are not finite.
pub fn to_model(
    value: &ValueFunction,
    trained: &TrainedModel,
    settings: &TrainingSettings,
    recipe: &Recipe,
) -> Result<Model, ExportError> {
    let source = value.metadata();
    let problem = &source.problem;
    let dynamics: DynamicsKind = serde_json::from_value(Value::String(problem.dynamics.clone()))
        .map_err(|_| ExportError::Dynamics { dynamics: problem.dynamics.clone() })?;
    let components = |limits: &[f64]| {
        <[f64; 2]>::try_from(limits).map_err(|_| ExportError::Controls { found: limits.len() })
    };
    let axes = value.grid().axes();
    let mut solver = record(&source.solver)?;
    solver.insert("horizon_s".to_owned(), serde_json::to_value(source.horizon_s)?);
    solver.insert("outcome".to_owned(), serde_json::to_value(source.outcome)?);
    let metadata = ModelMetadata {
        format_version: FORMAT_VERSION,
        dynamics,
        encoding: InputEncoding::Raw,
        control: InputBox::new(components(&problem.control.min)?, components(&problem.control.max)?)?,
        disturbance: Bounds { min: problem.disturbance.min.clone(), max: problem.disturbance.max.clone() },
        failure_radius_m: problem.failure_radius_m,
        grid: GridRecord {
            min: axes.map(|a| a.min),
            max: axes.map(|a| a.max),
            count: axes.map(|a| a.count),
            periodic: axes.map(|a| a.periodic),
        },
        solver,
        training: training_record(trained, settings, recipe)?,
        verification: BTreeMap::new(),
        value_sha256: source.value_sha256.clone(),
        hash: String::new(),
    };
    Ok(Model::new(weights(&trained.parameters)?, metadata)?)
}

fn training_record(
    trained: &TrainedModel,
    settings: &TrainingSettings,
    recipe: &Recipe,
) -> Result<TrainingRecord, ExportError> {
    let report = &trained.report;
    let fit = &report.fit;
    let details = BTreeMap::from([
        ("settings".to_owned(), serde_json::to_value(settings)?),
        ("recipe".to_owned(), serde_json::to_value(recipe)?),
        ("fit".to_owned(), serde_json::to_value(fit)?),
        ("final_loss_m2".to_owned(), serde_json::to_value(report.loss_history.last())?),
    ]);
    Ok(TrainingRecord {
        epochs: report.epochs,
        seed: settings.seed,
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

fn weights(parameters: &[f32]) -> Result<NetworkWeights, WeightsError> {
    let layers = (0..LAYERS).map(|layer| LayerWeights {
        weight: parameters[offset(layer)..bias_offset(layer)].to_vec(),
        bias: parameters[bias_offset(layer)..][..WIDTHS[layer + 1]].to_vec(),
    });
    NetworkWeights::new(InputEncoding::Raw, layers.collect())
}

/// The flat parameters of a model, layout of [`crate::network`].
pub fn parameters_of(model: &Model) -> Vec<f32> {
    model
        .weights()
        .layers()
        .iter()
        .flat_map(|layer| layer.weight.iter().chain(&layer.bias).copied())
        .collect()
}
