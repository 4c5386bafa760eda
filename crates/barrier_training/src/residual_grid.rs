//! The target of the fit: the residual `r = ℓ - V` on a regular grid over the relative state.
//!
//! Interpolating the residual rather than the value keeps the curvature of `ℓ` out of the interpolation error. Not
//! here: how `V` is computed (crate `reachability`).

use crate::error::TargetError;
use serde::{Deserialize, Serialize};

/// One axis of the grid. A periodic axis leaves its maximum out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Axis {
    /// First node, in the unit of the state component.
    pub min: f64,
    /// Last node, or, on a periodic axis, the node that coincides with the first.
    pub max: f64,
    /// Number of nodes, at least 2.
    pub count: usize,
    /// Whether the axis wraps around.
    pub periodic: bool,
}

impl Axis {
    /// Distance of neighbouring nodes.
    pub fn spacing(&self) -> f64 {
        let intervals = if self.periodic { self.count } else { self.count - 1 };
        (self.max - self.min) / intervals as f64
    }

    /// Coordinate of node `index`.
    pub fn node(&self, index: usize) -> f64 {
        self.min + self.spacing() * index as f64
    }

    /// Lower neighbour of `coordinate`, the upper one, and the upper one's weight in `[0, 1]`. Clamps on an axis that
    /// is not periodic.
    fn bracket(&self, coordinate: f64) -> (usize, usize, f64) {
        let position = (coordinate - self.min) / self.spacing();
        if self.periodic {
            let position = position.rem_euclid(self.count as f64);
            let lower = (position as usize).min(self.count - 1);
            (lower, (lower + 1) % self.count, position - lower as f64)
        } else {
            let position = position.clamp(0.0, (self.count - 1) as f64);
            let lower = (position as usize).min(self.count - 2);
            (lower, lower + 1, position - lower as f64)
        }
    }
}

/// Failure function of both pairs: `ℓ(z) = |(z₀, z₁)| - R`, m. Negative inside the failure set.
pub fn failure_function(state: &[f64; 4], failure_radius_m: f64) -> f64 {
    (state[0] * state[0] + state[1] * state[1]).sqrt() - failure_radius_m
}

/// Residual of the value function at the nodes of a grid, row-major with the last axis fastest.
#[derive(Debug, Clone)]
pub struct ResidualGrid {
    axes: [Axis; 4],
    residual_m: Vec<f32>,
    failure_radius_m: f64,
}

impl ResidualGrid {
    /// The residual of `value_m`, the value function at the nodes, m, for the failure radius R, m.
    ///
    /// Rounding may leave `V` above `ℓ` by a hair; such residuals become 0.
    ///
    /// # Errors
    /// A bad axis, a wrong number of values, a value that is not finite or exceeds `ℓ` by more than 1 mm.
    pub fn from_value(axes: [Axis; 4], value_m: &[f32], failure_radius_m: f64) -> Result<Self, TargetError> {
        let mut grid = Self::empty(axes, failure_radius_m)?;
        let nodes = axes.iter().map(|a| a.count).product();
        if value_m.len() != nodes {
            return Err(TargetError::Count { nodes, values: value_m.len() });
        }
        grid.residual_m.reserve_exact(nodes);
        for (index, &value) in value_m.iter().enumerate() {
            let residual = failure_function(&grid.state(index), failure_radius_m) - f64::from(value);
            if !residual.is_finite() {
                return Err(TargetError::NotFinite { index });
            }
            if residual < -1e-3 {
                return Err(TargetError::AboveFailureFunction { index, excess_m: -residual });
            }
            grid.residual_m.push(residual.max(0.0) as f32);
        }
        Ok(grid)
    }

    fn empty(axes: [Axis; 4], failure_radius_m: f64) -> Result<Self, TargetError> {
        for (axis, a) in axes.iter().enumerate() {
            if a.count < 2 || !a.min.is_finite() || !a.max.is_finite() || a.max <= a.min {
                return Err(TargetError::Axis { axis });
            }
        }
        if !(failure_radius_m.is_finite() && failure_radius_m > 0.0) {
            return Err(TargetError::Radius { failure_radius_m });
        }
        Ok(Self { axes, residual_m: Vec::new(), failure_radius_m })
    }

