//! The three products of training over a panel or block, on whichever vector width the machine has.
//!
//! Every multiply-add is fused and every sum runs in a fixed order, so the results carry the same bits on every
//! instruction set. Layout: see [`crate::panel`].

// As in `sine`: vector code must melt into the function that enabled the instruction set.
#![allow(clippy::inline_always)]

use crate::panel::{LANES, Lanes, PANEL, groups};
use bytemuck::{cast_slice, cast_slice_mut};
use pulp::Simd;

/// Vectors of one row of a panel.
pub(crate) const fn vectors<V: Simd>() -> usize {
    PANEL / V::F32_LANES
}

/// `start[row] + Σ_k weights[k][row]·input[k]` for the `J` rows of a tile, on the vectors `2·pair` and `2·pair + 1`
/// of the panel.
///
/// `weights` is `[k][J]`, `input` the matching rows of a panel.
#[inline(always)]
pub(crate) fn dense_tile<V: Simd, const J: usize>(
    simd: V,
    weights: &[f32],
    start: &[f32; J],
    input: &[V::f32s],
    pair: usize,
) -> [[V::f32s; 2]; J] {
    let mut sum = [[simd.splat_f32s(0.0); 2]; J];
    for j in 0..J {
        sum[j] = [simd.splat_f32s(start[j]); 2];
    }
    for (w, x) in weights.chunks_exact(J).zip(input.chunks_exact(vectors::<V>())) {
        let (x0, x1) = (x[2 * pair], x[2 * pair + 1]);
        for j in 0..J {
            let wj = simd.splat_f32s(w[j]);
            sum[j][0] = simd.mul_add_f32s(wj, x0, sum[j][0]);
            sum[j][1] = simd.mul_add_f32s(wj, x1, sum[j][1]);
        }
    }
    sum
}

/// Rows of a block that take part in [`outer_tile`]: where a matrix lies inside each panel.
#[derive(Clone, Copy)]
pub(crate) struct Rows<'a> {
    /// All panels, one behind another.
    pub(crate) data: &'a [Lanes],
    /// Rows of each panel in `data`.
    pub(crate) height: usize,
    /// First row of the tile.
    pub(crate) first: usize,
}

/// `Σ_samples left[j]·right[k]` for a tile of `J` by `K` rows, over all panels of a block.
#[inline(always)]
pub(crate) fn outer_tile<V: Simd, const J: usize, const K: usize>(
    simd: V,
    left: Rows<'_>,
    right: Rows<'_>,
) -> [[f32; K]; J] {
    let (row, parts) = (vectors::<V>(), LANES / V::F32_LANES);
    let mut lanes = [[Lanes::ZERO; K]; J];
    for part in 0..parts {
        let mut sum = [[simd.splat_f32s(0.0); K]; J];
        let panels = left.data.chunks_exact(groups(left.height));
        for (l, r) in panels.zip(right.data.chunks_exact(groups(right.height))) {
            let l: &[V::f32s] = cast_slice(&l[groups(left.first)..groups(left.first + J)]);
            let r: &[V::f32s] = cast_slice(&r[groups(right.first)..groups(right.first + K)]);
            for group in 0..PANEL / LANES {
                let i = group * parts + part;
                let mut rk = [simd.splat_f32s(0.0); K];
                for k in 0..K {
                    rk[k] = r[k * row + i];
                }
                for j in 0..J {
                    let lj = l[j * row + i];
                    for k in 0..K {
                        sum[j][k] = simd.mul_add_f32s(lj, rk[k], sum[j][k]);
                    }
                }
            }
        }
        for j in 0..J {
            for k in 0..K {
                cast_slice_mut::<Lanes, V::f32s>(core::slice::from_mut(&mut lanes[j][k]))[part] = sum[j][k];
            }
        }
    }
    let mut out = [[0.0; K]; J];
    for j in 0..J {
        for k in 0..K {
            out[j][k] = lanes[j][k].sum();
        }
    }
    out
}

/// `Σ_samples left[j]` for `J` rows, over all panels of a block, in the order of [`outer_tile`].
#[inline(always)]
pub(crate) fn row_sums<V: Simd, const J: usize>(simd: V, left: Rows<'_>) -> [f32; J] {
    let parts = LANES / V::F32_LANES;
    let row = vectors::<V>();
    let mut lanes = [Lanes::ZERO; J];
    for panel in left.data.chunks_exact(groups(left.height)) {
        let values: &[V::f32s] = cast_slice(&panel[groups(left.first)..groups(left.first + J)]);
        for j in 0..J {
            let sum: &mut [V::f32s] = cast_slice_mut(core::slice::from_mut(&mut lanes[j]));
            for i in 0..row {
                sum[i % parts] = simd.add_f32s(sum[i % parts], values[j * row + i]);
            }
        }
    }
    let mut out = [0.0; J];
    for j in 0..J {
        out[j] = lanes[j].sum();
    }
    out
}
