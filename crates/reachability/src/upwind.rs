//! One-sided derivatives along one axis, for many nodes at once.
//!
//! Everything works on slices of equal length, so that the compiler vectorises over nodes, whichever
//! axis is differentiated. Ghost nodes are already in the slices (`stencil`).

use crate::UpwindScheme;

/// Keeps the smoothness weights finite on flat data, in squared slope units.
///
/// Absolute, as in hj_reachability: values are metres and slopes of order one.
const WENO_EPSILON: f32 = 1e-6;

/// Values at the nodes `−3..=3` steps along the axis; the unused outer ones are empty.
pub(crate) type Stencil<'a> = [&'a [f32]; 7];

/// Index of the node itself within a [`Stencil`].
pub(crate) const CENTRE: usize = 3;

/// Writes the left- and right-sided derivative at every node of the stencil's centre slice.
///
/// `left` and `right` are as long as the centre slice; `inverse_spacing` is per state unit.
#[inline(always)]
pub(crate) fn derivatives(
    scheme: UpwindScheme,
    values: &Stencil<'_>,
    inverse_spacing: f32,
    left: &mut [f32],
    right: &mut [f32],
) {
    match scheme {
        UpwindScheme::FirstOrder => first_order(values, inverse_spacing, left, right),
        UpwindScheme::Eno2 => eno2(values, inverse_spacing, left, right),
        UpwindScheme::Weno3 => weno3(values, inverse_spacing, left, right),
        UpwindScheme::Weno5 => weno5(values, inverse_spacing, left, right),
    }
}

#[inline(always)]
fn first_order(values: &Stencil<'_>, inverse_spacing: f32, left: &mut [f32], right: &mut [f32]) {
    let n = left.len();
    let [_, _, m1, c, p1, _, _] = *values;
    let (m1, c, p1, right) = (&m1[..n], &c[..n], &p1[..n], &mut right[..n]);
    for i in 0..n {
        left[i] = (c[i] - m1[i]) * inverse_spacing;
        right[i] = (p1[i] - c[i]) * inverse_spacing;
    }
}

/// Second order: of two candidates per side the one whose second difference is smaller.
#[inline(always)]
fn eno2(values: &Stencil<'_>, inverse_spacing: f32, left: &mut [f32], right: &mut [f32]) {
    let n = left.len();
    let [_, m2, m1, c, p1, p2, _] = *values;
    let (m2, m1, c, p1, p2) = (&m2[..n], &m1[..n], &c[..n], &p1[..n], &p2[..n]);
    let right = &mut right[..n];
    for i in 0..n {
        let d0 = (m1[i] - m2[i]) * inverse_spacing;
        let d1 = (c[i] - m1[i]) * inverse_spacing;
        let d2 = (p1[i] - c[i]) * inverse_spacing;
        let d3 = (p2[i] - p1[i]) * inverse_spacing;
        let candidates = [1.5 * d1 - 0.5 * d0, 0.5 * (d1 + d2), 1.5 * d2 - 0.5 * d3];
        let curved = [(d1 - d0).abs(), (d2 - d1).abs(), (d3 - d2).abs()];
        left[i] = if curved[1] < curved[0] { candidates[1] } else { candidates[0] };
        right[i] = if curved[2] < curved[1] { candidates[2] } else { candidates[1] };
    }
}

/// Third order: two candidates per side, weighted `1 : 2` where both are equally smooth.
#[inline(always)]
fn weno3(values: &Stencil<'_>, inverse_spacing: f32, left: &mut [f32], right: &mut [f32]) {
    let n = left.len();
    let [_, m2, m1, c, p1, p2, _] = *values;
    let (m2, m1, c, p1, p2) = (&m2[..n], &m1[..n], &c[..n], &p1[..n], &p2[..n]);
    let right = &mut right[..n];
    for i in 0..n {
        let d0 = (m1[i] - m2[i]) * inverse_spacing;
        let d1 = (c[i] - m1[i]) * inverse_spacing;
        let d2 = (p1[i] - c[i]) * inverse_spacing;
        let d3 = (p2[i] - p1[i]) * inverse_spacing;
        let candidates = [1.5 * d1 - 0.5 * d0, 0.5 * (d1 + d2), 1.5 * d2 - 0.5 * d3];
        // (s + ε)² of the three candidates; the weights are c/(s + ε)², here cleared of fractions so
        // that each side costs one division.
        let rough = [d1 - d0, d2 - d1, d3 - d2].map(|b| {
            let s = b * b + WENO_EPSILON;
            s * s
        });
        let (w0, w1) = (rough[1], 2.0 * rough[0]);
        left[i] = (w0 * candidates[0] + w1 * candidates[1]) / (w0 + w1);
        let (w1, w2) = (2.0 * rough[2], rough[1]);
        right[i] = (w1 * candidates[1] + w2 * candidates[2]) / (w1 + w2);
    }
}

