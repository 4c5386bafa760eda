//! How much a value function changed where the edge of the grid does not show.

use crate::Grid;
use crate::coefficients::Coefficients;
use rayon::prelude::*;

/// The nodes away from extrapolated ends.
pub(crate) struct Interior<const N: usize> {
    grid: Grid<N>,
    /// First and last interior index per axis.
    range: [(usize, usize); N],
}

impl<const N: usize> Interior<N> {
    pub(crate) fn new<const NU: usize, const ND: usize>(
        grid: &Grid<N>,
        coefficients: &Coefficients<N, NU, ND>,
        boundary_layer: f64,
    ) -> Self {
        let range = std::array::from_fn(|d| {
            let axis = grid.axes()[d];
            // Nothing is extrapolated along an axis that closes on itself or never moves.
            let exact = axis.periodic || coefficients.dissipation[d].is_zero();
            let layer = if exact { 0 } else { (boundary_layer * axis.count as f64).floor() as usize };
            (layer, axis.count - 1 - layer)
        });
        Self { grid: *grid, range }
    }

    /// Returns `max |values − before|` over the interior, m.
    pub(crate) fn max_change(&self, values: &[f32], before: &[f32]) -> f64 {
        let largest = (0..values.len())
            .into_par_iter()
            .filter(|&node| {
                let index = self.grid.index(node);
                (0..N).all(|d| (self.range[d].0..=self.range[d].1).contains(&index[d]))
            })
            .map(|node| (values[node] - before[node]).abs())
            .reduce(|| 0.0, f32::max);
        f64::from(largest)
    }
}
