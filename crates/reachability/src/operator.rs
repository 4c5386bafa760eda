//! The numerical Hamiltonian of one plane of nodes.
//!
//! Local Lax–Friedrichs: `Ĥ = H(z, (p⁻ + p⁺)/2) + Σ_i α_i (p⁺_i − p⁻_i)/2` with one-sided gradients `p±`
//! and `α_i ≥ |∂H/∂p_i|`. The sign of the dissipation belongs to a value that runs backward in time.

use crate::coefficients::{Coefficients, OnPlane};
use crate::stencil::{GhostBuffers, PlaneLayout, plane_axes};
use crate::upwind::derivatives;
use crate::{Grid, TubeForm, UpwindScheme};

/// Evaluates `Ĥ` on planes of a grid.
pub(crate) struct Operator<const N: usize, const NU: usize, const ND: usize> {
    coefficients: Coefficients<N, NU, ND>,
    layout: PlaneLayout<N>,
    row_len: usize,
    inverse_spacing: [f32; N],
    scheme: UpwindScheme,
    tube: TubeForm,
}

/// Buffers of one worker.
pub(crate) struct Scratch<const N: usize> {
    ghosts: GhostBuffers,
    left: Vec<f32>,
    right: Vec<f32>,
    wide_left: Vec<f32>,
    wide_right: Vec<f32>,
    /// `(p⁻_i + p⁺_i)/2` per axis.
    gradient: [Vec<f32>; N],
    /// `p·G_j`, the influence of one input.
    influence: Vec<f32>,
}

impl<const N: usize, const NU: usize, const ND: usize> Operator<N, NU, ND> {
    pub(crate) fn new(
        coefficients: Coefficients<N, NU, ND>,
        grid: &Grid<N>,
        scheme: UpwindScheme,
        tube: TubeForm,
    ) -> Self {
        Self {
            coefficients,
            layout: PlaneLayout::new(grid, scheme.radius()),
            row_len: grid.axes()[N - 1].count,
            inverse_spacing: grid.axes().map(|a| (1.0 / a.spacing()) as f32),
            scheme,
            tube,
        }
    }

    pub(crate) fn coefficients(&self) -> &Coefficients<N, NU, ND> {
        &self.coefficients
    }

    pub(crate) fn plane_len(&self) -> usize {
        self.layout.plane_len()
    }

    pub(crate) fn scratch(&self) -> Scratch<N> {
        let plane = || vec![0.0; self.layout.plane_len()];
        let wide = || vec![0.0; self.layout.padded_run()];
        Scratch {
            ghosts: self.layout.buffers(),
            left: plane(),
            right: plane(),
            wide_left: wide(),
            wide_right: wide(),
            gradient: std::array::from_fn(|_| plane()),
            influence: plane(),
        }
    }

    /// Writes `Ĥ` (frozen at zero from above if so set) of plane `plane` of `values` to `rate`, m/s.
    #[inline(always)]
    pub(crate) fn rate(&self, values: &[f32], plane: usize, scratch: &mut Scratch<N>, rate: &mut [f32]) {
        let len = self.plane_len();
        let c = &self.coefficients;
        rate.fill(0.0);
        for axis in 0..N {
            if c.dissipation[axis].is_zero() {
                continue;
            }
            self.one_sided(values, plane, axis, scratch);
            let Scratch { left, right, gradient, .. } = &mut *scratch;
            for ((mean, &left), &right) in gradient[axis].iter_mut().zip(&*left).zip(&*right) {
                *mean = 0.5 * (left + right);
            }
            for (jump, &right) in left.iter_mut().zip(&*right) {
                *jump = 0.5 * (right - *jump);
            }
            add_product(rate, c.dissipation[axis].on_plane(plane, len), left);
            add_product(rate, c.drift[axis].on_plane(plane, len), &gradient[axis]);
        }
        for j in 0..NU {
            self.influence(scratch, |i| c.control[i][j].on_plane(plane, len));
            let (min, max) = c.control_limits[j];
            for (rate, &s) in rate.iter_mut().zip(&scratch.influence) {
                *rate += (s * min).max(s * max);
            }
        }
        for j in 0..ND {
            self.influence(scratch, |i| c.disturbance[i][j].on_plane(plane, len));
            let (min, max) = c.disturbance_limits[j];
            for (rate, &s) in rate.iter_mut().zip(&scratch.influence) {
                *rate += (s * min).min(s * max);
            }
        }
        match self.tube {
            TubeForm::Variational => {}
            TubeForm::Freezing => {
                for rate in rate {
                    *rate = if *rate > 0.0 { 0.0 } else { *rate };
                }
            }
        }
    }

    /// Sums `p_i · column(i)` over the axes that move.
    #[inline(always)]
    fn influence<'a>(&self, scratch: &mut Scratch<N>, column: impl Fn(usize) -> OnPlane<'a>) {
        scratch.influence.fill(0.0);
        for i in 0..N {
            if !self.coefficients.dissipation[i].is_zero() {
                add_product(&mut scratch.influence, column(i), &scratch.gradient[i]);
            }
        }
    }

    /// Writes both one-sided derivatives along `axis` to `scratch.left` and `scratch.right`.
    #[inline(always)]
    fn one_sided(&self, values: &[f32], plane: usize, axis: usize, scratch: &mut Scratch<N>) {
        let len = self.plane_len();
        let per_unit = self.inverse_spacing[axis];
        let centre = &values[plane * len..][..len];
        let Scratch { ghosts, left, right, wide_left, wide_right, .. } = scratch;
        if axis + 1 < N {
            let stencil = if axis + plane_axes(N) < N {
                self.layout.along_leading(values, plane, axis, ghosts)
            } else {
                self.layout.along_last_but_one(centre, ghosts)
            };
            derivatives(self.scheme, &stencil, per_unit, left, right);
        } else {
            let stencil = self.layout.along_last(centre, ghosts);
            derivatives(self.scheme, &stencil, per_unit, wide_left, wide_right);
            let width = self.layout.padded_row();
            for (narrow, wide) in [(left, wide_left), (right, wide_right)] {
                for (narrow, wide) in narrow.chunks_exact_mut(self.row_len).zip(wide.chunks(width)) {
                    narrow.copy_from_slice(&wide[..self.row_len]);
                }
            }
        }
    }
}

/// `out += coefficient · factor`, node by node.
#[inline(always)]
fn add_product(out: &mut [f32], coefficient: OnPlane<'_>, factor: &[f32]) {
    match coefficient {
        OnPlane::Zero => {}
        OnPlane::Constant(c) => {
            for (out, &factor) in out.iter_mut().zip(factor) {
                *out += c * factor;
            }
        }
        OnPlane::Nodes(nodes) => {
            for ((out, &c), &factor) in out.iter_mut().zip(nodes).zip(factor) {
                *out += c * factor;
            }
        }
    }
}
