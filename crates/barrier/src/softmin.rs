//! The aggregation `η` of the paper (eq. `eta`). Not here: what is aggregated (`composite`).

/// Returns `η(h̄₁, …, h̄_M) = −(1/β) ln Σ exp(−β h̄_i)`, a smooth under-approximation of the minimum.
///
/// `min − ln(M)/β ≤ η ≤ min`. Every value enters; the smallest is taken out of the exponent first, so
/// nothing overflows. Without values the result is `+∞`, the empty minimum. `beta_per_m` is β > 0, 1/m.
pub fn softmin(values: &[f64], beta_per_m: f64) -> f64 {
    let min = minimum(values);
    if !min.is_finite() {
        return min;
    }
    let sum: f64 = values.iter().map(|value| libm::exp(beta_per_m * (min - value))).sum();
    min - libm::log(sum) / beta_per_m
}

/// Returns [`softmin`] and writes its derivatives `w_i = ∂η/∂h̄_i = exp(−β h̄_i) / Σ exp(−β h̄_j)`.
///
/// The weights are positive or zero and sum to one.
///
/// # Panics
/// If `weights` is shorter than `values`.
pub fn softmin_weights(values: &[f64], beta_per_m: f64, weights: &mut [f64]) -> f64 {
    let min = minimum(values);
    let weights = &mut weights[..values.len()];
    let mut sum = 0.0;
    for (weight, value) in weights.iter_mut().zip(values) {
        *weight = libm::exp(beta_per_m * (min - value));
        sum += *weight;
    }
    for weight in weights {
        *weight /= sum;
    }
    if min.is_finite() { min - libm::log(sum) / beta_per_m } else { min }
}

/// The smallest value; NaN if any is NaN, `+∞` if there is none.
fn minimum(values: &[f64]) -> f64 {
    values.iter().fold(f64::INFINITY, |min, &value| if value < min || value.is_nan() { value } else { min })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_values_lie_the_logarithm_of_their_count_lower() {
        assert!((softmin(&[0.3; 20], 4.0) - (0.3 - 20.0_f64.ln() / 4.0)).abs() < 1e-15);
    }

    #[test]
    fn no_value_gives_plus_infinity() {
        assert_eq!(softmin(&[], 4.0), f64::INFINITY);
    }

    #[test]
    fn one_value_is_its_own_softmin() {
        assert_eq!(softmin(&[-0.25], 4.0), -0.25);
    }

    #[test]
    fn far_apart_values_neither_overflow_nor_vanish_wrongly() {
        let mut weights = [0.0; 3];
        assert_eq!(softmin_weights(&[-1e6, 0.0, 1e6], 4.0, &mut weights), -1e6);
        assert_eq!(weights, [1.0, 0.0, 0.0]);
    }

    #[test]
    fn a_nan_is_not_lost_behind_a_smaller_value() {
        assert!(softmin(&[1.0, f64::NAN, -1.0], 4.0).is_nan());
    }
}
