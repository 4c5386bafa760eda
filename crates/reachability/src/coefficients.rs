//! The dynamics tabulated on the nodes, each coefficient stored as compactly as it varies.
//!
//! `ẋ = f + G_u u + G_d d` and the dissipation never change during a solve, so they are evaluated once,
//! in f64, and kept in f32. Most are zero or depend on a few axes only; storing those as such saves
//! both memory and the time to stream it.

use crate::dissipation::rate_bounds;
use crate::stencil::plane_axes;
use crate::value_file::f32_bytes;
use crate::{Dissipation, Grid, SolveError};
use dynamics::{InputBox, RelativeDynamics};
use rayon::prelude::*;
use sha2::{Digest, Sha256};

/// One coefficient on all nodes.
pub(crate) enum Field {
    /// Zero everywhere.
    Zero,
    /// One number per plane.
    PerPlane(Vec<f32>),
    /// The same plane everywhere.
    Shared(Vec<f32>),
    /// A number per node.
    Full(Vec<f32>),
}

/// One coefficient on the nodes of one plane.
#[derive(Clone, Copy)]
pub(crate) enum OnPlane<'a> {
    Zero,
    Constant(f32),
    Nodes(&'a [f32]),
}

impl Field {
    /// Stores `values`, given per node, in the smallest form that holds them exactly.
    fn compress(values: Vec<f32>, plane_len: usize) -> Self {
        let planes = || values.chunks_exact(plane_len);
        if values.iter().all(|&v| v == 0.0) {
            Self::Zero
        } else if planes().all(|plane| plane.iter().all(|v| *v == plane[0])) {
            Self::PerPlane(planes().map(|plane| plane[0]).collect())
        } else if planes().all(|plane| *plane == values[..plane_len]) {
            Self::Shared(values[..plane_len].to_vec())
        } else {
            Self::Full(values)
        }
    }

    #[inline(always)]
    pub(crate) fn on_plane(&self, plane: usize, plane_len: usize) -> OnPlane<'_> {
        match self {
            Self::Zero => OnPlane::Zero,
            Self::PerPlane(values) => OnPlane::Constant(values[plane]),
            Self::Shared(values) => OnPlane::Nodes(values),
            Self::Full(values) => OnPlane::Nodes(&values[plane * plane_len..][..plane_len]),
        }
    }

    fn hash_into(&self, hash: &mut Sha256) {
        let (form, values): (u8, &[f32]) = match self {
            Self::Zero => (0, &[]),
            Self::PerPlane(values) => (1, values),
            Self::Shared(values) => (2, values),
            Self::Full(values) => (3, values),
        };
        hash.update([form]);
        hash.update(f32_bytes(values));
    }

    pub(crate) fn is_zero(&self) -> bool {
        matches!(self, Self::Zero)
    }
}

/// Everything the Hamiltonian and its dissipation need per node.
pub(crate) struct Coefficients<const N: usize, const NU: usize, const ND: usize> {
    /// `f_i`, state units per second.
    pub(crate) drift: [Field; N],
    /// `(G_u)_ij`.
    pub(crate) control: [[Field; NU]; N],
    /// `(G_d)_ij`.
    pub(crate) disturbance: [[Field; ND]; N],
    /// Bound on `|∂H/∂p_i|`, state units per second; zero where the axis never moves.
    pub(crate) dissipation: [Field; N],
    /// Limits `(min, max)` of each control.
    pub(crate) control_limits: [(f32, f32); NU],
    /// Limits `(min, max)` of each disturbance.
    pub(crate) disturbance_limits: [(f32, f32); ND],
    /// `max_z Σ_i bound_i / spacing_i`, 1/s: the inverse of the longest stable step.
    pub(crate) largest_rate_per_s: f64,
}

impl<const N: usize, const NU: usize, const ND: usize> Coefficients<N, NU, ND> {
    /// Tabulates `dynamics` on `grid`.
    ///
    /// # Errors
    /// * [`SolveError::NonFiniteDynamics`] where a coefficient is NaN, infinite or beyond f32.
    pub(crate) fn new(
        dynamics: &impl RelativeDynamics<N, NU, ND>,
        grid: &Grid<N>,
        dissipation: Dissipation,
    ) -> Result<Self, SolveError> {
        let (u_box, d_box) = (*dynamics.control_box(), *dynamics.disturbance_box());
        let plane_len = grid.axes()[N - plane_axes(N)..].iter().map(|axis| axis.count).product();
        // One pass for all axes: this is the dearest of the functions.
        let mut bounds: Vec<[f32; N]> = vec![[0.0; N]; grid.node_count()];
        let per_spacing = grid.axes().map(|axis| 1.0 / axis.spacing());
        let largest_rate_per_s = bounds
            .par_chunks_mut(plane_len)
            .enumerate()
            .map(|(plane, bounds)| {
                let mut largest = 0.0_f64;
                for (bounds, z) in bounds.iter_mut().zip(grid.states_from(plane * plane_len)) {
                    let exact = rate_bounds(dynamics, &z, dissipation);
                    // NaN must survive, so that it is noticed.
                    let rate: f64 = (0..N).map(|i| exact[i] * per_spacing[i]).sum();
                    largest = if rate <= largest { largest } else { rate };
                    *bounds = exact.map(|bound| bound as f32);
                }
                largest
            })
            .reduce(|| 0.0, |a, b| if a <= b { b } else { a });
        let mut finite = bounds.iter().flatten().all(|bound| bound.is_finite());
        let dissipation = std::array::from_fn(|i| {
            Field::compress(bounds.par_iter().map(|bounds| bounds[i]).collect(), plane_len)
        });
        drop(bounds);

        let mut tabulate = |coefficient: &(dyn Fn(&[f64; N]) -> f64 + Sync)| {
            let mut values = vec![0.0_f32; grid.node_count()];
            values.par_chunks_mut(plane_len).enumerate().for_each(|(plane, values)| {
                for (value, z) in values.iter_mut().zip(grid.states_from(plane * plane_len)) {
                    *value = coefficient(&z) as f32;
                }
            });
            finite &= values.iter().all(|v| v.is_finite());
            Field::compress(values, plane_len)
        };
        let table = Self {
            drift: std::array::from_fn(|i| tabulate(&|z| dynamics.drift(z)[i])),
            control: std::array::from_fn(|i| {
                std::array::from_fn(|j| tabulate(&|z| dynamics.control_jacobian(z)[i][j]))
            }),
            disturbance: std::array::from_fn(|i| {
                std::array::from_fn(|j| tabulate(&|z| dynamics.disturbance_jacobian(z)[i][j]))
            }),
            dissipation,
            control_limits: limits(&u_box),
            disturbance_limits: limits(&d_box),
            largest_rate_per_s,
        };
        if finite { Ok(table) } else { Err(SolveError::NonFiniteDynamics) }
    }

    /// Adds every number of the table to `hash`.
    pub(crate) fn hash_into(&self, hash: &mut Sha256) {
        let jacobians = self.control.iter().flatten().chain(self.disturbance.iter().flatten());
        for field in self.drift.iter().chain(jacobians).chain(&self.dissipation) {
            field.hash_into(hash);
        }
        for (min, max) in self.control_limits.iter().chain(&self.disturbance_limits) {
            hash.update(f32_bytes(&[*min, *max]));
        }
        hash.update(self.largest_rate_per_s.to_le_bytes());
    }
}

fn limits<const M: usize>(input: &InputBox<M>) -> [(f32, f32); M] {
    std::array::from_fn(|j| (input.min[j] as f32, input.max[j] as f32))
}
