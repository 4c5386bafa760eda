//! Rectangular grids: node positions, node order, and the cell around a state.
//!
//! Not here: values on the nodes (`value_function`) and ghost nodes (`stencil`).

use serde::{Deserialize, Serialize};

/// Fewest nodes an axis may have: with fewer, the upwind stencils would wrap onto themselves.
pub const MIN_NODES: usize = 4;

/// One axis of a grid, in the unit of the state it divides.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// First node.
    pub min: f64,
    /// Last node, or for a periodic axis the point one period after the first node, which has no node.
    pub max: f64,
    /// Number of nodes.
    pub count: usize,
    /// Whether `max` is the same state as `min`.
    pub periodic: bool,
}

impl Axis {
    /// Returns an axis with a node at both ends.
    pub fn bounded(min: f64, max: f64, count: usize) -> Self {
        Self { min, max, count, periodic: false }
    }

    /// Returns an axis that closes on itself, such as an angle.
    pub fn periodic(min: f64, max: f64, count: usize) -> Self {
        Self { min, max, count, periodic: true }
    }

    /// Returns the distance between neighbouring nodes.
    pub fn spacing(&self) -> f64 {
        let cells = if self.periodic { self.count } else { self.count - 1 };
        (self.max - self.min) / cells as f64
    }

    /// Returns the position of node `index`.
    pub fn coordinate(&self, index: usize) -> f64 {
        self.min + index as f64 * self.spacing()
    }

    /// Returns the nodes on either side of `position` and the fraction of the way from one to the other.
    fn locate(&self, position: f64) -> Option<(usize, usize, f64)> {
        let steps = (position - self.min) / self.spacing();
        if !steps.is_finite() {
            return None;
        }
        if self.periodic {
            let steps = steps.rem_euclid(self.count as f64);
            let low = (steps.floor() as usize).min(self.count - 1);
            return Some((low, (low + 1) % self.count, steps - low as f64));
        }
        let last = (self.count - 1) as f64;
        // The end node itself must be inside although its position is rounded.
        let slack = 1e-9 * last;
        if steps < -slack || steps > last + slack {
            return None;
        }
        let low = (steps.clamp(0.0, last).floor() as usize).min(self.count - 2);
        Some((low, low + 1, (steps - low as f64).clamp(0.0, 1.0)))
    }
}

/// Why axes do not make a grid.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum GridError {
    /// Not two to four axes.
    #[error("a grid of {axes} axes is not supported; give 2, 3 or 4")]
    Axes {
        /// Axes given.
        axes: usize,
    },
    /// An end is NaN, infinite, or not above the other.
    #[error("axis {axis} runs from {min} to {max}; give finite ends, the first below the second")]
    Range {
        /// Index of the axis.
        axis: usize,
        /// First end given.
        min: f64,
        /// Second end given.
        max: f64,
    },
    /// Too few nodes for the stencils.
    #[error("axis {axis} has {count} nodes; give at least {MIN_NODES}")]
    TooFewNodes {
        /// Index of the axis.
        axis: usize,
        /// Nodes given.
        count: usize,
    },
    /// More nodes than can be addressed.
    #[error("the grid has more nodes than this machine can address; give fewer nodes per axis")]
    TooManyNodes,
}

/// A rectangular grid of `N` axes. Nodes are stored with the last axis fastest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid<const N: usize> {
    axes: [Axis; N],
}

/// The cell of a grid that holds a state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell<const N: usize> {
    /// Index per axis of the corner below.
    pub low: [usize; N],
    /// Index per axis of the corner above, wrapped on periodic axes.
    pub high: [usize; N],
    /// Position between them per axis, in `[0, 1]`.
    pub fraction: [f64; N],
}

