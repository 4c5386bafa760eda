//! (c) The CBF condition under the worst admissible obstacle: `C(z) = max_u min_d ∇h·ζ(z, u, d) + α h ≥ 0`.
//!
//! Sampled, with the kernel that runs on board, then sharpened by a search from the worst states (`worst_search`). Not here: a
//! proof over whole boxes (`affine`).

use serde::{Deserialize, Serialize};

use crate::error::{VerificationError, require_positive};
use crate::inflation::violation_free_inflation;
use crate::statistics::{Share, quantile};
use crate::subject::{Judge, OnProgress, Phase, Subject};
use crate::worst_search::{Start, search_worst};

/// Half width of the band about the zero level that is counted apart, m.
pub const BAND_M: f64 = 0.05;

/// Largest radius inflation that is looked for, m.
pub const LARGEST_INFLATION_M: f64 = 0.5;

/// What to draw and for which gain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConditionSettings {
    /// Class-κ gain α of the filter, 1/s.
    pub alpha_per_s: f64,
    /// States outside the failure disc, e.g. 1,000,000.
    pub states: usize,
    /// Steps of the search for the worst state, e.g. 400.
    pub search_steps: usize,
    /// Seed.
    pub seed: u64,
}

/// How well the model meets the CBF condition, on states drawn uniformly from the trained box where `ℓ > 0`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConditionRecord {
    /// What was drawn.
    pub settings: ConditionSettings,
    /// Half width of the bands, m.
    pub band_m: f64,
    /// Share of `{h ≥ 0}` with `C < 0`.
    pub violated_safe: Share,
    /// Share of `{0 ≤ h < band}` with `C < 0`.
    pub violated_band_above: Share,
    /// Share of `{|h| < band}` with `C < 0`.
    pub violated_band: Share,
    /// C on `{h ≥ 0}`, m/s: its quantiles 0.001, 0.01, 0.1 and 0.5.
    pub quantiles_safe_mps: [f64; 4],
    /// C on `{0 ≤ h < band}`, m/s: its quantiles 0.001, 0.01, 0.1 and 0.5.
    pub quantiles_band_above_mps: [f64; 4],
    /// Lowest C among the sampled states with `h ≥ 0`, m/s.
    pub worst_sampled_mps: f64,
    /// Lowest C that the search found with `h ≥ 0`, m/s. Not a bound: a lower one may exist.
    pub worst_mps: f64,
    /// The state with it.
    pub worst_state: [f64; 4],
    /// `h` there, m.
    pub worst_h_m: f64,
    /// `ε = max(0, −worst)`, m/s: on the zero level h falls no faster than this.
    pub epsilon_mps: f64,
    /// `ε/α`, m: how far h falls below zero at most while `C ≥ −ε`, hence the radius inflation that covers it.
    pub inflation_m: f64,
    /// Lowest C on `−ε/α ≤ h < 0`, contact included, m/s, as sampled; zero where no state there has a lower one.
    pub worst_below_zero_mps: f64,
    /// Whether `C ≥ −ε` there too, which the cover by ε/α needs. Where it is false, ε is a rate, not a cover.
    pub inflation_covers: bool,
    /// Smallest radius inflation, m, at which no sampled state violates the condition; none up to [`LARGEST_INFLATION_M`].
    ///
    /// With radius `R + c` the model is `h − c`, so the condition is asked of `h ≥ c` only, but with `α (h − c)`.
    pub violation_free_inflation_m: Option<f64>,
}

/// One state with its barrier and condition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    pub(crate) z: [f64; 4],
    pub(crate) h_m: f64,
    /// `ℓ > 0`.
    pub(crate) outside_failure: bool,
    /// `max_u min_d ∇h·ζ`, m/s.
    pub(crate) hamiltonian_mps: f64,
}

impl Point {
    /// Returns `C`, m/s.
    pub(crate) fn condition_mps(&self, alpha_per_s: f64) -> f64 {
        self.hamiltonian_mps + alpha_per_s * self.h_m
    }
}

/// Evaluates barrier and Hamiltonian at `states`.
pub(crate) fn points(subject: &Subject<'_>, judge: &mut Judge, states: &[[f64; 4]]) -> Vec<Point> {
    let samples = judge.evaluate(states);
    let point = |(z, sample): (&[f64; 4], &barrier::RelativeSample)| Point {
        z: *z,
        h_m: sample.h_bar,
        outside_failure: sample.sdf > 0.0,
        hamiltonian_mps: subject.game().hamiltonian(z, &sample.gradient),
    };
    states.iter().zip(samples).map(point).collect()
}

/// Whether the condition fails; a NaN does.
pub(crate) fn violates(condition_mps: f64) -> bool {
    let met = condition_mps >= 0.0;
    !met
}

/// States per piece of work.
const PIECE: usize = 4096;

