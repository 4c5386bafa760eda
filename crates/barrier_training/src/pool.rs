//! The pool of training samples: drawn once, block by block, from a seed.
//!
//! The boundary of the safe set fills a few percent of the domain, so the pool draws by stratum (near the zero level,
//! active residual, inside the failure set, anywhere outside). Every block has a random stream of its own: the pool
//! does not depend on the number of threads.

use crate::block::{OVERESTIMATE_ROW, SAMPLE_BLOCK, SAMPLE_ROWS, TARGET_ROW};
use crate::panel::{BLOCK, Lanes, PANEL, at_mut, groups};
use crate::recipe::Recipe;
use crate::residual_grid::{ResidualGrid, failure_function};
use rand::RngExt;
use rand_pcg::Pcg64;
use rayon::prelude::*;

/// Residual beyond which a node is active, m.
const ACTIVE_M: f64 = 0.02;

/// A node, shown at its own place or one period away along some axis.
#[derive(Debug, Clone, Copy)]
struct Entry {
    node: u32,
    /// Bit 2k: one period below along axis k; bit 2k+1: one above.
    wrap: u8,
}

/// Samples in panels, `SAMPLE_BLOCK` lane groups per block.
pub(crate) struct Pool {
    samples: Vec<Lanes>,
}

impl Pool {
    /// Draws `recipe.pool_samples` samples; `margin_m` is added to every target residual.
    pub(crate) fn draw(grid: &ResidualGrid, recipe: &Recipe, margin_m: f64, seed: u64) -> Self {
        let strata = Strata::of(grid, recipe);
        let blocks = recipe.pool_samples.div_ceil(BLOCK);
        let mut samples = vec![Lanes::ZERO; blocks * SAMPLE_BLOCK];
        samples.par_chunks_exact_mut(SAMPLE_BLOCK).enumerate().for_each(|(block, samples)| {
            let mut rng = Pcg64::new(u128::from(seed), block as u128);
            for panel in samples.chunks_exact_mut(groups(SAMPLE_ROWS)) {
                for i in 0..PANEL {
                    let entry = strata.pick(&mut rng);
                    let state = place(grid, recipe, entry, &mut rng);
                    let residual = grid.interpolate_m(&state).unwrap_or(0.0);
                    let value = failure_function(&state, grid.failure_radius_m()) - residual;
                    let nearness = (1.0 - value.abs() / recipe.near_band_m).max(0.0);
                    for k in 0..4 {
                        *at_mut(panel, k, i) = state[k] as f32;
                    }
                    *at_mut(panel, TARGET_ROW, i) = (residual + margin_m) as f32;
                    *at_mut(panel, OVERESTIMATE_ROW, i) =
                        (1.0 + recipe.overestimate_weight * nearness) as f32;
                }
            }
        });
        Self { samples }
    }

    /// Number of blocks.
    pub(crate) fn blocks(&self) -> usize {
        self.samples.len() / SAMPLE_BLOCK
    }

    /// The samples of one block.
    pub(crate) fn block(&self, block: usize) -> &[Lanes] {
        &self.samples[block * SAMPLE_BLOCK..][..SAMPLE_BLOCK]
    }

    /// Mean target of the pool, m.
    pub(crate) fn mean_target_m(&self) -> f64 {
        let panels = self.samples.chunks_exact(groups(SAMPLE_ROWS));
        let rows = panels.flat_map(|panel| &panel[groups(TARGET_ROW)..groups(TARGET_ROW + 1)]);
        rows.map(|lanes| f64::from(lanes.sum())).sum::<f64>() / (self.blocks() * BLOCK) as f64
    }
}

/// The state shown for `entry`: the node, or a point of its cell.
fn place(grid: &ResidualGrid, recipe: &Recipe, entry: Entry, rng: &mut Pcg64) -> [f64; 4] {
    let node = grid.state(entry.node as usize);
    let jitter = rng.random_bool(recipe.jitter_share);
    core::array::from_fn(|k| {
        let axis = &grid.axes()[k];
        let offset = if jitter { rng.random_range(-0.5..0.5) * axis.spacing() } else { 0.0 };
        let period = axis.max - axis.min;
        match entry.wrap >> (2 * k) & 3 {
            1 => node[k] + offset - period,
            2 => node[k] + offset + period,
            _ if axis.periodic => node[k] + offset,
            _ => (node[k] + offset).clamp(axis.min, axis.max),
        }
    })
}

/// Lists of entries and the shares they are drawn with.
struct Strata {
    lists: [Vec<Entry>; 4],
    /// Cumulative shares, the last 1.
    cumulative: [f64; 4],
}

