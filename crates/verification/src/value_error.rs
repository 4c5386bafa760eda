//! (b) Error against the truth: how far off, and what matters, which unsafe states are called safe.
//!
//! Not here: the truth itself (`truth`).

use serde::{Deserialize, Serialize};

use crate::error::VerificationError;
use crate::statistics::{ErrorSummary, Share};
use crate::subject::{OnProgress, Phase, Subject};
use crate::truth::TrueValue;

/// Half width of the band about the zero level whose errors are summarised apart, m.
pub const NEAR_ZERO_BAND_M: f64 = 0.2;

/// How many states to draw.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ValueErrorSettings {
    /// States outside the failure disc for the error, e.g. 100,000.
    pub states: usize,
    /// States outside the failure disc for the two shares, e.g. 1,000,000: the unsafe shell is a percent or two of the box.
    pub shell_states: usize,
    /// Seed.
    pub seed: u64,
}

/// Error of the model against the truth, on states drawn uniformly from the trained box where `ℓ > 0`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ValueErrorRecord {
    /// What was taken for true.
    pub truth: String,
    /// What was drawn.
    pub settings: ValueErrorSettings,
    /// States that the truth did not cover; they count nowhere.
    pub states_not_covered: u64,
    /// Error `h − V` everywhere.
    pub error: ErrorSummary,
    /// Half width of the band about the zero level, m.
    pub near_zero_band_m: f64,
    /// Error where `|V|` is below that.
    pub near_zero: ErrorSummary,
    /// Share of the true unsafe shell (`V < 0 < ℓ`) that the model calls safe (`h ≥ 0`).
    pub shell_called_safe: Share,
    /// Lowest true value among these, m; zero where there is none.
    pub shell_called_safe_worst_m: f64,
    /// The state with it.
    pub shell_called_safe_worst_state: Option<[f64; 4]>,
    /// Share of the true safe set (`V ≥ 0`) that the model calls unsafe.
    pub safe_called_unsafe: Share,
}

/// States per piece of work.
const PIECE: usize = 2048;

/// Draws `total` states outside failure and returns `(z, h, V)` of each that the truth covers, and how many it does not.
fn compare<T: Send>(
    subject: &Subject<'_>,
    truth: &dyn TrueValue,
    phase: (Phase, u64),
    total: usize,
    progress: OnProgress<'_>,
    reduce: impl Fn(Vec<([f64; 4], f64, f64)>) -> T + Sync,
) -> Result<(Vec<T>, u64), VerificationError> {
    let pieces = subject.in_pieces(phase, (total, PIECE), progress, |judge, count| {
        let drawn: Vec<[f64; 4]> = (0..count).map(|_| subject.draw_outside_failure(&mut judge.rng)).collect();
        let samples = judge.evaluate_values(&drawn);
        let covered: Vec<_> = drawn
            .iter()
            .zip(samples)
            .filter_map(|(z, sample)| truth.value_m(z).map(|value| (*z, sample.h_bar, value)))
            .collect();
        let missing = (count - covered.len()) as u64;
        (reduce(covered), missing)
    })?;
    let missing = pieces.iter().map(|(_, missing)| missing).sum();
    if missing == total as u64 {
        return Err(VerificationError::NothingCovered { states: total });
    }
    Ok((pieces.into_iter().map(|(found, _)| found).collect(), missing))
}

/// The sides of the zero level, counted.
#[derive(Debug, Clone, Copy)]
struct Sides {
    shell: usize,
    called_safe: usize,
    safe: usize,
    called_unsafe: usize,
    worst: Option<([f64; 4], f64)>,
}

impl Sides {
    const NONE: Self = Self { shell: 0, called_safe: 0, safe: 0, called_unsafe: 0, worst: None };

    fn count(mut self, (z, h_m, value_m): &([f64; 4], f64, f64)) -> Self {
        // A NaN is not called unsafe by the filter, so it counts as called safe.
        let called_unsafe = *h_m < 0.0;
        if *value_m < 0.0 {
            self.shell += 1;
            if !called_unsafe {
                self.called_safe += 1;
                self.worst = deeper(self.worst, Some((*z, *value_m)));
            }
        } else {
            self.safe += 1;
            self.called_unsafe += usize::from(called_unsafe);
        }
        self
    }

    fn join(self, other: &Self) -> Self {
        Self {
            shell: self.shell + other.shell,
            called_safe: self.called_safe + other.called_safe,
            safe: self.safe + other.safe,
            called_unsafe: self.called_unsafe + other.called_unsafe,
            worst: deeper(self.worst, other.worst),
        }
    }
}

fn deeper(a: Option<([f64; 4], f64)>, b: Option<([f64; 4], f64)>) -> Option<([f64; 4], f64)> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if b.1 < a.1 { b } else { a }),
        (found, None) | (None, found) => found,
    }
}

/// Compares the model with `truth`.
///
/// # Errors
/// * [`VerificationError::AnotherGame`] for a truth of another game, [`VerificationError::NothingCovered`] for one elsewhere.
/// * [`VerificationError::Stopped`].
pub fn measure_value_error(
    subject: &Subject<'_>,
    truth: &dyn TrueValue,
    settings: &ValueErrorSettings,
    progress: OnProgress<'_>,
) -> Result<ValueErrorRecord, VerificationError> {
    truth.check_fits(subject.model().metadata())?;
    let phase = (Phase::ValueError, settings.seed);
    let (errors, missing) = compare(subject, truth, phase, settings.states, progress, |covered| {
        covered.iter().map(|(_, h_m, value_m)| (*value_m, h_m - value_m)).collect::<Vec<_>>()
    })?;
    let errors: Vec<(f64, f64)> = errors.into_iter().flatten().collect();
    let near = errors.iter().filter(|(value_m, _)| value_m.abs() < NEAR_ZERO_BAND_M);

    let phase = (Phase::Shell, settings.seed);
    let (sides, missing_shell) =
        compare(subject, truth, phase, settings.shell_states, progress, |covered| {
            covered.iter().fold(Sides::NONE, Sides::count)
        })?;
    let sides = sides.iter().fold(Sides::NONE, Sides::join);

    Ok(ValueErrorRecord {
        truth: truth.description(),
        settings: *settings,
        states_not_covered: missing + missing_shell,
        error: ErrorSummary::of(&errors.iter().map(|(_, error)| *error).collect::<Vec<_>>()),
        near_zero_band_m: NEAR_ZERO_BAND_M,
        near_zero: ErrorSummary::of(&near.map(|(_, error)| *error).collect::<Vec<_>>()),
        shell_called_safe: Share::new(sides.called_safe, sides.shell),
        shell_called_safe_worst_m: sides.worst.map_or(0.0, |(_, value_m)| value_m),
        shell_called_safe_worst_state: sides.worst.map(|(z, _)| z),
        safe_called_unsafe: Share::new(sides.called_unsafe, sides.safe),
    })
}