/// Measures the condition.
///
/// # Errors
/// * [`VerificationError::Setting`] unless α is positive.
/// * [`VerificationError::NoSafeState`] if no state drawn has `h ≥ 0`.
/// * [`VerificationError::Stopped`].
pub fn measure_condition(
    subject: &Subject<'_>,
    settings: &ConditionSettings,
    progress: OnProgress<'_>,
) -> Result<ConditionRecord, VerificationError> {
    let alpha_per_s = settings.alpha_per_s;
    require_positive("alpha_per_s", alpha_per_s)?;
    let phase = (Phase::Condition, settings.seed);
    let drawn = subject.in_pieces(phase, (settings.states, PIECE), progress, |judge, count| {
        let drawn = draw_with_contact(subject, judge, count);
        let mut found = points(subject, judge, &drawn);
        // States far below the zero level answer no question asked here.
        found.retain(|point| point.h_m >= -LARGEST_INFLATION_M);
        found
    })?;
    let starts = starts(&drawn, alpha_per_s);
    let all: Vec<Point> = drawn.into_iter().flatten().collect();
    let Some(sampled) = lowest(all.iter().filter(|point| point.h_m >= 0.0), alpha_per_s) else {
        return Err(VerificationError::NoSafeState { drawn: settings.states });
    };
    let searched = search_worst(subject, &Start { points: starts, alpha_per_s }, settings, progress)?;
    let worst = lowest([sampled, searched].iter(), alpha_per_s).unwrap_or(sampled);
    Ok(record(settings, &all, &sampled, &worst))
}

/// Draws `count` states outside the failure disc, and keeps those within it that the draw hits: the cover by a larger radius is a
/// statement about states below the zero level, some of which are in contact.
fn draw_with_contact(subject: &Subject<'_>, judge: &mut Judge, count: usize) -> Vec<[f64; 4]> {
    let (mut drawn, mut outside) = (Vec::with_capacity(count + count / 8), 0);
    while outside < count {
        let z = subject.draw(&mut judge.rng);
        outside += usize::from(subject.failure_m(&z) > 0.0);
        drawn.push(z);
    }
    drawn
}

/// The worst safe state of each piece, lowest condition first: spread over the box because pieces are independent.
fn starts(pieces: &[Vec<Point>], alpha_per_s: f64) -> Vec<Point> {
    let mut worst: Vec<Point> = pieces
        .iter()
        .filter_map(|piece| lowest(piece.iter().filter(|point| point.h_m >= 0.0), alpha_per_s))
        .collect();
    worst.sort_by(|a, b| a.condition_mps(alpha_per_s).total_cmp(&b.condition_mps(alpha_per_s)));
    worst.truncate(barrier::MAX_OBSTACLES);
    worst
}

fn lowest<'a>(points: impl Iterator<Item = &'a Point>, alpha_per_s: f64) -> Option<Point> {
    points.min_by(|a, b| a.condition_mps(alpha_per_s).total_cmp(&b.condition_mps(alpha_per_s))).copied()
}

fn record(settings: &ConditionSettings, all: &[Point], sampled: &Point, worst: &Point) -> ConditionRecord {
    let alpha_per_s = settings.alpha_per_s;
    let within = |low: f64, high: f64| all.iter().filter(move |point| point.h_m >= low && point.h_m < high);
    let outside = |low: f64, high: f64| {
        let outside = within(low, high).filter(|point| point.outside_failure);
        outside.map(|point| point.condition_mps(alpha_per_s)).collect::<Vec<f64>>()
    };
    let share = |conditions: &[f64]| {
        Share::new(conditions.iter().filter(|condition| violates(**condition)).count(), conditions.len())
    };
    let (safe, above, band) = (outside(0.0, f64::INFINITY), outside(0.0, BAND_M), outside(-BAND_M, BAND_M));
    let worst_mps = worst.condition_mps(alpha_per_s);
    let epsilon_mps = (-worst_mps).max(0.0);
    let inflation_m = epsilon_mps / alpha_per_s;
    let below = within(-inflation_m, 0.0).map(|point| point.condition_mps(alpha_per_s));
    let worst_below_zero_mps = below.fold(0.0, f64::min);
    ConditionRecord {
        settings: *settings,
        band_m: BAND_M,
        violated_safe: share(&safe),
        violated_band_above: share(&above),
        violated_band: share(&band),
        quantiles_safe_mps: quantiles(safe),
        quantiles_band_above_mps: quantiles(above),
        worst_sampled_mps: sampled.condition_mps(alpha_per_s),
        worst_mps,
        worst_state: worst.z,
        worst_h_m: worst.h_m,
        epsilon_mps,
        inflation_m,
        worst_below_zero_mps,
        inflation_covers: worst_below_zero_mps >= -epsilon_mps,
        violation_free_inflation_m: violation_free_inflation(all, alpha_per_s, LARGEST_INFLATION_M),
    }
}

fn quantiles(mut values: Vec<f64>) -> [f64; 4] {
    values.sort_by(f64::total_cmp);
    [0.001, 0.01, 0.1, 0.5].map(|q| quantile(&values, q))
}
