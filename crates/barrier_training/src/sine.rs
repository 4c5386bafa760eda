//! Sine and cosine of a vector of `f32`, the same bits on every instruction set.
//!
//! Only fused multiply-adds, additions and bit operations occur, so AVX-512, AVX2 and scalar code agree exactly.
//! Not here: the filter's own kernels (crate `barrier`).

// Vector code must melt into the function that enabled the instruction set, or every operation becomes a call.
#![allow(clippy::inline_always)]

use core::f32::consts::{FRAC_1_PI, PI};
use pulp::Simd;

/// π minus its nearest `f32`.
const PI_LOW: f32 = -8.742_278e-8;
/// Adding this rounds to an integer, whose parity is then the lowest mantissa bit.
const ROUND: f32 = 12_582_912.0;
/// Minimax polynomials on `[-π/2, π/2]`: `sin r = r + r³·S(r²)` to 5e-9 and `cos r = 1 + r²·C(r²)` to 6e-8.
const S: [f32; 4] = [-0.166_666_57, 8.333_017e-3, -1.980_660_2e-4, 2.600_024_3e-6];
const C: [f32; 4] = [-0.499_999_3, 4.166_399e-2, -1.385_591_5e-3, 2.319_407_4e-5];

/// `(sin x, cos x)`, absolute error below 3e-7 for `|x| ≤ 100`, growing with `|x|` beyond.
#[inline(always)]
pub(crate) fn sin_cos<V: Simd>(simd: V, x: V::f32s) -> (V::f32s, V::f32s) {
    let shifted = simd.mul_add_f32s(x, simd.splat_f32s(FRAC_1_PI), simd.splat_f32s(ROUND));
    let n = simd.sub_f32s(shifted, simd.splat_f32s(ROUND));
    let r = simd.mul_add_f32s(n, simd.splat_f32s(-PI), x);
    let r = simd.mul_add_f32s(n, simd.splat_f32s(-PI_LOW), r);
    // An odd multiple of π flips both signs.
    let parity = simd.wrapping_dyn_shl_u32s(simd.transmute_u32s_f32s(shifted), simd.splat_u32s(31));
    let flip = simd.transmute_f32s_u32s(parity);

    let r2 = simd.mul_f32s(r, r);
    let mut s = simd.splat_f32s(S[3]);
    let mut c = simd.splat_f32s(C[3]);
    for i in [2, 1, 0] {
        s = simd.mul_add_f32s(s, r2, simd.splat_f32s(S[i]));
        c = simd.mul_add_f32s(c, r2, simd.splat_f32s(C[i]));
    }
    let s = simd.mul_add_f32s(simd.mul_f32s(s, r2), r, r);
    let c = simd.mul_add_f32s(c, r2, simd.splat_f32s(1.0));
    (simd.xor_f32s(s, flip), simd.xor_f32s(c, flip))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::{Arch, WithSimd};

    struct Apply<'a> {
        x: &'a [f32],
        sine: &'a mut [f32],
        cosine: &'a mut [f32],
    }

    impl WithSimd for Apply<'_> {
        type Output = ();
        #[inline(always)]
        fn with_simd<V: Simd>(self, simd: V) {
            for i in (0..self.x.len()).step_by(V::F32_LANES) {
                let end = i + V::F32_LANES;
                let (s, c) = sin_cos(simd, simd.partial_load_f32s(&self.x[i..end]));
                simd.partial_store_f32s(&mut self.sine[i..end], s);
                simd.partial_store_f32s(&mut self.cosine[i..end], c);
            }
        }
    }

    fn apply(arch: Arch, x: &[f32]) -> (Vec<f32>, Vec<f32>) {
        let (mut sine, mut cosine) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        arch.dispatch(Apply { x, sine: &mut sine, cosine: &mut cosine });
        (sine, cosine)
    }

    #[test]
    fn agrees_with_double_precision() {
        let x: Vec<f32> = (0..160_000).map(|i| (i as f32 - 80_000.0) * 0.001_25).collect();
        let (sine, cosine) = apply(Arch::new(), &x);
        let error = |y: f32, exact: f64| (f64::from(y) - exact).abs();
        for i in 0..x.len() {
            let exact = f64::from(x[i]).sin_cos();
            assert!(error(sine[i], exact.0) < 3e-7, "sin {}: {}", x[i], sine[i]);
            assert!(error(cosine[i], exact.1) < 3e-7, "cos {}: {}", x[i], cosine[i]);
        }
    }

    #[test]
    fn has_the_same_bits_on_every_instruction_set() {
        let x: Vec<f32> = (0..4096).map(|i| (i as f32 - 2048.0) * 0.037).collect();
        assert_eq!(apply(Arch::new(), &x), apply(Arch::Scalar, &x));
    }
}