impl<const N: usize> Grid<N> {
    /// Returns the grid spanned by `axes`.
    ///
    /// # Errors
    /// A [`GridError`] that names the first axis at fault.
    pub fn new(axes: [Axis; N]) -> Result<Self, GridError> {
        if !(2..=4).contains(&N) {
            return Err(GridError::Axes { axes: N });
        }
        let mut nodes = 1_usize;
        for (axis, a) in axes.iter().enumerate() {
            if !(a.min.is_finite() && a.max.is_finite() && a.min < a.max && (a.max - a.min).is_finite()) {
                return Err(GridError::Range { axis, min: a.min, max: a.max });
            }
            if a.count < MIN_NODES {
                return Err(GridError::TooFewNodes { axis, count: a.count });
            }
            nodes = nodes.checked_mul(a.count).ok_or(GridError::TooManyNodes)?;
        }
        // Vec cannot hold more than `isize::MAX` bytes.
        if nodes > isize::MAX as usize / size_of::<f64>() {
            return Err(GridError::TooManyNodes);
        }
        Ok(Self { axes })
    }

    /// Returns the axes.
    pub fn axes(&self) -> &[Axis; N] {
        &self.axes
    }

    /// Returns the number of nodes per axis.
    pub fn shape(&self) -> [usize; N] {
        self.axes.map(|a| a.count)
    }

    /// Returns the number of nodes.
    pub fn node_count(&self) -> usize {
        self.axes.iter().map(|a| a.count).product()
    }

    /// Returns how far apart in storage neighbours along each axis lie.
    pub fn strides(&self) -> [usize; N] {
        std::array::from_fn(|d| self.axes[d + 1..].iter().map(|a| a.count).product())
    }

    /// Returns the index per axis of the node stored at `node`.
    pub fn index(&self, node: usize) -> [usize; N] {
        let strides = self.strides();
        std::array::from_fn(|d| node / strides[d] % self.axes[d].count)
    }

    /// Returns where the node with these indices is stored.
    pub fn node(&self, index: &[usize; N]) -> usize {
        let strides = self.strides();
        (0..N).map(|d| index[d] * strides[d]).sum()
    }

    /// Returns the state at the node stored at `node`.
    pub fn state(&self, node: usize) -> [f64; N] {
        let index = self.index(node);
        std::array::from_fn(|d| self.axes[d].coordinate(index[d]))
    }

    /// Returns the states of the nodes stored from `node` on, in their order; faster than one [`Self::state`] each.
    pub(crate) fn states_from(&self, node: usize) -> impl Iterator<Item = [f64; N]> + use<N> {
        let axes = self.axes;
        let mut index = self.index(node);
        let mut state: [f64; N] = std::array::from_fn(|d| axes[d].coordinate(index[d]));
        std::iter::from_fn(move || {
            let current = state;
            for d in (0..N).rev() {
                index[d] += 1;
                if index[d] < axes[d].count {
                    state[d] = axes[d].coordinate(index[d]);
                    break;
                }
                index[d] = 0;
                state[d] = axes[d].coordinate(0);
            }
            Some(current)
        })
    }

    /// Returns the cell around `z`, or nothing where `z` is outside a bounded axis or not finite.
    pub fn locate(&self, z: &[f64; N]) -> Option<Cell<N>> {
        let mut cell = Cell { low: [0; N], high: [0; N], fraction: [0.0; N] };
        for d in 0..N {
            (cell.low[d], cell.high[d], cell.fraction[d]) = self.axes[d].locate(z[d])?;
        }
        Some(cell)
    }
}

impl<const N: usize> Cell<N> {
    /// Calls `visit` with the indices and the multilinear weight of each of the `2^N` corners.
    pub fn for_each_corner(&self, mut visit: impl FnMut(&[usize; N], f64)) {
        for corner in 0..1_usize << N {
            let mut weight = 1.0;
            let index = std::array::from_fn(|d| {
                let above = corner >> d & 1 == 1;
                weight *= if above { self.fraction[d] } else { 1.0 - self.fraction[d] };
                if above { self.high[d] } else { self.low[d] }
            });
            visit(&index, weight);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_in_a_row_are_those_of_their_nodes() {
        let grid =
            Grid::new([Axis::bounded(-1.0, 2.0, 5), Axis::periodic(0.0, 3.0, 4), Axis::bounded(0.1, 0.7, 6)])
                .unwrap();
        for from in [0, 7, 53] {
            for (offset, state) in grid.states_from(from).take(grid.node_count() - from).enumerate() {
                assert_eq!(state, grid.state(from + offset));
            }
        }
    }
}
