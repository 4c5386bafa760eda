//! One affine layer applied to Taylor models: weights laid out for it, and the panel its neurons live in.

#![allow(clippy::inline_always)] // see `form`

use barrier::LayerWeights;
use pulp::Simd;

use super::form::{AXES, Form};
use super::rounding::{ROUNDING, WIDEN};

/// Most neurons of a layer.
pub(crate) const WIDEST: usize = 48;
/// Signed coefficients of a form, three to a group: twelve sums of four rows fill the registers of AVX2.
const GROUP: usize = 3;
const GROUPS: usize = 5;
/// Rows that are summed together.
const ROWS: usize = 4;
/// Rows whose radii are summed together.
const RADIUS_ROWS: usize = 12;

/// The forms of one layer's neurons, coefficients in groups so that each pass of a layer reads contiguous memory.
pub(crate) struct Panel<S: Simd> {
    signed: [[[S::f64s; GROUP]; WIDEST]; GROUPS],
    radius: [S::f64s; WIDEST],
}

impl<S: Simd> Panel<S> {
    /// Zero everywhere.
    #[inline(always)]
    pub(crate) fn new(simd: S) -> Self {
        let zero = simd.splat_f64s(0.0);
        Self { signed: [[[zero; GROUP]; WIDEST]; GROUPS], radius: [zero; WIDEST] }
    }

    /// The form of one neuron.
    #[inline(always)]
    pub(crate) fn get(&self, neuron: usize) -> Form<S> {
        let column = |k: usize| self.signed[k / GROUP][neuron][k % GROUP];
        Form {
            centre: column(0),
            linear: core::array::from_fn(|i| column(1 + i)),
            quadratic: core::array::from_fn(|k| column(1 + AXES + k)),
            radius: self.radius[neuron],
        }
    }

    /// Replaces the form of one neuron.
    #[inline(always)]
    pub(crate) fn set(&mut self, neuron: usize, form: &Form<S>) {
        let mut put = |k: usize, value| self.signed[k / GROUP][neuron][k % GROUP] = value;
        put(0, form.centre);
        for (i, value) in form.linear.iter().enumerate() {
            put(1 + i, *value);
        }
        for (k, value) in form.quadratic.iter().enumerate() {
            put(1 + AXES + k, *value);
        }
        self.radius[neuron] = form.radius;
    }

    /// The value at the boxes' centres.
    #[inline(always)]
    pub(crate) fn centre(&self, neuron: usize) -> S::f64s {
        self.signed[0][neuron][0]
    }
}

/// An affine layer `y = W a + b`, rows padded with zeros to whole blocks.
pub(crate) struct Layer {
    pub(crate) inputs: usize,
    pub(crate) outputs: usize,
    /// Blocks of rows; within a block one entry per input.
    weight: Vec<[f64; ROWS]>,
    /// `|W|` in blocks of its own.
    size: Vec<[f64; RADIUS_ROWS]>,
    pub(crate) bias: Vec<f64>,
}

impl Layer {
    /// Lays `weights` out.
    pub(crate) fn new(weights: &LayerWeights) -> Self {
        let outputs = weights.bias.len();
        let inputs = weights.weight.len() / outputs;
        let at = |row: usize, input: usize| {
            if row < outputs { f64::from(weights.weight[row * inputs + input]) } else { 0.0 }
        };
        let mut weight = Vec::new();
        for block in 0..outputs.div_ceil(ROWS) {
            weight.extend((0..inputs).map(|i| core::array::from_fn(|r| at(block * ROWS + r, i))));
        }
        let mut size = Vec::new();
        for block in 0..outputs.div_ceil(RADIUS_ROWS) {
            size.extend((0..inputs).map(|i| core::array::from_fn(|r| at(block * RADIUS_ROWS + r, i).abs())));
        }
        Self { inputs, outputs, weight, size, bias: weights.bias.iter().map(|b| f64::from(*b)).collect() }
    }

    /// Largest possible `|y|` where no input exceeds `most`.
    pub(crate) fn most(&self, most: &[f64]) -> f64 {
        let row = |row: usize| {
            let (block, r) = (row / ROWS, row % ROWS);
            let weights = self.weight[block * self.inputs..][..self.inputs].iter();
            weights.zip(most).map(|(w, most)| w[r].abs() * most).sum::<f64>() + self.bias[row].abs()
        };
        (0..self.outputs).map(row).fold(0.0, f64::max)
    }

    /// Root mean square of the weights of one input.
    pub(crate) fn gain(&self, input: usize) -> f64 {
        let column = self.weight.chunks_exact(self.inputs).flat_map(|block| block[input]);
        (column.map(|w| w * w).sum::<f64>() / self.outputs as f64).sqrt()
    }

    /// Computes `y = W a`, and `+ b` where `with_bias`.
    #[inline(always)]
    pub(crate) fn apply<S: Simd>(&self, simd: S, with_bias: bool, a: &Panel<S>, y: &mut Panel<S>) {
        let zero = simd.splat_f64s(0.0);
        for group in 0..GROUPS {
            let a = &a.signed[group][..self.inputs];
            let y = &mut y.signed[group];
            for (block, rows) in self.weight.chunks_exact(self.inputs).enumerate() {
                let mut sums = [[zero; GROUP]; ROWS];
                for (w, a) in rows.iter().zip(a) {
                    for r in 0..ROWS {
                        let w = simd.splat_f64s(w[r]);
                        for k in 0..GROUP {
                            sums[r][k] = simd.mul_add_f64s(w, a[k], sums[r][k]);
                        }
                    }
                }
                y[block * ROWS..][..ROWS].copy_from_slice(&sums);
            }
        }
        let widen = simd.splat_f64s(WIDEN);
        for (block, rows) in self.size.chunks_exact(self.inputs).enumerate() {
            let mut sums = [zero; RADIUS_ROWS];
            for (w, a) in rows.iter().zip(&a.radius) {
                for r in 0..RADIUS_ROWS {
                    sums[r] = simd.mul_add_f64s(simd.splat_f64s(w[r]), *a, sums[r]);
                }
            }
            for r in 0..RADIUS_ROWS {
                y.radius[block * RADIUS_ROWS + r] = simd.mul_f64s(sums[r], widen);
            }
        }
        if with_bias {
            for (row, bias) in self.bias.iter().enumerate() {
                let centre = &mut y.signed[0][row][0];
                *centre = simd.add_f64s(*centre, simd.splat_f64s(*bias));
                let rounding = simd.splat_f64s(2.0 * ROUNDING * bias.abs());
                y.radius[row] = simd.add_f64s(y.radius[row], rounding);
            }
        }
    }

    /// Computes `Wᵀ μ` of plain numbers.
    #[inline(always)]
    pub(crate) fn apply_transposed<S: Simd>(
        &self,
        simd: S,
        mu: &[S::f64s; WIDEST],
        lambda: &mut [S::f64s; WIDEST],
    ) {
        lambda.fill(simd.splat_f64s(0.0));
        for (rows, mu) in self.weight.chunks_exact(self.inputs).zip(mu.chunks_exact(ROWS)) {
            for (w, lambda) in rows.iter().zip(lambda.iter_mut()) {
                for r in 0..ROWS {
                    *lambda = simd.mul_add_f64s(simd.splat_f64s(w[r]), mu[r], *lambda);
                }
            }
        }
    }
}
