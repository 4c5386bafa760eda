//! Sine with cosine, and softplus with its slope, on all lanes.
//!
//! Own polynomials because the mathematics library works on one number at a time and differs between
//! machines. Coefficients: minimax fits on the reduced interval, rounded to `f32`.
#![allow(clippy::inline_always)] // see `lanes`

use crate::lanes::Lanes;

/// Adding and subtracting `1.5 · 2²³` rounds to the nearest integer, which stands in the low bits between.
const ROUNDER: f32 = 12_582_912.0;

/// π in three parts; the products of the first two with integers up to 2¹¹ are exact.
const PI_PARTS: [f32; 3] = [3.140_625, 9.675_026e-4, 1.509_958e-7];
/// ln 2 in two parts; the product of the first with integers up to 2¹¹ is exact.
const LN_2_PARTS: [f32; 2] = [0.693_115_23, 3.194_618_3e-5];

/// `(sin r − r) / r³` on |r| ≤ π/2 in powers of r².
const SIN: [f32; 4] = [-0.166_666_57, 8.333_016e-3, -1.980_654_8e-4, 2.599_903_2e-6];
/// `(cos r − 1) / r²` on |r| ≤ π/2 in powers of r².
const COS: [f32; 4] = [-0.499_999_3, 0.041_663_982, -1.385_586_2e-3, 2.319_282_8e-5];
/// `(eʳ − 1 − r) / r²` on |r| ≤ ½ ln 2 in powers of r.
const EXP: [f32; 4] = [0.499_991_45, 0.166_664_57, 0.041_898_742, 8.374_723e-3];

/// `2 artanh(s) / s` in powers of s², its own series: enough terms for |s| ≤ 1/3.
const ARTANH: [f32; 7] = [2.0, 2.0 / 3.0, 2.0 / 5.0, 2.0 / 7.0, 2.0 / 9.0, 2.0 / 11.0, 2.0 / 13.0];

/// Returns `c₀ + c₁ x + …` by Horner's rule.
#[inline(always)]
fn polynomial<L: Lanes, const N: usize>(coefficients: &[f32; N], x: L) -> L {
    let mut sum = L::splat(coefficients[N - 1]);
    for k in (0..N - 1).rev() {
        sum = sum.mul_add(x, L::splat(coefficients[k]));
    }
    sum
}

/// Returns `(sin x, cos x)`, x in rad; absolute error below 5e-7 for |x| ≤ 100, growing with |x|·1e-8
/// beyond. NaN and infinities give NaN.
#[inline(always)]
pub(crate) fn sin_cos<L: Lanes>(x: L) -> (L, L) {
    // x = k π + r with |r| ≤ π/2, so both functions only change sign with odd k.
    let rounded = x.mul_add(L::splat(std::f32::consts::FRAC_1_PI), L::splat(ROUNDER));
    let k = rounded.sub(L::splat(ROUNDER));
    let mut r = x;
    for part in PI_PARTS {
        r = k.mul_add(L::splat(-part), r);
    }
    let r2 = r.mul(r);
    let sin = polynomial(&SIN, r2).mul(r2).mul_add(r, r);
    let cos = polynomial(&COS, r2).mul_add(r2, L::splat(1.0));
    (sin.negate_where_odd(rounded), cos.negate_where_odd(rounded))
}

/// Returns `e^x` for x ≤ 0; below −87 the result of −87, about 1e-38.
#[inline(always)]
fn exp_of_negative<L: Lanes>(x: L) -> L {
    let x = L::splat(-87.0).max(x);
    let rounded = x.mul_add(L::splat(std::f32::consts::LOG2_E), L::splat(ROUNDER));
    let k = rounded.sub(L::splat(ROUNDER));
    let mut r = x;
    for part in LN_2_PARTS {
        r = k.mul_add(L::splat(-part), r);
    }
    let one = L::splat(1.0);
    polynomial(&EXP, r).mul(r).mul_add(r, r.add(one)).mul(rounded.power_of_two())
}

/// Returns `softplus(y) = ln(1 + e^y)` and its slope, the logistic function, without overflow.
///
/// Never negative, which is what makes `h̄ ≤ ℓ` hold by construction. Absolute error below 3e-7 plus
/// rounding for large y.
#[inline(always)]
pub(crate) fn softplus_with_slope<L: Lanes>(y: L) -> (L, L) {
    let one = L::splat(1.0);
    let e = exp_of_negative(y.neg_abs());
    // ln(1 + e) = 2 artanh(s), s = e / (2 + e) ≤ 1/3.
    let s = e.div(e.add(L::splat(2.0)));
    let tail = polynomial(&ARTANH, s.mul(s)).mul(s);
    let softplus = L::splat(0.0).max(y).add(tail);
    let slope = y.select_by_sign(one, e).div(e.add(one));
    (softplus, slope)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{Group, Group8, PortableLanes};

    const LANES: usize = Group8::LANES;

    fn each(values: impl Iterator<Item = f32>, mut check: impl FnMut(f32, [f32; 4])) {
        let values: Vec<f32> = values.collect();
        for chunk in values.chunks_exact(LANES) {
            let x = PortableLanes::load(&Group8::read(chunk));
            let (sin, cos) = sin_cos(x);
            let (softplus, slope) = softplus_with_slope(x);
            let out = [sin, cos, softplus, slope].map(|lanes| {
                let mut group = Group8::ZERO;
                lanes.store(&mut group);
                group
            });
            for lane in 0..LANES {
                check(chunk[lane], out.map(|group| group.0[lane]));
            }
        }
    }

    fn grid(limit: f32) -> impl Iterator<Item = f32> {
        (0..400_000).map(move |i| (i as f32 / 200_000.0 - 1.0) * limit)
    }

    #[test]
    fn sine_and_cosine_stay_within_5e_7_up_to_100() {
        let mut worst = 0.0_f64;
        each(grid(100.0), |x, [sin, cos, ..]| {
            let (s, c) = f64::from(x).sin_cos();
            worst = worst.max((f64::from(sin) - s).abs()).max((f64::from(cos) - c).abs());
        });
        assert!(worst < 5e-7, "{worst:e}");
    }

    #[test]
    fn softplus_and_slope_agree_with_f64() {
        let (mut worst, mut worst_slope) = (0.0_f64, 0.0_f64);
        each(grid(100.0).chain(grid(2.0)), |x, [_, _, softplus, slope]| {
            let y = f64::from(x);
            let exact = y.max(0.0) + (-y.abs()).exp().ln_1p();
            worst = worst.max((f64::from(softplus) - exact).abs() / exact.max(1.0));
            worst_slope = worst_slope.max((f64::from(slope) - 1.0 / (1.0 + (-y).exp())).abs());
        });
        assert!(worst < 3e-7 && worst_slope < 3e-7, "{worst:e} {worst_slope:e}");
    }

    #[test]
    fn softplus_is_never_negative() {
        let extremes = [f32::MIN, -1e30, -200.0, -87.5, -0.0, 0.0, 200.0, f32::MAX];
        each(extremes.into_iter(), |x, [_, _, softplus, slope]| {
            assert!(softplus >= 0.0 && (0.0..=1.0).contains(&slope), "{x} {softplus} {slope}");
        });
    }

    #[test]
    fn not_a_number_stays_visible() {
        each([f32::NAN; LANES].into_iter(), |_, out| assert!(out.iter().all(|v| v.is_nan()), "{out:?}"));
        each([f32::INFINITY; LANES].into_iter(), |_, [sin, cos, ..]| assert!(sin.is_nan() && cos.is_nan()));
    }
}
