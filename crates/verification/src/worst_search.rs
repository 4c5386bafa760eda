//! From the worst sampled states to worse ones: random steps that keep what is better and adapt their length.
//!
//! Makes the reported worst value honest; it is still not a bound.

use rand_distr::{Distribution, StandardNormal};

use crate::condition::{ConditionSettings, Point, points};
use crate::error::VerificationError;
use crate::subject::{OnProgress, Phase, Subject};

/// Where the search begins.
pub(crate) struct Start {
    /// States with `h ≥ 0`; at least one.
    pub(crate) points: Vec<Point>,
    /// α, 1/s.
    pub(crate) alpha_per_s: f64,
}

/// First step length, as a share of each axis.
const FIRST_STEP: f64 = 0.02;
/// A shorter step has settled; the search begins anew around what it found.
const LAST_STEP: f64 = 1e-5;
/// Growth of a step that succeeded and shrinkage of one that did not: steady at one success in five.
const GROWTH: f64 = 1.5;
const SHRINKAGE: f64 = 0.903_602_0;

/// Minimises C over `{h ≥ 0, ℓ > 0}` in the trained box by a (1+1) evolution strategy from every start at once.
///
/// # Errors
/// * [`VerificationError::Stopped`].
pub(crate) fn search_worst(
    subject: &Subject<'_>,
    start: &Start,
    settings: &ConditionSettings,
    progress: OnProgress<'_>,
) -> Result<Point, VerificationError> {
    let grid = &subject.model().metadata().grid;
    // The starts are few: one piece each, so that the result does not depend on how pieces are scheduled.
    let cursor: Vec<usize> = (0..start.points.len()).collect();
    let phase = (Phase::WorstCondition, settings.seed);
    let found = subject.in_pieces(phase, (1, 1), progress, |judge, _| {
        let mut best = start.points.clone();
        let mut step = vec![FIRST_STEP; best.len()];
        for _ in 0..settings.search_steps {
            let tried: Vec<[f64; 4]> = cursor
                .iter()
                .map(|&index| {
                    let mut z = best[index].z;
                    for axis in 0..4 {
                        let normal: f64 = StandardNormal.sample(&mut judge.rng);
                        z[axis] += normal * step[index] * (grid.max[axis] - grid.min[axis]);
                    }
                    subject.model().domain().place(&z).z
                })
                .collect();
            for (index, point) in points(subject, judge, &tried).into_iter().enumerate() {
                let admissible = point.h_m >= 0.0 && point.outside_failure;
                let condition = |point: &Point| point.condition_mps(start.alpha_per_s);
                if admissible && condition(&point) < condition(&best[index]) {
                    best[index] = point;
                    step[index] *= GROWTH;
                } else {
                    step[index] *= SHRINKAGE;
                    if step[index] < LAST_STEP {
                        step[index] = FIRST_STEP;
                    }
                }
            }
        }
        best
    })?;
    let condition = |point: &Point| point.condition_mps(start.alpha_per_s);
    let best = found.into_iter().flatten().min_by(|a, b| condition(a).total_cmp(&condition(b)));
    Ok(best.unwrap_or(start.points[0]))
}
