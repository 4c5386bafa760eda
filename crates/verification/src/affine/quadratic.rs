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

    /// Returns a number that the quantity is nowhere below where `constraint ≥ 0`.
    ///
    /// For every `λ ≥ 0` a lower bound of `self − λ constraint` is one. The bound's linear part bends where a
    /// coefficient vanishes, so those `λ` are tried.
    pub(crate) fn lower_bound_where(&self, constraint: &Self) -> f64 {
        let mut best = self.lower_bound();
        for i in 0..AXES {
            let multiplier = self.linear[i] / constraint.linear[i];
            if multiplier > 0.0 && multiplier.is_finite() {
                let bound = self.plus(-multiplier, constraint).lower_bound();
                if bound > best {
                    best = bound;
                }
            }
        }
        best
    }
}
