//! A solved value function together with the problem it belongs to: look-up and gradient between nodes.
//!
//! Not here: reading and writing (`value_file`).

use crate::{Axis, Grid, HistoryEntry, Outcome, Solution, SolverSettings};
use dynamics::InputBox;
use serde::{Deserialize, Serialize};

/// Limits of an input, one entry per component, in the component's unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputLimits {
    /// Lower ends.
    pub min: Vec<f64>,
    /// Upper ends.
    pub max: Vec<f64>,
}

impl<const M: usize> From<&InputBox<M>> for InputLimits {
    fn from(input: &InputBox<M>) -> Self {
        Self { min: input.min.to_vec(), max: input.max.to_vec() }
    }
}

/// The game that was solved, in words and numbers, for whoever uses the result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProblemDescription {
    /// Name of the relative dynamics, e.g. `unicycle_pair`.
    pub dynamics: String,
    /// Limits of the robot's input.
    pub control: InputLimits,
    /// Limits of the obstacle's input.
    pub disturbance: InputLimits,
    /// `R` of the failure function `ℓ(z) = |p| − R`, m.
    pub failure_radius_m: f64,
}

/// What a value file says about its values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ValueMetadata {
    /// The game.
    pub problem: ProblemDescription,
    /// The grid, axis by axis.
    pub grid: Vec<Axis>,
    /// Scheme and stopping rule.
    pub solver: SolverSettings,
    /// Horizon reached, s.
    pub horizon_s: f64,
    /// Time steps taken.
    pub steps: u64,
    /// Why the solve ended.
    pub outcome: Outcome,
    /// Convergence checks, oldest first.
    pub history: Vec<HistoryEntry>,
    /// SHA-256 of the values as little-endian f32, in hexadecimal.
    pub value_sha256: String,
}

/// A value function `V(z)` on a grid, m.
#[derive(Debug, Clone, PartialEq)]
pub struct ValueFunction<const N: usize = 4> {
    pub(crate) grid: Grid<N>,
    pub(crate) values: Vec<f32>,
    pub(crate) metadata: ValueMetadata,
}

impl<const N: usize> ValueFunction<N> {
    /// Joins a solution and the problem it solves.
    pub fn new(solution: Solution<N>, problem: ProblemDescription) -> Self {
        let Solution { grid, values, settings, horizon_s, steps, outcome, history } = solution;
        let metadata = ValueMetadata {
            problem,
            grid: grid.axes().to_vec(),
            solver: settings,
            horizon_s,
            steps,
            outcome,
            history,
            value_sha256: crate::value_file::sha256_of(&values),
        };
        Self { grid, values, metadata }
    }

    /// Returns the grid.
    pub fn grid(&self) -> &Grid<N> {
        &self.grid
    }

    /// Returns `V` per node, m, last axis fastest.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Returns how the values came about.
    pub fn metadata(&self) -> &ValueMetadata {
        &self.metadata
    }

    /// Returns `V(z)`, m, multilinear between nodes and periodic where the grid is.
    ///
    /// Nothing is returned outside a bounded axis or where `z` is not finite.
    pub fn interpolate(&self, z: &[f64; N]) -> Option<f64> {
        let mut value = 0.0;
        self.grid.locate(z)?.for_each_corner(|index, weight| value += weight * self.at(index));
        Some(value)
    }

    /// Returns `∇V(z)`, m per state unit: differences at the nodes, multilinear between them.
    ///
    /// Differences are central, one-sided at the ends of bounded axes. Nothing is returned where
    /// [`Self::interpolate`] returns nothing.
    pub fn gradient(&self, z: &[f64; N]) -> Option<[f64; N]> {
        let mut gradient = [0.0; N];
        self.grid.locate(z)?.for_each_corner(|index, weight| {
            for d in 0..N {
                gradient[d] += weight * self.difference(index, d);
            }
        });
        Some(gradient)
    }

    /// Returns `V` at the node with these indices.
    fn at(&self, index: &[usize; N]) -> f64 {
        f64::from(self.values[self.grid.node(index)])
    }

    /// Returns the difference quotient along axis `d` at a node.
    fn difference(&self, index: &[usize; N], d: usize) -> f64 {
        let axis = &self.grid.axes()[d];
        let (i, last) = (index[d], axis.count - 1);
        let (below, above, cells) = match (i == 0, i == last, axis.periodic) {
            (true, _, true) => (last, 1, 2.0),
            (_, true, true) => (i - 1, 0, 2.0),
            (true, _, false) => (0, 1, 1.0),
            (_, true, false) => (i - 1, i, 1.0),
            (false, false, _) => (i - 1, i + 1, 2.0),
        };
        let with = |j: usize| {
            let mut neighbour = *index;
            neighbour[d] = j;
            self.at(&neighbour)
        };
        (with(above) - with(below)) / (cells * axis.spacing())
    }
}
