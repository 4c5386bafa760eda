//! (a) The structural property: the safe set never meets the failure set, for every state, whatever was learned.
//!
//! Not here: whether the safe set is right where it is (`value_error`, `condition`).

use barrier::{InputEncoding, RelativeSample};
use rand::RngExt;
use serde::{Deserialize, Serialize};

use crate::error::VerificationError;
use crate::subject::{OnProgress, Phase, Subject};

/// Why the property holds at all states, not only the sampled ones.
pub const STRUCTURAL_ARGUMENT: &str = "h = l - r with r = softplus(y) = max(y, 0) + ln(1 + exp(-|y|)). Both summands are >= 0 for every y, \
in f32 as well: the second is evaluated as a product and a sum of numbers >= 0, and rounding keeps signs. l - r is subtracted in f64, \
where rounding keeps order, so h <= l. States outside the trained box take r from the nearest state inside, so it holds there too. \
Parameters are finite and sines bounded, so y is finite. Hence l < 0 implies h < 0: no state of the failure set is called safe.";

/// Arguments of sines up to here are reduced to a quarter turn without overflow, rad.
const LARGEST_ARGUMENT_RAD: f64 = 1e5;

/// What was checked about `h̄ ≤ ℓ`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StructuralRecord {
    /// [`STRUCTURAL_ARGUMENT`] of the version that judged.
    pub argument: String,
    /// Whether every parameter is finite.
    pub parameters_finite: bool,
    /// Bound on the argument of every sine over the trained box, by interval arithmetic, rad.
    pub sine_argument_bound_rad: f64,
    /// Bound on the residual over all states: softplus of the last layer's bias plus its absolute weights, m.
    pub residual_bound_m: f64,
    /// States at which the kernel was run: inside the failure disc, and in a box twice the trained one.
    pub states: u64,
    /// Of these, states with `ℓ < 0`.
    pub states_in_failure: u64,
    /// States where `h ≤ ℓ` did not hold, a NaN included. Must be zero.
    pub above_failure_function: u64,
    /// States with `ℓ < 0` where `h < 0` did not hold, a NaN included. Must be zero.
    pub failure_called_safe: u64,
    /// Smallest residual met, m.
    pub residual_min_m: f64,
    /// Whether all of it holds.
    pub holds: bool,
}

/// States per piece of work.
const PIECE: usize = 4096;

/// Counts over evaluated states.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Tally {
    states: u64,
    in_failure: u64,
    above: u64,
    called_safe: u64,
    residual_min_m: f64,
}

impl Tally {
    const EMPTY: Self =
        Self { states: 0, in_failure: 0, above: 0, called_safe: 0, residual_min_m: f64::INFINITY };

    fn count(mut self, sample: &RelativeSample) -> Self {
        let below = sample.h_bar <= sample.sdf; // false for a NaN
        let called_unsafe = sample.h_bar < 0.0;
        self.states += 1;
        self.above += u64::from(!below);
        if sample.sdf < 0.0 {
            self.in_failure += 1;
            self.called_safe += u64::from(!called_unsafe);
        }
        self.residual_min_m = self.residual_min_m.min(sample.sdf - sample.h_bar);
        self
    }

    fn join(self, other: &Self) -> Self {
        Self {
            states: self.states + other.states,
            in_failure: self.in_failure + other.in_failure,
            above: self.above + other.above,
            called_safe: self.called_safe + other.called_safe,
            residual_min_m: self.residual_min_m.min(other.residual_min_m),
        }
    }
}

