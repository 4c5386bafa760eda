//! Sine, cosine, square roots and softplus of Taylor models, with the errors of their own arithmetic.

#![allow(clippy::inline_always)] // see `form`

use core::f64::consts::{FRAC_1_PI, PI};

use pulp::Simd;

use super::form::{Derivatives, Form};
use super::rounding::{ROUNDING, WIDEN};

/// Adding this rounds to an integer.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// π minus its nearest `f64`.
const PI_LOW: f64 = 1.224_646_799_147_353_2e-16;
/// Most lanes of any vector.
pub(crate) const MOST_LANES: usize = 8;

/// Coefficients of Taylor's series `Σ (−1)ᵏ rᵏ⁺ᵏ / (offset + 2k)!`, k from 1.
const fn series<const N: usize>(offset: u64) -> [f64; N] {
    let mut coefficients = [0.0; N];
    let (mut k, mut value) = (0, 1.0);
    while k < N {
        let n = offset + 2 * (k as u64 + 1);
        value = -value / (n * (n - 1)) as f64;
        coefficients[k] = value;
        k += 1;
    }
    coefficients
}

/// `sin r = r (1 + r² S(r²))`; the next term is below 2e-18 for |r| ≤ 1.571.
const SIN: [f64; 10] = series(1);
/// `cos r = 1 + r² C(r²)`; the next term is below 2e-19 for |r| ≤ 1.571.
const COS: [f64; 11] = series(0);

/// `(sin x, cos x)`, absolute error below 2⁻⁴⁸ for |x| ≤ 1e9.
///
/// With `x = k π + r`, the fused steps err by `u |r|` each and by `k` times 3e-33, the part of π left out; the series
/// by what is stated above; Horner's rule by a few `u`, as its terms shrink.
#[inline(always)]
pub(crate) fn sin_cos<S: Simd>(simd: S, x: S::f64s) -> (S::f64s, S::f64s) {
    let k = simd.sub_f64s(
        simd.mul_add_f64s(x, simd.splat_f64s(FRAC_1_PI), simd.splat_f64s(ROUND)),
        simd.splat_f64s(ROUND),
    );
    let r = simd.mul_add_f64s(k, simd.splat_f64s(-PI), x);
    let r = simd.mul_add_f64s(k, simd.splat_f64s(-PI_LOW), r);
    let r2 = simd.mul_f64s(r, r);
    let mut sin = simd.splat_f64s(SIN[SIN.len() - 1]);
    for coefficient in SIN[..SIN.len() - 1].iter().rev() {
        sin = simd.mul_add_f64s(sin, r2, simd.splat_f64s(*coefficient));
    }
    let mut cos = simd.splat_f64s(COS[COS.len() - 1]);
    for coefficient in COS[..COS.len() - 1].iter().rev() {
        cos = simd.mul_add_f64s(cos, r2, simd.splat_f64s(*coefficient));
    }
    let one = simd.splat_f64s(1.0);
    let sin = simd.mul_add_f64s(simd.mul_f64s(sin, r2), r, r);
    let cos = simd.mul_add_f64s(cos, r2, one);
    // k − 2 round(k / 2) is −1, 0 or 1, so its square tells odd from even.
    let half = simd
        .sub_f64s(simd.mul_add_f64s(k, simd.splat_f64s(0.5), simd.splat_f64s(ROUND)), simd.splat_f64s(ROUND));
    let parity = simd.mul_add_f64s(half, simd.splat_f64s(-2.0), k);
    let sign = simd.mul_add_f64s(simd.mul_f64s(parity, parity), simd.splat_f64s(-2.0), one);
    (simd.mul_f64s(sin, sign), simd.mul_f64s(cos, sign))
}

