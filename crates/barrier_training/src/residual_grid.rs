//! The target of the fit: the residual `r = ℓ - V` on a regular grid over the relative state.
//!
//! Interpolating the residual rather than the value keeps the curvature of `ℓ` out of the interpolation error. Not
//! here: how `V` is computed (crate `reachability`).

use crate::error::TargetError;
use reachability::{Axis, Grid, ValueFunction};

/// Failure function of both pairs: `ℓ(z) = |(z₀, z₁)| - R`, m. Negative inside the failure set.
pub fn failure_function(state: &[f64; 4], failure_radius_m: f64) -> f64 {
    (state[0] * state[0] + state[1] * state[1]).sqrt() - failure_radius_m
}

/// Residual of the value function at the nodes of a grid, m.
#[derive(Debug, Clone)]
pub struct ResidualGrid {
    grid: Grid<4>,
    residual_m: Vec<f32>,
    failure_radius_m: f64,
}

impl ResidualGrid {
    /// The residual of `value_m`, the value function at the nodes (last axis fastest), m, for the failure radius R, m.
    ///
    /// Rounding may leave `V` above `ℓ` by a hair; such residuals become 0.
    ///
    /// # Errors
    /// A bad radius, a wrong number of values, a value that is not finite or exceeds `ℓ` by more than 1 mm.
    pub fn new(grid: Grid<4>, value_m: &[f32], failure_radius_m: f64) -> Result<Self, TargetError> {
        if !(failure_radius_m.is_finite() && failure_radius_m > 0.0) {
            return Err(TargetError::Radius { failure_radius_m });
        }
        let nodes = grid.node_count();
        if value_m.len() != nodes {
            return Err(TargetError::Count { nodes, values: value_m.len() });
        }
        let mut residual_m = Vec::with_capacity(nodes);
        for (node, &value) in value_m.iter().enumerate() {
            let residual = failure_function(&grid.state(node), failure_radius_m) - f64::from(value);
            if !residual.is_finite() {
                return Err(TargetError::NotFinite { node });
            }
            if residual < -1e-3 {
                return Err(TargetError::AboveFailureFunction { node, excess_m: -residual });
            }
            residual_m.push(residual.max(0.0) as f32);
        }
        Ok(Self { grid, residual_m, failure_radius_m })
    }

    /// The axes, in the order of the state.
    pub fn axes(&self) -> &[Axis; 4] {
        self.grid.axes()
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.residual_m.len()
    }

    /// Radius of the failure set, m.
    pub fn failure_radius_m(&self) -> f64 {
        self.failure_radius_m
    }

    /// Relative state at a node.
    pub fn state(&self, node: usize) -> [f64; 4] {
        self.grid.state(node)
    }

    /// Residual at a node, m, ≥ 0.
    pub fn residual_m(&self, node: usize) -> f64 {
        f64::from(self.residual_m[node])
    }

    /// Value function `ℓ - r` at a node, m.
    pub fn value_m(&self, node: usize) -> f64 {
        failure_function(&self.state(node), self.failure_radius_m) - self.residual_m(node)
    }

    /// Residual between the nodes, m: multilinear, periodic axes wrap. Nothing outside a bounded axis.
    pub fn interpolate_m(&self, state: &[f64; 4]) -> Option<f64> {
        let mut residual = 0.0;
        let mut add = |index: &[usize; 4], weight: f64| {
            residual += weight * f64::from(self.residual_m[self.grid.node(index)]);
        };
        self.grid.locate(state)?.for_each_corner(&mut add);
        Some(residual)
    }
}

impl TryFrom<&ValueFunction> for ResidualGrid {
    type Error = TargetError;

    fn try_from(value: &ValueFunction) -> Result<Self, TargetError> {
        Self::new(*value.grid(), value.values(), value.metadata().problem.failure_radius_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Grid<4> {
        let angle = Axis::periodic(-3.0, 3.0, 6);
        Grid::new([
            Axis::bounded(-2.0, 2.0, 5),
            Axis::bounded(-1.0, 1.0, 4),
            angle,
            Axis::bounded(0.0, 1.5, 4),
        ])
        .unwrap()
    }

    #[test]
    fn interpolates_a_multilinear_residual_exactly_and_wraps_the_periodic_axis() {
        let residual = |z: &[f64; 4]| 3.0 + 0.5 * z[0] - 0.2 * z[1] * z[3] + 0.1 * z[3];
        let states = (0..grid().node_count()).map(|node| grid().state(node));
        let value: Vec<f32> = states.map(|z| (failure_function(&z, 0.5) - residual(&z)) as f32).collect();
        let target = ResidualGrid::new(grid(), &value, 0.5).unwrap();
        for z in [[0.3, 0.7, 1.2, 0.9], [-1.9, -0.4, 2.9, 1.4], [1.1, 0.2, -3.4, 0.1], [2.0, 1.0, 9.5, 1.5]] {
            assert!((target.interpolate_m(&z).unwrap() - residual(&z)).abs() < 1e-5, "{z:?}");
        }
        assert_eq!(target.interpolate_m(&[2.1, 0.0, 0.0, 0.0]), None);
        assert!((target.value_m(17) - f64::from(value[17])).abs() < 1e-6);
    }

    #[test]
    fn refuses_what_cannot_be_a_value_function() {
        let nodes = grid().node_count();
        let refused = |values: &[f32]| ResidualGrid::new(grid(), values, 0.5).unwrap_err();
        assert!(matches!(refused(&vec![-1.0; nodes - 1]), TargetError::Count { .. }));
        assert!(matches!(refused(&vec![9.0; nodes]), TargetError::AboveFailureFunction { .. }));
        assert!(matches!(refused(&vec![f32::NAN; nodes]), TargetError::NotFinite { node: 0 }));
        assert!(matches!(ResidualGrid::new(grid(), &[], -1.0), Err(TargetError::Radius { .. })));
    }
}
