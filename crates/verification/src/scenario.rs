//! (d) The scenario certificate: closed-loop rollouts from the safe set, and what their failures bound.
//!
//! Source: Lin and Bansal 2023 (verification of learned reachable sets by scenario optimisation). Not here: the loop (`rollout`).

use serde::{Deserialize, Serialize};

use crate::error::{VerificationError, require_positive};
use crate::rollout::{BATCH, DisturbancePolicy, NominalPolicy, Pairs, Rollout};
use crate::statistics::failure_bound;
use crate::subject::{Judge, OnProgress, Phase, Subject};

/// What the certificate says and what it does not; stored beside its figures.
pub const SCENARIO_STATEMENT: &str = "With confidence 1 - beta, a pair that starts at a state drawn uniformly from S_delta = {h >= delta, l > 0} \
in the trained box comes closer than R - tolerance within the horizon with probability at most epsilon; the second epsilon is for doing so before it \
has left the trained box (for double integrators: before their relative velocity has). It is a probability over that distribution \
of states, most of them far away, not over the boundary, and not over those a robot meets. It holds for the nominal and the disturbance policy \
named, for one obstacle, for exact states and a loop without delay apart from the obstacle's rate, which is that of the cycle before. Where the \
pair leaves the trained box, h is taken as the filter takes it there: residual at the nearest state inside, true distance. Each row holds by \
itself; all rows together hold with confidence 1 - (rows) beta.";

/// Rollouts without a failure that bound the probability by 1e-4 with confidence 1 − 1e-6.
pub const STANDARD_ROLLOUTS: usize = 138_149;

/// Depth of contact that the standard certificate forgives, m.
pub const STANDARD_TOLERANCE_M: f64 = 1e-3;

/// The levels δ of the standard table, m.
pub const STANDARD_LEVELS_M: [f64; 8] = [0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5];

/// Depths of contact that are counted apart, m. Zero is the strict count.
const DEPTHS_M: [f64; 6] = [0.0, 0.001, 0.01, 0.05, 0.1, 0.2];

/// Which loop to play, how often and for how long.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScenarioSettings {
    /// Rollouts from `{h ≥ 0}`, e.g. [`STANDARD_ROLLOUTS`].
    pub rollouts: usize,
    /// Length of each, s, e.g. 5.
    pub horizon_s: f64,
    /// Filter period, s, e.g. 0.004.
    pub period_s: f64,
    /// Class-κ gain α of the filter, 1/s.
    pub alpha_per_s: f64,
    /// Weight of the squared slack in the CBF-QP.
    pub slack_weight: f64,
    /// `β`: one minus the confidence, e.g. 1e-6.
    pub beta: f64,
    /// Contact up to this depth is no failure, m, e.g. [`STANDARD_TOLERANCE_M`]: a loop that is sampled and whose QP is soft grazes the
    /// boundary it steers along.
    pub tolerance_m: f64,
    /// What the robot would do alone.
    pub nominal: NominalPolicy,
    /// What the obstacle does.
    pub disturbance: DisturbancePolicy,
    /// Levels δ of the table, m, e.g. [`STANDARD_LEVELS_M`].
    pub levels_m: Vec<f64>,
    /// Seed.
    pub seed: u64,
}

/// What the rollouts from `S_δ` bound.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScenarioRow {
    /// δ, m.
    pub level_m: f64,
    /// Rollouts that started with `h ≥ δ`.
    pub rollouts: u64,
    /// Of these, rollouts that came closer than R minus the tolerance.
    pub failures: u64,
    /// Smallest ε that the binomial bound allows.
    pub epsilon: f64,
    /// Failures before the pair had left the trained box.
    pub failures_in_box: u64,
    /// Smallest ε for these.
    pub epsilon_in_box: f64,
}

/// How many rollouts came closer than `R` by more than a depth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DepthCount {
    /// Depth, m.
    pub deeper_than_m: f64,
    /// Rollouts whose clearance fell below minus that.
    pub rollouts: u64,
}

/// A rollout that failed, or came closest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NotableRollout {
    /// State at the start.
    pub start: [f64; 4],
    /// `h` at the start, m.
    pub start_h_m: f64,
    /// Smallest distance minus radius, m.
    pub clearance_m: f64,
}

/// The scenario certificate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScenarioRecord {
    /// [`SCENARIO_STATEMENT`] of the version that judged.
    pub statement: String,
    /// What was played.
    pub settings: ScenarioSettings,
    /// One row per level, from the same rollouts.
    pub rows: Vec<ScenarioRow>,
    /// How deep the failures of all rollouts went: even an exact value lets a sampled loop graze by millimetres.
    pub depths: Vec<DepthCount>,
    /// Rollouts during which the pair left the trained box.
    pub left_box: u64,
    /// Rollouts in which the QP had no finite answer; counted as failures.
    pub without_answer: u64,
    /// The rollout that came closest.
    pub closest: NotableRollout,
    /// Largest `h` at the start among failures, m: from above it none failed.
    pub highest_failing_start_m: Option<f64>,
}

