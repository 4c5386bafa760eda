//! Bounds of one box's Taylor models, as plain numbers: the last step, once per box.

use super::form::{AXES, PAIRS, PRODUCTS};
use super::rounding::ROUNDING;

/// A Taylor model of order two of one box; see `form::Form`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Quadratic {
    pub(crate) centre: f64,
    pub(crate) linear: [f64; AXES],
    pub(crate) quadratic: [f64; PRODUCTS],
    pub(crate) radius: f64,
}

impl Quadratic {
    /// Returns `self + factor · other`.
    pub(crate) fn plus(&self, factor: f64, other: &Self) -> Self {
        Self {
            centre: self.centre + factor * other.centre,
            linear: core::array::from_fn(|i| self.linear[i] + factor * other.linear[i]),
            quadratic: core::array::from_fn(|k| self.quadratic[k] + factor * other.quadratic[k]),
            // The operands' radii cover this map's rounding (see `form`); two more roundings are its own.
            radius: (self.radius + factor.abs() * other.radius) * (1.0 + 4.0 * f64::EPSILON),
        }
    }

    /// Returns a number that the quantity is nowhere below, or no number where nothing is known.
    pub(crate) fn lower_bound(&self) -> f64 {
        let mut size = self.centre.abs() + self.radius;
        let mut bound = self.centre - self.radius;
        for (k, (i, j)) in PAIRS.into_iter().enumerate() {
            let (q, g) = (self.quadratic[k], self.linear[i].abs());
            size += q.abs();
            if i != j {
                bound -= q.abs();
                continue;
            }
            size += g;
            // The minimum of g e + q e² over |e| ≤ 1.
            bound -= if g < 2.0 * q { 0.25 * g * g / q } else { g - q };
        }
        bound - ROUNDING * size
    }

    /// Returns a number that the quantity is nowhere above.
    pub(crate) fn upper_bound(&self) -> f64 {
        let zero = Self { centre: 0.0, linear: [0.0; AXES], quadratic: [0.0; PRODUCTS], radius: 0.0 };
        -zero.plus(-1.0, self).lower_bound()
    }

    /// Returns a number that the quantity is nowhere below where `constraint ≥ 0`, and the Taylor model that shows it.
    ///
    /// For every `λ ≥ 0` a lower bound of `self − λ constraint` is one. The bound's linear part bends where a
    /// coefficient vanishes, so those `λ` are tried.
    pub(crate) fn lower_bound_where(&self, constraint: &Self) -> (f64, Self) {
        let mut best = (self.lower_bound(), *self);
        for i in 0..AXES {
            let multiplier = self.linear[i] / constraint.linear[i];
            if multiplier > 0.0 && multiplier.is_finite() {
                let difference = self.plus(-multiplier, constraint);
                let bound = difference.lower_bound();
                if bound > best.0 {
                    best = (bound, difference);
                }
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;

    fn random(rng: &mut Pcg64) -> Quadratic {
        Quadratic {
            centre: rng.random_range(-1.0..1.0),
            linear: core::array::from_fn(|_| rng.random_range(-1.0..1.0)),
            quadratic: core::array::from_fn(|_| rng.random_range(-0.5..0.5)),
            radius: rng.random_range(0.0..0.1),
        }
    }

    fn at(of: &Quadratic, e: &[f64; AXES]) -> f64 {
        let linear: f64 = (0..AXES).map(|i| of.linear[i] * e[i]).sum();
        of.centre + linear + PAIRS.iter().zip(of.quadratic).map(|((i, j), q)| q * e[*i] * e[*j]).sum::<f64>()
    }

    #[test]
    fn bounds_hold_at_sampled_states_with_and_without_a_constraint() {
        let mut rng = Pcg64::seed_from_u64(1);
        let mut raised = 0;
        for _ in 0..5_000 {
            let (of, constraint) = (random(&mut rng), random(&mut rng));
            let (lower, upper) = (of.lower_bound(), of.upper_bound());
            let (where_positive, _) = of.lower_bound_where(&constraint);
            raised += usize::from(where_positive > lower + 0.1);
            for _ in 0..50 {
                let e = core::array::from_fn(|_| {
                    if rng.random::<bool>() { rng.random_range(-1.0..=1.0) } else { 1.0 }
                });
                let value = at(&of, &e);
                assert!(lower <= value - of.radius && value + of.radius <= upper);
                if at(&constraint, &e) + constraint.radius >= 0.0 {
                    assert!(where_positive <= value - of.radius);
                }
            }
        }
        assert!(raised > 500, "the constraint raised only {raised} bounds");
    }

    #[test]
    fn what_is_no_number_has_no_bound() {
        let mut of = random(&mut Pcg64::seed_from_u64(2));
        of.quadratic[3] = f64::NAN;
        assert!(of.lower_bound().is_nan() && of.upper_bound().is_nan());
        assert!(of.lower_bound_where(&of).0.is_nan());
    }
}
