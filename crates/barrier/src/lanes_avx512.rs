//! The AVX-512 form of the lanes and the one function compiled for it.
//!
//! Twice the width and twice the registers of `lanes_avx2`, and the same operations in the same order: a state gives
//! the same bits on either.
//!
//! Soundness rests on one rule: values of [`Avx512Lanes`] exist only inside [`residuals`], whose caller has
//! checked that the processor runs AVX-512F.
#![allow(unsafe_code)]
// The whole pass must be inlined into one function compiled for the chosen instruction set.
#![allow(clippy::inline_always)]

use std::arch::x86_64::{
    __m512, _mm512_add_epi32, _mm512_add_ps, _mm512_castps_si512, _mm512_castsi512_ps,
    _mm512_cmplt_epi32_mask, _mm512_div_ps, _mm512_fmadd_ps, _mm512_load_ps, _mm512_mask_blend_ps,
    _mm512_max_ps, _mm512_mul_ps, _mm512_or_si512, _mm512_set1_ps, _mm512_setzero_si512, _mm512_slli_epi32,
    _mm512_store_ps, _mm512_sub_ps, _mm512_xor_si512,
};

use crate::lanes::{Blocking, Group, Lanes};
use crate::network_pass::{self, PassArguments};

/// Sixteen numbers, aligned for one AVX-512 load.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct Group16([f32; 16]);

impl Group for Group16 {
    const LANES: usize = 16;
    const ZERO: Self = Self([0.0; 16]);

    #[inline(always)]
    fn read(from: &[f32]) -> Self {
        let mut group = Self::ZERO;
        group.0.copy_from_slice(&from[..Self::LANES]);
        group
    }

    #[inline(always)]
    fn write(&self, to: &mut [f32]) {
        to[..Self::LANES].copy_from_slice(&self.0);
    }
}

/// Sixteen lanes in one AVX-512 register.
#[derive(Clone, Copy)]
struct Avx512Lanes(__m512);

/// Evaluates the network with AVX-512F instructions.
///
/// # Safety
/// The processor must support them; [`crate::Kernel::is_supported`] tells.
#[target_feature(enable = "avx512f")]
pub(crate) unsafe fn residuals(arguments: PassArguments<'_, Group16>) {
    network_pass::residuals::<Avx512Lanes>(arguments);
}

impl Lanes for Avx512Lanes {
    type Group = Group16;
    // 32 registers: up to 24 sums, 2 inputs, 1 weight.
    const BLOCKING: Blocking = Blocking { width: 2, block: [12, 12] };

    #[inline(always)]
    fn splat(value: f32) -> Self {
        // SAFETY: AVX-512F is present wherever an `Avx512Lanes` exists, see the head of this file.
        Self(unsafe { _mm512_set1_ps(value) })
    }

    #[inline(always)]
    fn load(from: &Group16) -> Self {
        // SAFETY: as in `splat`; a `Group16` is 64 bytes long and aligned to 64 bytes.
        Self(unsafe { _mm512_load_ps(from.0.as_ptr()) })
    }

    #[inline(always)]
    fn store(self, to: &mut Group16) {
        // SAFETY: as in `load`, and the exclusive borrow makes the group writable.
        unsafe { _mm512_store_ps(to.0.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm512_add_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm512_sub_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm512_mul_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm512_div_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, summand: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm512_fmadd_ps(self.0, factor.0, summand.0) })
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm512_max_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn neg_abs(self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe {
            let sign = _mm512_castps_si512(_mm512_set1_ps(-0.0));
            _mm512_castsi512_ps(_mm512_or_si512(_mm512_castps_si512(self.0), sign))
        })
    }

    #[inline(always)]
    fn select_by_sign(self, if_positive: Self, if_negative: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe {
            let negative = _mm512_cmplt_epi32_mask(_mm512_castps_si512(self.0), _mm512_setzero_si512());
            _mm512_mask_blend_ps(negative, if_positive.0, if_negative.0)
        })
    }

    #[inline(always)]
    fn negate_where_odd(self, parity: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe {
            let sign = _mm512_slli_epi32::<31>(_mm512_castps_si512(parity.0));
            _mm512_castsi512_ps(_mm512_xor_si512(_mm512_castps_si512(self.0), sign))
        })
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe {
            let exponent = _mm512_slli_epi32::<23>(_mm512_castps_si512(self.0));
            let one = _mm512_castps_si512(_mm512_set1_ps(1.0));
            _mm512_castsi512_ps(_mm512_add_epi32(exponent, one))
        })
    }
}
