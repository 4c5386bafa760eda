//! Taylor models of order two: what is known about a quantity on a box, and arithmetic that keeps it true.
//!
//! Not here: functions of one variable (`elementary`), whole layers (`layer`), and what a bound is used for.

// Vector code must melt into the function that enabled the instruction set, or every operation becomes a call.
#![allow(clippy::inline_always)]

use pulp::Simd;

use super::rounding::{ROUNDING, WIDEN};

/// Coordinates of a box.
pub(crate) const AXES: usize = 4;
/// Products `eᵢ eⱼ` with `i ≤ j`.
pub(crate) const PRODUCTS: usize = 10;
/// The pairs `(i, j)` in the order of the quadratic coefficients.
pub(crate) const PAIRS: [(usize, usize); PRODUCTS] =
    [(0, 0), (0, 1), (0, 2), (0, 3), (1, 1), (1, 2), (1, 3), (2, 2), (2, 3), (3, 3)];

/// A quantity on a box of states: for `e ∈ [−1, 1]⁴`, the box's own coordinates, the quantity lies within `radius` of
/// `centre + Σ linear[i] eᵢ + Σ quadratic[k] eᵢ eⱼ`. One box per lane.
///
/// The radius covers the rounding of everything computed so far and of one linear map to come, whose rounding is
/// relative to the sum of the coefficients' absolute values.
#[derive(Clone, Copy)]
pub(crate) struct Form<S: Simd> {
    pub(crate) centre: S::f64s,
    pub(crate) linear: [S::f64s; AXES],
    pub(crate) quadratic: [S::f64s; PRODUCTS],
    pub(crate) radius: S::f64s,
}

/// Derivatives of a function at a form's centre, and what they are uncertain by.
pub(crate) struct Derivatives<S: Simd> {
    /// Value, first and second derivative at the centre.
    pub(crate) at_centre: [S::f64s; 3],
    /// Bound of the third derivative's absolute value over the whole range.
    pub(crate) third: S::f64s,
    /// Sizes the widening of each of the three is relative to: at least their absolute values.
    pub(crate) sizes: [S::f64s; 3],
}

/// Absolute sums of a form's parts.
pub(crate) struct Reach<S: Simd> {
    /// `Σ |linear|`.
    pub(crate) linear: S::f64s,
    /// `Σ |quadratic| + radius`: how far the form is from being affine.
    pub(crate) bend: S::f64s,
    /// Largest distance from the centre.
    pub(crate) total: S::f64s,
}

impl<S: Simd> Form<S> {
    /// A number without uncertainty, one per lane.
    #[inline(always)]
    pub(crate) fn constant(simd: S, value: S::f64s) -> Self {
        let zero = simd.splat_f64s(0.0);
        Self { centre: value, linear: [zero; AXES], quadratic: [zero; PRODUCTS], radius: zero }
            .with_rounding(simd)
    }

    /// The state component `axis` of the boxes with these centres and half-widths.
    #[inline(always)]
    pub(crate) fn coordinate(simd: S, axis: usize, centre: S::f64s, half_width: S::f64s) -> Self {
        let mut form = Self::constant(simd, centre);
        form.linear[axis] = half_width;
        form.with_rounding(simd)
    }

    /// Absolute sums of the parts.
    #[inline(always)]
    pub(crate) fn reach(&self, simd: S) -> Reach<S> {
        let mut linear = simd.abs_f64s(self.linear[0]);
        for coefficient in &self.linear[1..] {
            linear = simd.add_f64s(linear, simd.abs_f64s(*coefficient));
        }
        let mut quadratic = simd.abs_f64s(self.quadratic[0]);
        for coefficient in &self.quadratic[1..] {
            quadratic = simd.add_f64s(quadratic, simd.abs_f64s(*coefficient));
        }
        let bend = simd.add_f64s(quadratic, self.radius);
        Reach { linear, bend, total: simd.add_f64s(linear, bend) }
    }

    /// Widens by the rounding of a short sum that made this form and of the linear map to come.
    #[inline(always)]
    fn with_rounding(mut self, simd: S) -> Self {
        let reach = self.reach(simd);
        let size = simd.add_f64s(simd.abs_f64s(self.centre), reach.total);
        self.radius = simd.mul_add_f64s(simd.splat_f64s(ROUNDING), size, self.radius);
        self
    }

    /// Returns `self · factor + other`.
    #[inline(always)]
    pub(crate) fn scaled_plus(&self, simd: S, factor: S::f64s, other: &Self) -> Self {
        let mut sum = *other;
        sum.centre = simd.mul_add_f64s(factor, self.centre, sum.centre);
        for i in 0..AXES {
            sum.linear[i] = simd.mul_add_f64s(factor, self.linear[i], sum.linear[i]);
        }
        for k in 0..PRODUCTS {
            sum.quadratic[k] = simd.mul_add_f64s(factor, self.quadratic[k], sum.quadratic[k]);
        }
        let radius = simd.mul_add_f64s(simd.abs_f64s(factor), self.radius, sum.radius);
        // The terms' own sizes, not the sum's, bound its rounding; each radius holds ROUNDING times its own size.
        sum.radius = simd.mul_f64s(radius, simd.splat_f64s(1.0 + 2.0 * ROUNDING));
        sum.with_rounding(simd)
    }

