//! Everything that was found about one model, and how it gets into the model's metadata and out again.
//!
//! Not here: the text for people (`table`).

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::affine::AffineRecord;
use crate::condition::{ConditionRecord, ConditionSettings, measure_condition};
use crate::error::VerificationError;
use crate::rollout::{DisturbancePolicy, NominalPolicy};
use crate::scenario::{
    STANDARD_LEVELS_M, STANDARD_ROLLOUTS, STANDARD_TOLERANCE_M, ScenarioRecord, ScenarioSettings,
    certify_by_rollouts,
};
use crate::structural::{StructuralRecord, check_structure};
use crate::subject::{OnProgress, Subject};
use crate::truth::TrueValue;
use crate::value_error::{ValueErrorRecord, ValueErrorSettings, measure_value_error};

/// What is to be found out; parts left out are `None`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VerificationPlan {
    /// States of the structural check.
    pub structural_states: usize,
    /// Seed of the structural check.
    pub seed: u64,
    /// Error against the truth, where there is a truth.
    pub value_error: ValueErrorSettings,
    /// The CBF condition.
    pub condition: ConditionSettings,
    /// The rollouts; they take minutes.
    pub scenario: Option<ScenarioSettings>,
}

impl VerificationPlan {
    /// Returns the plan behind the published figures: 100,000 states for errors, 2,000,000 for shares and condition,
    /// [`STANDARD_ROLLOUTS`] rollouts of 5 s with a robot that drives at the worst obstacle.
    pub fn standard(alpha_per_s: f64, period_s: f64, slack_weight: f64, seed: u64) -> Self {
        Self {
            structural_states: 200_000,
            seed,
            value_error: ValueErrorSettings { states: 100_000, shell_states: 2_000_000, seed },
            condition: ConditionSettings { alpha_per_s, states: 2_000_000, search_steps: 400, seed },
            scenario: Some(ScenarioSettings {
                rollouts: STANDARD_ROLLOUTS,
                horizon_s: 5.0,
                period_s,
                alpha_per_s,
                slack_weight,
                beta: 1e-6,
                tolerance_m: STANDARD_TOLERANCE_M,
                nominal: NominalPolicy::TowardObstacle,
                disturbance: DisturbancePolicy::LowersBarrier,
                levels_m: STANDARD_LEVELS_M.to_vec(),
                seed,
            }),
        }
    }
}

/// What was found about one model.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Verification {
    /// Kernel that judged.
    pub kernel: String,
    /// (a)
    pub structural: Option<StructuralRecord>,
    /// (b)
    pub value_error: Option<ValueErrorRecord>,
    /// (c)
    pub condition: Option<ConditionRecord>,
    /// (d)
    pub scenario: Option<ScenarioRecord>,
    /// (e)
    pub affine: Option<AffineRecord>,
}

/// The metadata holds a verification of another version.
#[derive(Debug, thiserror::Error)]
#[error("the model's verification cannot be read ({0}); verify the model again")]
pub struct VerificationRecordError(#[from] serde_json::Error);

impl Verification {
    /// Returns the parts that were found, by name, for the model's metadata.
    ///
    /// # Errors
    /// * [`VerificationRecordError`] if a part cannot be written as JSON, which records do not cause.
    pub fn to_metadata(&self) -> Result<BTreeMap<String, Value>, VerificationRecordError> {
        let Value::Object(parts) = serde_json::to_value(self)? else { return Ok(BTreeMap::new()) };
        Ok(parts.into_iter().filter(|(_, part)| !part.is_null()).collect())
    }

    /// Reads back what [`Verification::to_metadata`] wrote; empty metadata gives an empty verification.
    ///
    /// # Errors
    /// * [`VerificationRecordError`] for records of another version.
    pub fn from_metadata(parts: &BTreeMap<String, Value>) -> Result<Self, VerificationRecordError> {
        if parts.is_empty() {
            return Ok(Self::default());
        }
        Ok(serde_json::from_value(Value::Object(parts.clone().into_iter().collect()))?)
    }
}

/// Carries out `plan`; without a truth, the error against it is left out.
///
/// # Errors
/// * The first [`VerificationError`].
pub fn verify(
    subject: &Subject<'_>,
    truth: Option<&dyn TrueValue>,
    plan: &VerificationPlan,
    progress: OnProgress<'_>,
) -> Result<Verification, VerificationError> {
    if let Some(truth) = truth {
        truth.check_fits(subject.model().metadata())?;
    }
    let structural = Some(check_structure(subject, plan.structural_states, plan.seed, progress)?);
    let value_error =
        truth.map(|truth| measure_value_error(subject, truth, &plan.value_error, progress)).transpose()?;
    let condition = Some(measure_condition(subject, &plan.condition, progress)?);
    let scenario = plan
        .scenario
        .as_ref()
        .map(|settings| certify_by_rollouts(subject, settings, progress))
        .transpose()?;
    let kernel = subject.kernel().to_string();
    Ok(Verification { kernel, structural, value_error, condition, scenario, affine: None })
}
