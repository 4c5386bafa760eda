//! States of known value, to measure a fit at.

use crate::closed_form::ClosedForm;
use crate::residual_grid::ResidualGrid;
use rand::RngExt;
use rand_pcg::Pcg64;
use rayon::prelude::*;
use reachability::Axis;

/// States drawn where there is no grid, and for the barrier condition.
const STATES: usize = 100_000;
/// States per random stream.
const CHUNK: usize = 1000;
/// Seed of the states: the same for every fit, and no stream of a training run.
const SEED: u128 = 0x6a75_6467;

/// States of known value.
#[derive(Debug, Clone, PartialEq)]
pub struct Judge {
    /// Relative states, in and outside the failure set.
    pub states: Vec<[f64; 4]>,
    /// Value at each, m.
    pub value_m: Vec<f64>,
    /// `R` of the failure function, m.
    pub failure_radius_m: f64,
    /// The domain; the numbers of nodes do not matter.
    pub axes: [Axis; 4],
    /// Whether the states are the nodes of a grid with these axes.
    pub on_grid: bool,
}

impl Judge {
    /// The nodes of a grid.
    pub fn of_grid(grid: &ResidualGrid) -> Self {
        let nodes = 0..grid.node_count();
        Self {
            states: nodes.clone().map(|node| grid.state(node)).collect(),
            value_m: nodes.map(|node| grid.value_m(node)).collect(),
            failure_radius_m: grid.failure_radius_m(),
            axes: *grid.axes(),
            on_grid: true,
        }
    }

    /// 100,000 states drawn uniformly from the box, none of which a fit is shown.
    pub fn of_closed_form(target: &ClosedForm, axes: [Axis; 4]) -> Self {
        let states = uniform_states(&axes, STATES);
        let value_m = states.par_iter().map(|state| target.value_m(state)).collect();
        Self { states, value_m, failure_radius_m: target.failure_radius_m(), axes, on_grid: false }
    }
}

/// `count` states drawn uniformly from the box of `axes`; the same ones whenever asked.
pub fn uniform_states(axes: &[Axis; 4], count: usize) -> Vec<[f64; 4]> {
    let mut states = vec![[0.0; 4]; count];
    states.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, states)| {
        let mut rng = Pcg64::new(SEED, chunk as u128);
        states.fill_with(|| core::array::from_fn(|k| rng.random_range(axes[k].min..axes[k].max)));
    });
    states
}