    /// The axes, in the order of the state.
    pub fn axes(&self) -> &[Axis; 4] {
        &self.axes
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.residual_m.len()
    }

    /// Whether there is no node: never, since an axis has at least two.
    pub fn is_empty(&self) -> bool {
        self.residual_m.is_empty()
    }

    /// Radius of the failure set, m.
    pub fn failure_radius_m(&self) -> f64 {
        self.failure_radius_m
    }

    /// Relative state at node `index`.
    pub fn state(&self, index: usize) -> [f64; 4] {
        let mut rest = index;
        let mut state = [0.0; 4];
        for axis in (0..4).rev() {
            state[axis] = self.axes[axis].node(rest % self.axes[axis].count);
            rest /= self.axes[axis].count;
        }
        state
    }

    /// Residual at node `index`, m, ≥ 0.
    pub fn residual_m(&self, index: usize) -> f64 {
        f64::from(self.residual_m[index])
    }

    /// Value function `ℓ - r` at node `index`, m.
    pub fn value_m(&self, index: usize) -> f64 {
        failure_function(&self.state(index), self.failure_radius_m) - self.residual_m(index)
    }

    /// Residual between the nodes, m: multilinear; periodic axes wrap, the others clamp.
    pub fn interpolate_m(&self, state: &[f64; 4]) -> f64 {
        let brackets: [_; 4] = core::array::from_fn(|axis| self.axes[axis].bracket(state[axis]));
        let mut sum = 0.0;
        for corner in 0..16_usize {
            let (mut index, mut weight) = (0, 1.0);
            for axis in 0..4 {
                let (lower, upper, fraction) = brackets[axis];
                let above = corner >> axis & 1 == 1;
                index = index * self.axes[axis].count + if above { upper } else { lower };
                weight *= if above { fraction } else { 1.0 - fraction };
            }
            sum += weight * f64::from(self.residual_m[index]);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axes() -> [Axis; 4] {
        let plain = |min, max, count| Axis { min, max, count, periodic: false };
        let angle = Axis { min: -3.0, max: 3.0, count: 6, periodic: true };
        [plain(-2.0, 2.0, 5), plain(-1.0, 1.0, 3), angle, plain(0.0, 1.5, 4)]
    }

    #[test]
    fn interpolates_a_multilinear_residual_exactly_and_wraps_the_periodic_axis() {
        let residual = |z: &[f64; 4]| 3.0 + 0.5 * z[0] - 0.2 * z[1] * z[3] + 0.1 * z[3];
        let blank = ResidualGrid::empty(axes(), 0.5).unwrap();
        let nodes: usize = axes().iter().map(|a| a.count).product();
        let value: Vec<f32> = (0..nodes)
            .map(|i| blank.state(i))
            .map(|z| (failure_function(&z, 0.5) - residual(&z)) as f32)
            .collect();
        let grid = ResidualGrid::from_value(axes(), &value, 0.5).unwrap();
        for z in [[0.3, 0.7, 1.2, 0.9], [-1.9, -0.4, 2.9, 1.4], [1.1, 0.2, -3.4, 0.1], [2.0, 1.0, 9.5, 1.5]] {
            assert!((grid.interpolate_m(&z) - residual(&z)).abs() < 1e-5, "{z:?}");
        }
        assert!((grid.value_m(17) - f64::from(value[17])).abs() < 1e-6);
    }

    #[test]
    fn refuses_what_cannot_be_a_value_function() {
        let nodes: usize = axes().iter().map(|a| a.count).product();
        let refused = |values: &[f32]| ResidualGrid::from_value(axes(), values, 0.5).unwrap_err();
        assert!(matches!(refused(&vec![-1.0; nodes - 1]), TargetError::Count { .. }));
        assert!(matches!(refused(&vec![9.0; nodes]), TargetError::AboveFailureFunction { .. }));
        assert!(matches!(refused(&vec![f32::NAN; nodes]), TargetError::NotFinite { index: 0 }));
        let mut flat = axes();
        flat[1].max = flat[1].min;
        assert!(matches!(ResidualGrid::from_value(flat, &[], 0.5), Err(TargetError::Axis { axis: 1 })));
        assert!(matches!(ResidualGrid::from_value(axes(), &[], -1.0), Err(TargetError::Radius { .. })));
    }
}
