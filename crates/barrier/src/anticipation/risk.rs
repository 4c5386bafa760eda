//! What a path among predicted people is worth, eight moments at a time.
//!
//! The search spends nearly all its time here. Where the processor has AVX2 the same operations run on it, without fused
//! multiply-add: the same bits everywhere. Not here: where people will be (`people`).
// All of it must be inlined into one function compiled for the chosen instruction set.
#![allow(clippy::inline_always)]

use crate::kernel::Kernel;
use crate::lanes::{Group, Group8, PortableLanes, RiskLanes};

/// Moments are computed this many at once.
pub(super) const LANES: usize = Group8::LANES;

/// How much eight moments of the horizon count.
#[derive(Clone, Copy)]
pub(super) struct Stretch {
    /// 1/ℓ(t), 1/m.
    pub(super) per_clearance: Group8,
    /// `k e^(−t/τ) dt`, s.
    pub(super) weight_s: Group8,
}

/// One prediction of one person over eight moments.
#[derive(Clone, Copy)]
pub(super) struct Piece {
    /// Which eight.
    pub(super) stretch: usize,
    /// m.
    pub(super) x: Group8,
    pub(super) y: Group8,
    /// Distance of contact, m.
    pub(super) radius_m: f32,
    /// `(radius + ℓ(t))²` and a little more: nobody is a risk at a larger squared distance, m².
    pub(super) within_m2: Group8,
    /// Weight of this prediction, 1 for going on.
    pub(super) share: f32,
}

/// `[x, y]` of a path at each moment, eight by eight, m.
pub(crate) type Path<'a> = [&'a [[f32; LANES]]; 2];

/// What a path is worth, as far as it was looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Risk {
    /// `k Σᵢ ∫ e^(−t/τ) [ρ(cᵢ) + q/M ρ(c̃ᵢ)] dt`, s; anything above the limit where it exceeds that.
    pub(crate) risk_s: f32,
    /// How many pieces are in it.
    pub(crate) pieces: usize,
}

impl Risk {
    /// Nothing was looked at.
    pub(super) const UNKNOWN: Self = Self { risk_s: 0.0, pieces: 0 };
}

/// Everybody's predictions.
#[derive(Clone, Copy)]
pub(crate) struct Pieces<'a> {
    pub(super) stretches: &'a [Stretch],
    pub(super) pieces: &'a [Piece],
}

