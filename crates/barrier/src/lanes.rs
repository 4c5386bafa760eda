//! Numbers side by side: the operations the network needs, and their plain-Rust form on eight `f32`.
//!
//! Not here: the forms for one instruction set (`lanes_avx2`, `lanes_avx512`) and what is computed with lanes
//! (`elementary`, `network_pass`).
// The whole pass must be inlined into one function compiled for the chosen instruction set.
#![allow(clippy::inline_always)]

/// One group of numbers in memory, as many as there are lanes.
pub(crate) trait Group: Copy {
    const LANES: usize;
    const ZERO: Self;
    /// Copies the first [`Group::LANES`] numbers of a slice that has them.
    fn read(from: &[f32]) -> Self;
    /// Copies to the first [`Group::LANES`] numbers of a slice that has them.
    fn write(&self, to: &mut [f32]);
}

/// Eight numbers, aligned for one AVX load.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
pub(crate) struct Group8(pub(crate) [f32; 8]);

impl Group for Group8 {
    const LANES: usize = 8;
    const ZERO: Self = Self([0.0; 8]);

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

/// How many accumulators of a product fill the registers: `block` outputs times the groups that go through the network
/// together.
pub(crate) struct Blocking {
    /// Most groups at once.
    pub(crate) width: usize,
    /// Outputs at once, by the number of groups less one.
    pub(crate) block: [usize; MAX_WIDTH],
}

/// Groups that any form sends through the network together.
pub(crate) const MAX_WIDTH: usize = 2;

/// Arithmetic on all lanes at once. A comparison with NaN picks the second operand.
pub(crate) trait Lanes: Copy {
    type Group: Group;
    const BLOCKING: Blocking;

    fn splat(value: f32) -> Self;
    fn load(from: &Self::Group) -> Self;
    fn store(self, to: &mut Self::Group);
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    /// Returns `self · factor + summand`, rounded once or twice.
    fn mul_add(self, factor: Self, summand: Self) -> Self;
    /// Returns `self` where `self > other`, else `other`.
    fn max(self, other: Self) -> Self;
    /// Returns `−|self|`.
    fn neg_abs(self) -> Self;
    /// Returns `if_positive` where the sign bit of `self` is clear, else `if_negative`.
    fn select_by_sign(self, if_positive: Self, if_negative: Self) -> Self;
    /// Returns `self`, negated where the lowest bit of `parity` is set.
    fn negate_where_odd(self, parity: Self) -> Self;
    /// Returns `2ⁿ` for `self = 1.5 · 2²³ + n`, −126 ≤ n ≤ 127.
    fn power_of_two(self) -> Self;
}

/// What the risk of a path among people takes beside the arithmetic (`anticipation::risk`).
pub(crate) trait RiskLanes: Lanes {
    fn sqrt(self) -> Self;
    /// Returns the sum of all lanes, halves onto each other: the same bits on any form.
    fn sum(self) -> f32;
    /// Whether any lane of `self` is less than that of `other`.
    fn any_less(self, other: Self) -> bool;
}

/// Plain Rust; the compiler vectorises it for whatever the target offers.
#[derive(Clone, Copy)]
pub(crate) struct PortableLanes([f32; 8]);

impl PortableLanes {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let mut out = self;
        for lane in 0..8 {
            out.0[lane] = f(self.0[lane], other.0[lane]);
        }
        out
    }
}

impl Lanes for PortableLanes {
    type Group = Group8;
    const BLOCKING: Blocking = Blocking { width: 1, block: [4; MAX_WIDTH] };

    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self([value; 8])
    }

    #[inline(always)]
    fn load(from: &Group8) -> Self {
        Self(from.0)
    }

    #[inline(always)]
    fn store(self, to: &mut Group8) {
        to.0 = self.0;
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, summand: Self) -> Self {
        self.mul(factor).add(summand)
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn neg_abs(self) -> Self {
        self.zip(self, |a, _| -a.abs())
    }

    #[inline(always)]
    fn select_by_sign(self, if_positive: Self, if_negative: Self) -> Self {
        let mut out = if_positive;
        for lane in 0..8 {
            if self.0[lane].is_sign_negative() {
                out.0[lane] = if_negative.0[lane];
            }
        }
        out
    }

    #[inline(always)]
    fn negate_where_odd(self, parity: Self) -> Self {
        self.zip(parity, |a, p| f32::from_bits(a.to_bits() ^ (p.to_bits() << 31)))
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        self.zip(self, |a, _| f32::from_bits((a.to_bits() << 23).wrapping_add(1.0_f32.to_bits())))
    }
}

impl RiskLanes for PortableLanes {
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.zip(self, |a, _| a.sqrt())
    }

    #[inline(always)]
    fn sum(self) -> f32 {
        let [a, b, c, d, e, f, g, h] = self.0;
        let four = [a + e, b + f, c + g, d + h];
        (four[0] + four[2]) + (four[1] + four[3])
    }

    #[inline(always)]
    fn any_less(self, other: Self) -> bool {
        // Every lane is compared, so that no jump is taken within a group.
        (0..8).filter(|&lane| self.0[lane] < other.0[lane]).count() > 0
    }
}