impl<S: Simd> Form<S> {
    /// Returns `(sin self, cos self)`.
    #[inline(always)]
    pub(crate) fn sin_cos(&self, simd: S) -> (Self, Self) {
        let reach = self.reach(simd);
        let (sin, cos) = sin_cos(simd, self.centre);
        let one = simd.splat_f64s(1.0);
        let sizes = [one; 3];
        // The derivative of order three moves by at most the distance from the centre.
        let slack = simd.mul_add_f64s(reach.total, simd.splat_f64s(WIDEN), simd.splat_f64s(ROUNDING));
        let third = |at_centre| simd.min_f64s(one, simd.add_f64s(simd.abs_f64s(at_centre), slack));
        let minus = |value| simd.neg_f64s(value);
        let of_sin = Derivatives { at_centre: [sin, cos, minus(sin)], third: third(cos), sizes };
        let of_cos = Derivatives { at_centre: [cos, minus(sin), minus(cos)], third: third(sin), sizes };
        (self.composed(simd, &reach, &of_sin), self.composed(simd, &reach, &of_cos))
    }

    /// Returns `(√self, 1 / √self)` where `self ≥ at_least > 0`; elsewhere the radius is infinite or no number.
    #[inline(always)]
    pub(crate) fn square_roots(&self, simd: S, at_least: S::f64s) -> (Self, Self) {
        let reach = self.reach(simd);
        let one = simd.splat_f64s(1.0);
        let powers = |s: S::f64s| {
            let inverse = simd.div_f64s(one, s);
            let root = simd.sqrt_f64s(s);
            let inverse_root = simd.div_f64s(one, root);
            let p3 = simd.mul_f64s(inverse_root, inverse);
            let p5 = simd.mul_f64s(p3, inverse);
            [root, inverse_root, p3, p5, simd.mul_f64s(p5, inverse)]
        };
        let scaled = |factor: f64, value| simd.mul_f64s(simd.splat_f64s(factor), value);
        let [root, p1, p3, p5, _] = powers(self.centre);
        let [_, _, _, most5, most7] = powers(at_least);
        let derivatives = |at_centre: [S::f64s; 3], third| Derivatives {
            at_centre,
            third: scaled(WIDEN, third),
            sizes: at_centre.map(|value| simd.abs_f64s(value)),
        };
        let of_root = derivatives([root, scaled(0.5, p1), scaled(-0.25, p3)], scaled(0.375, most5));
        let of_inverse = derivatives([p1, scaled(-0.5, p3), scaled(0.75, p5)], scaled(1.875, most7));
        (self.composed(simd, &reach, &of_root), self.composed(simd, &reach, &of_inverse))
    }

    /// Returns `(softplus(self), its slope)`.
    ///
    /// The derivatives of the logistic function `p` are `p(1−p)`, `p(1−p)(1−2p)`, and for the third of softplus and of
    /// its slope at most 0.0963 and 0.125.
    #[inline(always)]
    pub(crate) fn softplus(&self, simd: S) -> (Self, Self) {
        let reach = self.reach(simd);
        let mut at = [0.0; MOST_LANES];
        let at = &mut at[..S::F64_LANES];
        simd.partial_store_f64s(at, self.centre);
        let mut derivatives = [[0.0; MOST_LANES]; 4];
        for (lane, y) in at.iter().enumerate() {
            // One exponential and one logarithm of the mathematics library: exact to a few units in the last place.
            let e = (-y.abs()).exp();
            let slope = if *y >= 0.0 { 1.0 / (1.0 + e) } else { e / (1.0 + e) };
            let curvature = e / ((1.0 + e) * (1.0 + e));
            derivatives[0][lane] = y.max(0.0) + e.ln_1p();
            derivatives[1][lane] = slope;
            derivatives[2][lane] = curvature;
            derivatives[3][lane] = curvature * (1.0 - 2.0 * slope);
        }
        let [value, slope, curvature, third] =
            derivatives.map(|lanes| simd.partial_load_f64s(&lanes[..S::F64_LANES]));
        let one = simd.splat_f64s(1.0);
        let of_value = Derivatives {
            at_centre: [value, slope, curvature],
            third: simd.splat_f64s(0.0963),
            sizes: [simd.add_f64s(one, value), one, one],
        };
        let of_slope = Derivatives {
            at_centre: [slope, curvature, third],
            third: simd.splat_f64s(0.125),
            sizes: [one; 3],
        };
        (self.composed(simd, &reach, &of_value), self.composed(simd, &reach, &of_slope))
    }
}