/// Checks `h̄ ≤ ℓ` and its premises on `states` states, half of them in the failure disc.
///
/// # Errors
/// * [`VerificationError::Stopped`].
pub fn check_structure(
    subject: &Subject<'_>,
    states: usize,
    seed: u64,
    progress: OnProgress<'_>,
) -> Result<StructuralRecord, VerificationError> {
    let pieces = subject.in_pieces((Phase::Structure, seed), (states, PIECE), progress, |judge, count| {
        let drawn: Vec<[f64; 4]> = (0..count)
            .map(|index| {
                let mut z = subject.draw(&mut judge.rng);
                if index % 2 == 0 {
                    let distance_m = subject.radius_m() * judge.rng.random_range(0.0_f64..1.0).sqrt();
                    let angle = judge.rng.random_range(-std::f64::consts::PI..std::f64::consts::PI);
                    (z[0], z[1]) = (distance_m * angle.cos(), distance_m * angle.sin());
                } else {
                    z = z.map(|component| 2.0 * component);
                }
                z
            })
            .collect();
        judge.evaluate_values(&drawn).iter().fold(Tally::EMPTY, Tally::count)
    })?;
    let tally = pieces.iter().fold(Tally::EMPTY, Tally::join);
    Ok(record(subject, &tally))
}

fn record(subject: &Subject<'_>, tally: &Tally) -> StructuralRecord {
    let layers = subject.model().weights().layers();
    let parameters_finite = layers
        .iter()
        .all(|layer| layer.weight.iter().chain(&layer.bias).all(|parameter| parameter.is_finite()));
    let (sine_argument_bound_rad, last) = bounds(subject);
    let residual_bound_m = last.max(0.0) + (-last.abs()).exp().ln_1p();
    StructuralRecord {
        argument: STRUCTURAL_ARGUMENT.to_owned(),
        parameters_finite,
        sine_argument_bound_rad,
        residual_bound_m,
        states: tally.states,
        states_in_failure: tally.in_failure,
        above_failure_function: tally.above,
        failure_called_safe: tally.called_safe,
        residual_min_m: tally.residual_min_m,
        holds: parameters_finite
            && sine_argument_bound_rad < LARGEST_ARGUMENT_RAD
            && residual_bound_m.is_finite()
            && tally.above == 0
            && tally.called_safe == 0,
    }
}

/// Bounds of the sines' arguments and of the last layer's output over the trained box.
fn bounds(subject: &Subject<'_>) -> (f64, f64) {
    let grid = &subject.model().metadata().grid;
    let largest = |axis: usize| grid.min[axis].abs().max(grid.max[axis].abs());
    let mut inputs = match subject.model().weights().encoding() {
        InputEncoding::Raw => (0..4).map(largest).collect(),
        InputEncoding::HeadingCosSin => vec![largest(0), largest(1), 1.0, 1.0, largest(3)],
        InputEncoding::Position => vec![largest(0), largest(1)],
    };
    let layers = subject.model().weights().layers();
    let (mut sines, mut last) = (0.0_f64, f64::NEG_INFINITY);
    for (index, layer) in layers.iter().enumerate() {
        let outputs = layer.bias.iter().zip(layer.weight.chunks(inputs.len())).map(|(&bias, row)| {
            let spread: f64 = row.iter().zip(&inputs).map(|(&w, a)| f64::from(w).abs() * a).sum();
            (f64::from(bias), spread)
        });
        if index + 1 == layers.len() {
            last = outputs.fold(last, |last, (bias, spread)| last.max(bias + spread));
        } else {
            sines = outputs.fold(sines, |sines, (bias, spread)| sines.max(bias.abs() + spread));
            inputs = vec![1.0; layer.bias.len()];
        }
    }
    (sines, last)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(h_bar: f64, sdf: f64) -> RelativeSample {
        RelativeSample { h_bar, sdf, ..RelativeSample::default() }
    }

    #[test]
    fn a_value_above_the_failure_function_is_counted() {
        let tally =
            Tally::EMPTY.count(&sample(0.3, 0.2)).count(&sample(0.1, 0.2)).count(&sample(-0.1, -0.05));
        assert_eq!((tally.states, tally.above, tally.called_safe, tally.in_failure), (3, 1, 0, 1));
    }

    #[test]
    fn a_failure_state_called_safe_is_counted() {
        let tally = Tally::EMPTY.count(&sample(0.0, -0.2));
        assert_eq!((tally.above, tally.called_safe), (1, 1));
    }

    #[test]
    fn a_nan_is_a_violation_of_both() {
        let tally = Tally::EMPTY.count(&sample(f64::NAN, -0.2));
        assert_eq!((tally.above, tally.called_safe), (1, 1));
    }
}