impl ScenarioSettings {
    fn check(&self) -> Result<(), VerificationError> {
        require_positive("rollouts", self.rollouts as f64)?;
        require_positive("horizon_s", self.horizon_s)?;
        require_positive("period_s", self.period_s)?;
        require_positive("alpha_per_s", self.alpha_per_s)?;
        let level = self.levels_m.iter().copied().find(|level| !level.is_finite() || *level < 0.0);
        if let Some(value) = level {
            return Err(VerificationError::Setting {
                field: "levels_m",
                value,
                expected: "levels of at least 0 m",
            });
        }
        let tolerance_m = self.tolerance_m;
        if !(tolerance_m.is_finite() && tolerance_m >= 0.0) {
            let expected = "a depth of at least 0 m";
            return Err(VerificationError::Setting { field: "tolerance_m", value: tolerance_m, expected });
        }
        if self.beta > 0.0 && self.beta < 1.0 {
            Ok(())
        } else {
            Err(VerificationError::Setting {
                field: "beta",
                value: self.beta,
                expected: "a number in (0, 1)",
            })
        }
    }
}

/// States drawn in search of one safe one before the model is given up.
const PATIENCE: usize = 100_000;

/// Plays the rollouts and bounds the probability of failure. Deterministic for a seed and a kernel, with any number of threads.
///
/// # Errors
/// * [`VerificationError::Setting`], [`VerificationError::Qp`] for settings without sense.
/// * [`VerificationError::NoSafeState`] if the model calls almost nothing safe.
/// * [`VerificationError::Stopped`].
pub fn certify_by_rollouts(
    subject: &Subject<'_>,
    settings: &ScenarioSettings,
    progress: OnProgress<'_>,
) -> Result<ScenarioRecord, VerificationError> {
    settings.check()?;
    let phase = (Phase::Rollouts, settings.seed);
    let batches = subject.in_pieces(phase, (settings.rollouts, BATCH), progress, |judge, count| {
        let starts = draw_safe(subject, judge, count)?;
        let mut pairs = Pairs::new(subject, settings)?;
        Ok(pairs.play(subject, settings, judge, &starts).to_vec())
    })?;
    let batches: Result<Vec<Vec<Rollout>>, VerificationError> = batches.into_iter().collect();
    Ok(record(settings, &batches?.concat()))
}

/// Draws `count` states uniformly from `{h ≥ 0, ℓ > 0}` in the trained box, by rejection.
fn draw_safe(
    subject: &Subject<'_>,
    judge: &mut Judge,
    count: usize,
) -> Result<Vec<([f64; 4], f64)>, VerificationError> {
    let mut safe = Vec::with_capacity(count);
    let mut since_last = 0;
    while safe.len() < count {
        let drawn: Vec<[f64; 4]> = (0..BATCH).map(|_| subject.draw_outside_failure(&mut judge.rng)).collect();
        let samples = judge.evaluate_values(&drawn);
        let before = safe.len();
        safe.extend(
            drawn.iter().zip(samples).filter(|(_, sample)| sample.h_bar >= 0.0).map(|(z, s)| (*z, s.h_bar)),
        );
        since_last = if safe.len() == before { since_last + BATCH } else { 0 };
        if since_last >= PATIENCE {
            return Err(VerificationError::NoSafeState { drawn: since_last });
        }
    }
    safe.truncate(count);
    Ok(safe)
}

fn record(settings: &ScenarioSettings, rollouts: &[Rollout]) -> ScenarioRecord {
    let failures = || rollouts.iter().filter(|rollout| rollout.failed());
    let rows = settings.levels_m.iter().map(|&level_m| {
        let from = |rollout: &&Rollout| rollout.start_h_m >= level_m;
        let (of, failed) = (rollouts.iter().filter(from).count(), failures().filter(from).count());
        let inside = failures().filter(from).filter(|rollout| !rollout.left_before_contact).count();
        let (rollouts, failures, failures_in_box) = (of as u64, failed as u64, inside as u64);
        ScenarioRow {
            level_m,
            rollouts,
            failures,
            epsilon: failure_bound(failures, rollouts, settings.beta),
            failures_in_box,
            epsilon_in_box: failure_bound(failures_in_box, rollouts, settings.beta),
        }
    });
    let depths = DEPTHS_M.map(|deeper_than_m| DepthCount {
        deeper_than_m,
        rollouts: rollouts.iter().filter(|rollout| rollout.clearance_m < -deeper_than_m).count() as u64,
    });
    let closest = rollouts.iter().min_by(|a, b| a.clearance_m.total_cmp(&b.clearance_m));
    let nothing = NotableRollout { start: [0.0; 4], start_h_m: 0.0, clearance_m: 0.0 };
    ScenarioRecord {
        statement: SCENARIO_STATEMENT.to_owned(),
        settings: settings.clone(),
        rows: rows.collect(),
        depths: depths.to_vec(),
        left_box: rollouts.iter().filter(|rollout| rollout.left_box).count() as u64,
        without_answer: rollouts.iter().filter(|rollout| rollout.broken).count() as u64,
        closest: closest.map_or(nothing, |rollout| NotableRollout {
            start: rollout.start,
            start_h_m: rollout.start_h_m,
            clearance_m: rollout.clearance_m,
        }),
        highest_failing_start_m: failures().map(|rollout| rollout.start_h_m).max_by(f64::total_cmp),
    }
}