    /// Returns `self − other`.
    #[inline(always)]
    pub(crate) fn minus(&self, simd: S, other: &Self) -> Self {
        other.scaled_plus(simd, simd.splat_f64s(-1.0), self)
    }

    /// Returns `self + other`.
    #[inline(always)]
    pub(crate) fn plus(&self, simd: S, other: &Self) -> Self {
        other.scaled_plus(simd, simd.splat_f64s(1.0), self)
    }

    /// Returns `self · other`; products of order three and four go into the radius.
    #[inline(always)]
    pub(crate) fn times(&self, simd: S, other: &Self) -> Self {
        let (a, b) = (self.reach(simd), other.reach(simd));
        let (p, q) = (self.centre, other.centre);
        let linear =
            core::array::from_fn(|i| simd.mul_add_f64s(p, other.linear[i], simd.mul_f64s(q, self.linear[i])));
        let quadratic = core::array::from_fn(|k| {
            let (i, j) = PAIRS[k];
            let sum = simd.mul_add_f64s(p, other.quadratic[k], simd.mul_f64s(q, self.quadratic[k]));
            let sum = simd.mul_add_f64s(self.linear[i], other.linear[j], sum);
            if i == j { sum } else { simd.mul_add_f64s(self.linear[j], other.linear[i], sum) }
        });
        let (abs_p, abs_q) = (simd.abs_f64s(p), simd.abs_f64s(q));
        let mut radius = simd.mul_add_f64s(abs_p, other.radius, simd.mul_f64s(abs_q, self.radius));
        radius = simd.mul_add_f64s(a.linear, b.bend, radius);
        radius = simd.mul_add_f64s(a.bend, simd.add_f64s(b.linear, b.bend), radius);
        let size = simd.mul_f64s(simd.add_f64s(abs_p, a.total), simd.add_f64s(abs_q, b.total));
        let rounding = simd.mul_f64s(simd.splat_f64s(3.0 * ROUNDING), size);
        Self {
            centre: simd.mul_f64s(p, q),
            linear,
            quadratic,
            radius: simd.mul_add_f64s(radius, simd.splat_f64s(WIDEN), rounding),
        }
    }

    /// Returns `f(self)` by Taylor's theorem of order two with Lagrange's remainder.
    ///
    /// With `self = c + δ`, `δ = g·e + b`, `|g·e| ≤ G`, `|b| ≤ B`:
    /// `f(c + δ) = f + f' δ + ½ f'' ((g·e)² + b (2 g·e + b)) + ⅙ f'''(ξ) δ³`.
    #[inline(always)]
    pub(crate) fn composed(&self, simd: S, reach: &Reach<S>, f: &Derivatives<S>) -> Self {
        let [value, slope, curvature] = f.at_centre;
        let half_curvature = simd.mul_f64s(simd.splat_f64s(0.5), curvature);
        let linear = core::array::from_fn(|i| simd.mul_f64s(slope, self.linear[i]));
        let bent: [S::f64s; AXES] = core::array::from_fn(|i| simd.mul_f64s(half_curvature, self.linear[i]));
        let quadratic = core::array::from_fn(|k| {
            let (i, j) = PAIRS[k];
            let product = simd.mul_f64s(bent[i], self.linear[j]);
            let square = if i == j { product } else { simd.add_f64s(product, product) };
            simd.mul_add_f64s(slope, self.quadratic[k], square)
        });
        let d = reach.total;
        let d2 = simd.mul_f64s(d, d);
        let cubic = simd.mul_f64s(simd.splat_f64s(1.0 / 6.0), simd.mul_f64s(d2, d));
        let twice = simd.add_f64s(reach.linear, d);
        let mut radius = simd.mul_f64s(simd.abs_f64s(slope), self.radius);
        radius = simd.mul_add_f64s(simd.abs_f64s(half_curvature), simd.mul_f64s(reach.bend, twice), radius);
        radius = simd.mul_add_f64s(f.third, cubic, radius);
        let mut size = simd.mul_add_f64s(f.sizes[1], d, f.sizes[0]);
        size = simd.mul_add_f64s(f.sizes[2], d2, size);
        let rounding = simd.mul_f64s(simd.splat_f64s(3.0 * ROUNDING), size);
        Self {
            centre: value,
            linear,
            quadratic,
            radius: simd.mul_add_f64s(radius, simd.splat_f64s(WIDEN), rounding),
        }
    }
}

#[cfg(test)]
#[path = "form_tests.rs"]
mod form_tests;
