//! The AVX2 form of the lanes and the one function compiled for it.
//!
//! `unsafe` because the same lanes left to the vectoriser, compiled for AVX2 too, took 1.6 times
//! as long (12.3 against 7.8 µs per tick with 20 people, `examples/tick.rs`, Intel Xeon with AVX2).
//!
//! Soundness rests on one rule: values of [`Avx2Lanes`] exist only inside [`residuals`] and [`risk`], whose callers
//! have checked that the processor runs AVX2 and FMA.
#![allow(unsafe_code)]
// The whole pass must be inlined into one function compiled for the chosen instruction set.
#![allow(clippy::inline_always)]

use std::arch::x86_64::{
    __m256, _CMP_LT_OQ, _mm_add_ps, _mm_add_ss, _mm_cvtss_f32, _mm_movehl_ps, _mm_shuffle_ps,
    _mm256_add_epi32, _mm256_add_ps, _mm256_blendv_ps, _mm256_castps_si256, _mm256_castps256_ps128,
    _mm256_castsi256_ps, _mm256_cmp_ps, _mm256_div_ps, _mm256_extractf128_ps, _mm256_fmadd_ps,
    _mm256_load_ps, _mm256_max_ps, _mm256_movemask_ps, _mm256_mul_ps, _mm256_or_ps, _mm256_set1_ps,
    _mm256_slli_epi32, _mm256_sqrt_ps, _mm256_store_ps, _mm256_sub_ps, _mm256_xor_ps,
};

use crate::anticipation::risk::{Path, Pieces, Risk};
use crate::lanes::{Blocking, Group8, Lanes, RiskLanes};
use crate::network_pass::{self, PassArguments};

/// Eight lanes in one AVX register.
#[derive(Clone, Copy)]
struct Avx2Lanes(__m256);

/// Evaluates the network with AVX2 and FMA instructions.
///
/// # Safety
/// The processor must support both; [`crate::Kernel::is_supported`] tells.
#[target_feature(enable = "avx2,fma")]
pub(crate) unsafe fn residuals(arguments: PassArguments<'_, Group8>) {
    network_pass::residuals::<Avx2Lanes>(arguments);
}

/// Computes the risk of a path with AVX2 instructions.
///
/// # Safety
/// The processor must support AVX2 and FMA; [`crate::Kernel::is_supported`] tells.
#[target_feature(enable = "avx2,fma")]
pub(crate) unsafe fn risk(pieces: &Pieces<'_>, path: Path<'_>, known: Risk, limit_s: f32) -> Risk {
    pieces.risk::<Avx2Lanes>(path, known, limit_s)
}

impl Lanes for Avx2Lanes {
    type Group = Group8;
    // 16 registers: 12 sums, 1 input, 1 weight.
    const BLOCKING: Blocking = Blocking { width: 1, block: [12, 0] };

    #[inline(always)]
    fn splat(value: f32) -> Self {
        // SAFETY: AVX is present wherever an `Avx2Lanes` exists, see the head of this file.
        Self(unsafe { _mm256_set1_ps(value) })
    }

    #[inline(always)]
    fn load(from: &Group8) -> Self {
        // SAFETY: as in `splat`; a `Group8` is 32 bytes long and aligned to 32 bytes.
        Self(unsafe { _mm256_load_ps(from.0.as_ptr()) })
    }

    #[inline(always)]
    fn store(self, to: &mut Group8) {
        // SAFETY: as in `load`, and the exclusive borrow makes the group writable.
        unsafe { _mm256_store_ps(to.0.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm256_add_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm256_sub_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm256_mul_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm256_div_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, summand: Self) -> Self {
        // SAFETY: as in `splat`; FMA is checked together with AVX2.
        Self(unsafe { _mm256_fmadd_ps(self.0, factor.0, summand.0) })
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm256_max_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn neg_abs(self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm256_or_ps(self.0, _mm256_set1_ps(-0.0)) })
    }

    #[inline(always)]
    fn select_by_sign(self, if_positive: Self, if_negative: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm256_blendv_ps(if_positive.0, if_negative.0, self.0) })
    }

    #[inline(always)]
    fn negate_where_odd(self, parity: Self) -> Self {
        // SAFETY: as in `splat`; AVX2 for the shift.
        Self(unsafe {
            let sign = _mm256_slli_epi32::<31>(_mm256_castps_si256(parity.0));
            _mm256_xor_ps(self.0, _mm256_castsi256_ps(sign))
        })
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        // SAFETY: as in `splat`; AVX2 for shift and sum.
        Self(unsafe {
            let exponent = _mm256_slli_epi32::<23>(_mm256_castps_si256(self.0));
            let one = _mm256_castps_si256(_mm256_set1_ps(1.0));
            _mm256_castsi256_ps(_mm256_add_epi32(exponent, one))
        })
    }
}

impl RiskLanes for Avx2Lanes {
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm256_sqrt_ps(self.0) })
    }

    #[inline(always)]
    fn sum(self) -> f32 {
        // SAFETY: as in `splat`; AVX2 stands for all before it.
        unsafe {
            let four = _mm_add_ps(_mm256_castps256_ps128(self.0), _mm256_extractf128_ps::<1>(self.0));
            let two = _mm_add_ps(four, _mm_movehl_ps(four, four));
            _mm_cvtss_f32(_mm_add_ss(two, _mm_shuffle_ps::<1>(two, two)))
        }
    }

    #[inline(always)]
    fn any_less(self, other: Self) -> bool {
        // SAFETY: as in `splat`.
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)) != 0 }
    }
}