impl Strata {
    fn of(grid: &ResidualGrid, recipe: &Recipe) -> Self {
        let [mut near, mut active, mut inside, mut outside] = [const { Vec::new() }; 4];
        for index in 0..grid.node_count() {
            let state = grid.state(index);
            let failure = failure_function(&state, grid.failure_radius_m());
            for wrap in wraps(grid, recipe, &state) {
                let entry = Entry { node: index as u32, wrap };
                if failure <= 0.0 {
                    inside.push(entry);
                    continue;
                }
                outside.push(entry);
                if grid.value_m(index).abs() < recipe.near_band_m {
                    near.push(entry);
                }
                if grid.residual_m(index) > ACTIVE_M {
                    active.push(entry);
                }
            }
        }
        // A stratum without nodes (a coarse grid may have none near the zero level) yields its share to the others.
        let share = |list: &Vec<Entry>, share: f64| if list.is_empty() { 0.0 } else { share };
        let rest = 1.0 - recipe.share_near - recipe.share_active - recipe.share_inside;
        let shares = [
            share(&near, recipe.share_near),
            share(&active, recipe.share_active),
            share(&inside, recipe.share_inside),
            share(&outside, rest.max(1e-6)),
        ];
        let total: f64 = shares.iter().sum();
        let mut sum = 0.0;
        let cumulative = shares.map(|s| {
            sum += s / total;
            sum
        });
        Self { lists: [near, active, inside, outside], cumulative }
    }

    fn pick(&self, rng: &mut Pcg64) -> Entry {
        let u: f64 = rng.random();
        let last_filled = self.lists.iter().rposition(|list| !list.is_empty()).unwrap_or(0);
        let stratum = self.cumulative.iter().position(|&c| u < c).unwrap_or(last_filled);
        let list = &self.lists[stratum];
        list[rng.random_range(0..list.len())]
    }
}

/// The places at which a node is shown: its own, and one period away from every seam it is close to.
fn wraps(grid: &ResidualGrid, recipe: &Recipe, state: &[f64; 4]) -> impl Iterator<Item = u8> {
    let near_end = |k: usize, upper: bool| {
        let axis = &grid.axes()[k];
        let distance = if upper { axis.max - state[k] } else { state[k] - axis.min };
        axis.periodic && distance <= recipe.seam_overlap
    };
    let places: Vec<u8> = core::iter::once(0)
        .chain((0..4).filter(|&k| near_end(k, true)).map(|k| 1 << (2 * k)))
        .chain((0..4).filter(|&k| near_end(k, false)).map(|k| 2 << (2 * k)))
        .collect();
    places.into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::panel::{LANES, at};
    use reachability::{Axis, Grid};

    fn grid() -> ResidualGrid {
        let square = Axis::bounded(-3.0, 3.0, 16);
        let axes = [square, square, Axis::periodic(-3.0, 3.0, 12), Axis::bounded(0.0, 1.5, 4)];
        let grid = Grid::new(axes).unwrap();
        let states = (0..grid.node_count()).map(|node| grid.state(node));
        let value: Vec<f32> = states.map(|z| (failure_function(&z, 0.7) - 0.5) as f32).collect();
        ResidualGrid::new(grid, &value, 0.7).unwrap()
    }

    #[test]
    fn is_the_same_for_any_number_of_threads_and_differs_by_seed() {
        let recipe = Recipe { pool_samples: 1 << 16, ..Recipe::default() };
        let bits = |threads, seed| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let samples = pool.install(|| Pool::draw(&grid(), &recipe, 0.0, seed)).samples;
            samples.iter().flat_map(|l| l.0.map(f32::to_bits)).collect::<Vec<_>>()
        };
        let first = bits(1, 5);
        assert_eq!(first, bits(4, 5));
        assert_ne!(first, bits(1, 6));
        let block = SAMPLE_BLOCK * LANES;
        assert_ne!(first[..block], first[block..2 * block], "every block draws samples of its own");
    }

    #[test]
    fn targets_carry_the_margin_and_states_reach_beyond_the_seam_only() {
        let recipe = Recipe { pool_samples: 8192, seam_overlap: 0.6, ..Recipe::default() };
        let pool = Pool::draw(&grid(), &recipe, 0.05, 3);
        assert!((pool.mean_target_m() - 0.55).abs() < 1e-5);
        let (mut beyond, mut total) = (0, 0);
        for block in 0..pool.blocks() {
            for panel in pool.block(block).chunks_exact(groups(SAMPLE_ROWS)) {
                for i in 0..PANEL {
                    assert!((at(panel, TARGET_ROW, i) - 0.55).abs() < 1e-5);
                    assert!(at(panel, 0, i).abs() <= 3.0 && at(panel, 1, i).abs() <= 3.0);
                    assert!((0.0..=1.5).contains(&at(panel, 3, i)));
                    let angle = at(panel, 2, i).abs();
                    assert!(angle <= 3.0 + 0.6 + 0.25 + 1e-5, "{angle}");
                    beyond += usize::from(angle > 3.0);
                    total += 1;
                }
            }
        }
        // Three of 15 places lie at or beyond an end: -3 itself is shown at +3, 2.5 at -3.5, -2.5 at 3.5.
        assert!(beyond * 20 > total && beyond * 4 < total, "{beyond} of {total}");
    }
}