impl Pieces<'_> {
    /// The risk of a path of which a part is `known`, on what is widest here. Stops where it exceeds `limit_s`.
    #[allow(unsafe_code)] // the call into code compiled for another instruction set
    pub(super) fn risk_on(&self, kernel: Kernel, path: Path<'_>, known: Risk, limit_s: f32) -> Risk {
        match kernel {
            Kernel::Portable => self.risk::<PortableLanes>(path, known, limit_s),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `People::new` takes the kernel from `Kernel::detect`; AVX-512 includes AVX2 and FMA.
            Kernel::Avx2Fma | Kernel::Avx512 => unsafe {
                crate::lanes_avx2::risk(self, path, known, limit_s)
            },
            #[cfg(not(target_arch = "x86_64"))]
            Kernel::Avx2Fma | Kernel::Avx512 => self.risk::<PortableLanes>(path, known, limit_s),
        }
    }

    #[inline(always)]
    pub(crate) fn risk<L: RiskLanes<Group = Group8>>(
        &self,
        path: Path<'_>,
        known: Risk,
        limit_s: f32,
    ) -> Risk {
        let Risk { mut risk_s, mut pieces } = known;
        if risk_s > limit_s {
            return known;
        }
        for piece in &self.pieces[pieces..] {
            pieces += 1;
            // Most are far away.
            let Some(of_piece_s) = self.of_piece_s::<L>(piece, path) else {
                continue;
            };
            risk_s += piece.share * of_piece_s;
            if risk_s > limit_s {
                break;
            }
        }
        Risk { risk_s, pieces }
    }

    /// `Σ k e^(−t/τ) ρ(c(t)) dt` over eight moments, s; `None` where nobody is near in any of them.
    #[inline(always)]
    fn of_piece_s<L: RiskLanes<Group = Group8>>(&self, piece: &Piece, [xs, ys]: Path<'_>) -> Option<f32> {
        let dx = L::load(&Group8(xs[piece.stretch])).sub(L::load(&piece.x));
        let dy = L::load(&Group8(ys[piece.stretch])).sub(L::load(&piece.y));
        let squared_m2 = dx.mul(dx).add(dy.mul(dy));
        if !squared_m2.any_less(L::load(&piece.within_m2)) {
            return None;
        }
        let stretch = &self.stretches[piece.stretch];
        let distance_m = squared_m2.sqrt().sub(L::splat(piece.radius_m));
        let lack = L::splat(1.0).sub(distance_m.mul(L::load(&stretch.per_clearance)));
        let lack = lack.max(L::splat(0.0));
        let squared = lack.mul(lack);
        Some(L::load(&stretch.weight_s).mul(squared).mul(squared).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn group(f: impl Fn(usize) -> f32) -> Group8 {
        Group8(std::array::from_fn(f))
    }

    fn stretches() -> Vec<Stretch> {
        let moments = |f: fn(f32) -> f32, at: usize| group(|lane| f((at * LANES + lane) as f32));
        (0..4)
            .map(|at| Stretch {
                per_clearance: moments(|t| 2.0 / (1.0 + 0.03 * t), at),
                weight_s: moments(|t| (-0.02 * t).exp(), at),
            })
            .collect()
    }

    /// People who walk across the way of a path along x, some of them less likely.
    fn pieces() -> Vec<Piece> {
        let person = |at: usize, k: usize| Piece {
            stretch: at,
            x: group(|_| 1.0 + 0.3 * k as f32),
            y: group(|lane| 1.5 - 0.1 * (at * LANES + lane) as f32),
            radius_m: 0.7,
            within_m2: group(|lane| 1.0001 * (0.7 + 1.0 / stretches()[at].per_clearance.0[lane]).powi(2)),
            share: if k == 0 { 1.0 } else { 0.25 },
        };
        (0..4).flat_map(|at| (0..5).map(move |k| person(at, k))).collect()
    }

    /// Along x, at 0.1 m a moment.
    fn path() -> [Vec<[f32; LANES]>; 2] {
        let along = |at: usize| group(|lane| 0.1 * (at * LANES + lane) as f32).0;
        [(0..4).map(along).collect(), vec![[0.0; LANES]; 4]]
    }

    fn risk_on(kernel: Kernel, limit_s: f32) -> Risk {
        let (stretches, pieces, [xs, ys]) = (stretches(), pieces(), path());
        Pieces { stretches: &stretches, pieces: &pieces }.risk_on(kernel, [&xs, &ys], Risk::UNKNOWN, limit_s)
    }

    #[test]
    fn the_risk_is_the_formulas_and_has_the_same_bits_on_every_kernel() {
        let (stretches, [xs, ys]) = (stretches(), path());
        let mut expected_s = 0.0;
        for piece in pieces() {
            let stretch = &stretches[piece.stretch];
            for lane in 0..LANES {
                let of = |group: &Group8| f64::from(group.0[lane]);
                let [path_x, path_y] = [&xs, &ys].map(|path| f64::from(path[piece.stretch][lane]));
                let (dx, dy) = (path_x - of(&piece.x), path_y - of(&piece.y));
                let signed_m = dx.hypot(dy) - f64::from(piece.radius_m);
                let lack = (1.0 - signed_m * of(&stretch.per_clearance)).max(0.0);
                expected_s += f64::from(piece.share) * of(&stretch.weight_s) * lack.powi(4);
            }
        }
        let found_s = risk_on(Kernel::Portable, f32::INFINITY).risk_s;
        assert!(expected_s > 1.0 && (f64::from(found_s) - expected_s).abs() < 1e-5 * expected_s);
        for kernel in Kernel::ALL.into_iter().filter(|kernel| kernel.is_supported()) {
            assert_eq!(risk_on(kernel, f32::INFINITY).risk_s.to_bits(), found_s.to_bits(), "{kernel}");
        }
    }

    #[test]
    fn beyond_the_limit_no_piece_is_looked_at() {
        let all = risk_on(Kernel::detect(), f32::INFINITY);
        let some = risk_on(Kernel::detect(), 0.2 * all.risk_s);
        assert!(some.risk_s > 0.2 * all.risk_s && some.pieces < all.pieces);
        assert_eq!(all.pieces, pieces().len());
    }
}