/// Fifth order: three candidates per side, weighted `1 : 6 : 3` where all are equally smooth.
#[inline(always)]
fn weno5(values: &Stencil<'_>, inverse_spacing: f32, left: &mut [f32], right: &mut [f32]) {
    let n = left.len();
    let [m3, m2, m1, c, p1, p2, p3] = *values;
    let (m3, m2, m1, c) = (&m3[..n], &m2[..n], &m1[..n], &c[..n]);
    let (p1, p2, p3, right) = (&p1[..n], &p2[..n], &p3[..n], &mut right[..n]);
    for i in 0..n {
        let d0 = (m2[i] - m3[i]) * inverse_spacing;
        let d1 = (m1[i] - m2[i]) * inverse_spacing;
        let d2 = (c[i] - m1[i]) * inverse_spacing;
        let d3 = (p1[i] - c[i]) * inverse_spacing;
        let d4 = (p2[i] - p1[i]) * inverse_spacing;
        let d5 = (p3[i] - p2[i]) * inverse_spacing;
        left[i] = weno5_side(d0, d1, d2, d3, d4);
        right[i] = weno5_side(d5, d4, d3, d2, d1);
    }
}

/// One side from its five differences, listed from the upwind end.
#[inline(always)]
fn weno5_side(a: f32, b: f32, c: f32, d: f32, e: f32) -> f32 {
    let candidates =
        [(2.0 * a - 7.0 * b + 11.0 * c) / 6.0, (-b + 5.0 * c + 2.0 * d) / 6.0, (2.0 * c + 5.0 * d - e) / 6.0];
    let smoothness = |curvature: f32, slope: f32| {
        let s = 13.0 / 12.0 * curvature * curvature + 0.25 * slope * slope + WENO_EPSILON;
        s * s
    };
    let s0 = smoothness(a - 2.0 * b + c, a - 4.0 * b + 3.0 * c);
    let s1 = smoothness(b - 2.0 * c + d, b - d);
    let s2 = smoothness(c - 2.0 * d + e, 3.0 * c - 4.0 * d + e);
    let (w0, w1, w2) = (1.0 / s0, 6.0 / s1, 3.0 / s2);
    (w0 * candidates[0] + w1 * candidates[1] + w2 * candidates[2]) / (w0 + w1 + w2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest error of either side on `sin`, with `cells` cells per period.
    fn error_on_sine(scheme: UpwindScheme, cells: u32) -> f64 {
        let spacing = std::f64::consts::TAU / f64::from(cells);
        let shifted: Vec<Vec<f32>> = (0..7)
            .map(|k| {
                (0..cells).map(|i| ((f64::from(i) + f64::from(k) - 3.0) * spacing).sin() as f32).collect()
            })
            .collect();
        let stencil: Stencil<'_> = std::array::from_fn(|k| shifted[k].as_slice());
        let (mut left, mut right) = (vec![0.0; cells as usize], vec![0.0; cells as usize]);
        derivatives(scheme, &stencil, (1.0 / spacing) as f32, &mut left, &mut right);
        (0..cells as usize)
            .map(|i| {
                let exact = (i as f64 * spacing).cos();
                (f64::from(left[i]) - exact).abs().max((f64::from(right[i]) - exact).abs())
            })
            .fold(0.0, f64::max)
    }

    #[test]
    fn converge_at_their_order() {
        // Coarse enough that rounding of f32 stays below the scheme's own error.
        for (scheme, cells, least_ratio) in [
            (UpwindScheme::FirstOrder, 64, 1.9),
            // Where the choice switches, its error jumps between two of second order.
            (UpwindScheme::Eno2, 64, 3.5),
            // Critical points of the sine cost the classical weights one order there.
            (UpwindScheme::Weno3, 32, 3.5),
            (UpwindScheme::Weno5, 16, 16.0),
        ] {
            let ratio = error_on_sine(scheme, cells) / error_on_sine(scheme, 2 * cells);
            assert!(ratio > least_ratio, "{scheme:?}: halving the spacing divides the error by {ratio}");
        }
    }

    #[test]
    fn take_the_smooth_side_of_a_kink() {
        // |x| around its kink: the left derivative must stay −1, the right +1.
        let at = |offset: f32| [(offset - 3.0).abs()];
        let nodes: [[f32; 1]; 7] = std::array::from_fn(|k| at(k as f32));
        let stencil: Stencil<'_> = std::array::from_fn(|k| nodes[k].as_slice());
        for scheme in [UpwindScheme::FirstOrder, UpwindScheme::Eno2, UpwindScheme::Weno3, UpwindScheme::Weno5]
        {
            let (mut left, mut right) = ([0.0], [0.0]);
            derivatives(scheme, &stencil, 1.0, &mut left, &mut right);
            assert!(
                (left[0] + 1.0).abs() < 1e-5 && (right[0] - 1.0).abs() < 1e-5,
                "{scheme:?}: {left:?} {right:?}"
            );
        }
    }
}
