//! Verification of a trained relative barrier: what holds for all states, what was measured, and what was certified.
//!
//! | part | question | answer |
//! |---|---|---|
//! | (a) [`check_structure`] | can a state of the failure set be called safe? | never, by construction; the kernel is checked |
//! | (b) [`measure_value_error`] | how far is h from the true value, and on which side of zero? | sampled, with intervals |
//! | (c) [`measure_condition`] | where can the robot not keep h up against the worst obstacle? | sampled, then searched |
//! | (d) [`certify_by_rollouts`] | how likely does the closed loop fail? | a probability bound with confidence |
//! | (e) [`affine`] | does the condition hold on a whole box? | a proof, a counterexample, or neither |
//!
//! Everything is judged with the kernel that runs on board, against the model's true boxes, and is the same for any number of
//! threads. Nothing here prints, trains, changes a model or drives a robot; [`Verification`] is plain data that a model's
//! metadata keeps.

pub mod affine;
mod condition;
mod error;
mod game;
mod inflation;
mod rollout;
mod scenario;
mod solved_truth;
mod statistics;
mod structural;
mod subject;
mod table;
mod truth;
mod value_error;
mod verification;
mod worst_search;

pub use condition::{BAND_M, ConditionRecord, ConditionSettings, LARGEST_INFLATION_M, measure_condition};
pub use error::VerificationError;
pub use game::{Disturbance, Game};
pub use rollout::{DisturbancePolicy, HOLD_S, NominalPolicy};
pub use scenario::{
    NotableRollout, SCENARIO_STATEMENT, STANDARD_LEVELS_M, STANDARD_ROLLOUTS, STANDARD_TOLERANCE_M,
    ScenarioRecord, ScenarioRow, ScenarioSettings, certify_by_rollouts,
};
pub use solved_truth::{SolvedTruthError, solve_truth};
pub use statistics::{ErrorSummary, Share, failure_bound};
pub use structural::{STRUCTURAL_ARGUMENT, StructuralRecord, check_structure};
pub use subject::{OnProgress, Phase, Progress, Subject};
pub use truth::{ClosedForm, TrueValue};
pub use value_error::{NEAR_ZERO_BAND_M, ValueErrorRecord, ValueErrorSettings, measure_value_error};
pub use verification::{Verification, VerificationPlan, VerificationRecordError, verify};
