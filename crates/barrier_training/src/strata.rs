//! Samples from a grid: nodes listed by stratum, shown at their place, off it, or beyond a seam.

use crate::residual_grid::{ResidualGrid, failure_function};
use crate::sampler::{Sample, Sampler, TRIES};
use rand::RngExt;
use rand_pcg::Pcg64;
use settings::{Encoding, SampleSettings};

/// Residual beyond which a node is active, m.
const ACTIVE_M: f64 = 0.02;

/// A node, shown at its own place or one period away along some axis.
#[derive(Debug, Clone, Copy)]
struct Entry {
    node: u32,
    /// Bit 2k: one period below along axis k; bit 2k+1: one above.
    wrap: u8,
}

/// Lists of nodes and the shares they are drawn with.
pub(crate) struct Strata<'a> {
    grid: &'a ResidualGrid,
    jitter_share: f64,
    /// Near the zero level, active, inside the failure set, outside it.
    lists: [Vec<Entry>; 4],
    /// Cumulative shares, the last 1.
    cumulative: [f64; 4],
}

impl<'a> Strata<'a> {
    /// Sorts the nodes of `grid`.
    pub(crate) fn of(grid: &'a ResidualGrid, settings: &SampleSettings, encoding: Encoding) -> Self {
        // A periodic encoding has no seam to be shown beyond.
        let overlap = match encoding {
            Encoding::Raw => settings.seam_overlap,
            Encoding::HeadingCosSin | Encoding::Position => -1.0,
        };
        let [mut near, mut active, mut inside, mut outside] = [const { Vec::new() }; 4];
        for index in 0..grid.node_count() {
            let state = grid.state(index);
            let failure = failure_function(&state, grid.failure_radius_m());
            for wrap in wraps(grid, overlap, &state) {
                let entry = Entry { node: index as u32, wrap };
                if failure <= 0.0 {
                    inside.push(entry);
                    continue;
                }
                outside.push(entry);
                if grid.value_m(index).abs() < settings.near_band_m {
                    near.push(entry);
                }
                if grid.residual_m(index) > ACTIVE_M {
                    active.push(entry);
                }
            }
        }
        // A stratum without nodes (a coarse grid may have none near the zero level) yields its share to the others.
        let share = |list: &Vec<Entry>, share: f64| if list.is_empty() { 0.0 } else { share };
        let rest = 1.0 - settings.share_near - settings.share_active - settings.share_inside;
        let shares = [
            share(&near, settings.share_near),
            share(&active, settings.share_active),
            share(&inside, settings.share_inside),
            share(&outside, rest.max(1e-6)),
        ];
        let total: f64 = shares.iter().sum();
        let mut sum = 0.0;
        let cumulative = shares.map(|s| {
            sum += s / total;
            sum
        });
        Self { grid, jitter_share: settings.jitter_share, lists: [near, active, inside, outside], cumulative }
    }

    fn pick(&self, rng: &mut Pcg64) -> Entry {
        let u: f64 = rng.random();
        let last_filled = self.lists.iter().rposition(|list| !list.is_empty()).unwrap_or(0);
        let stratum = self.cumulative.iter().position(|&c| u < c).unwrap_or(last_filled);
        let list = &self.lists[stratum];
        list[rng.random_range(0..list.len())]
    }

    /// The state shown for `entry`: the node, or a point of its cell.
    fn place(&self, entry: Entry, jitter: bool, rng: &mut Pcg64) -> [f64; 4] {
        let node = self.grid.state(entry.node as usize);
        core::array::from_fn(|k| {
            let axis = &self.grid.axes()[k];
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
}

impl Sampler for Strata<'_> {
    fn failure_radius_m(&self) -> f64 {
        self.grid.failure_radius_m()
    }

    fn draw(&self, rng: &mut Pcg64) -> Sample {
        let entry = self.pick(rng);
        let jitter = rng.random_bool(self.jitter_share);
        let state = self.place(entry, jitter, rng);
        Sample { state, residual_m: self.grid.interpolate_m(&state).unwrap_or(0.0) }
    }

    fn near_zero_level(&self, band_m: [f64; 2], rng: &mut Pcg64) -> [f64; 4] {
        let list = if self.lists[0].is_empty() { &self.lists[3] } else { &self.lists[0] };
        let mut state = [0.0; 4];
        for _ in 0..TRIES {
            let entry = list[rng.random_range(0..list.len())];
            state = self.place(entry, true, rng);
            let failure = failure_function(&state, self.grid.failure_radius_m());
            let value = failure - self.grid.interpolate_m(&state).unwrap_or(0.0);
            if failure > 0.0 && band_m[0] < value && value < band_m[1] {
                break;
            }
        }
        state
    }
}

/// The places at which a node is shown: its own, and one period away from every seam closer than `overlap`.
fn wraps(grid: &ResidualGrid, overlap: f64, state: &[f64; 4]) -> impl Iterator<Item = u8> {
    let near_end = |k: usize, upper: bool| {
        let axis = &grid.axes()[k];
        let distance = if upper { axis.max - state[k] } else { state[k] - axis.min };
        axis.periodic && distance <= overlap
    };
    let places: Vec<u8> = core::iter::once(0)
        .chain((0..4).filter(|&k| near_end(k, true)).map(|k| 1 << (2 * k)))
        .chain((0..4).filter(|&k| near_end(k, false)).map(|k| 2 << (2 * k)))
        .collect();
    places.into_iter()
}
