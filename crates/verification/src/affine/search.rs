//! Branch and bound over the region: which cells are settled, which are cut, and in what order.
//!
//! The cell with the lowest bound comes first, so the search may end at any time with the best statement it can make.
//! Beyond [`MOST_WAITING`] cells it goes depth first until the list has shrunk, so memory stays bounded.

use std::collections::BinaryHeap;
use std::ops::ControlFlow;

use rayon::prelude::*;

use super::cell::{Cell, MOST_HALVINGS};
use super::enclosure::{BoxCondition, Enclosure};
use super::form::AXES;
use super::quadratic::Quadratic;
use super::question::AffineSettings;

/// Cells examined between two looks at what was found.
const WAVE: usize = 8_192;
/// Cells of one task.
const TASK: usize = 128;
/// Waiting cells beyond which the search goes depth first, 32 bytes each.
const MOST_WAITING: usize = 4_000_000;
/// `h̄` from which on a state counts as inside the set in spite of rounding, m.
const SURELY_INSIDE_M: f64 = 1e-9;

/// A state at which the condition was evaluated.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Witness {
    /// Relative state.
    pub z: [f64; AXES],
    /// `h̄` there, m.
    pub barrier_m: f64,
    /// `C` there, m/s.
    pub condition_mps: f64,
}

/// What the settled cells add up to; shares in units of `2⁻⁶²` of the region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tally {
    pub(crate) boxes: u64,
    /// Cells without a state of the set: failure, or `h̄ < 0`.
    pub(crate) outside: u64,
    /// Cells where `C ≥ −ε` is proven.
    pub(crate) proven: u64,
    /// Cells put aside with a bound below `−ε`: after a counterexample, or too small to be cut.
    pub(crate) aside: u64,
    /// Lowest bound among the latter.
    pub(crate) aside_lower: f64,
    /// Lowest `C` met at a centre where `h̄ ≥ 0 < ℓ`.
    pub(crate) worst: Option<Witness>,
}

/// A search under way.
pub(crate) struct Search<'a> {
    pub(crate) condition: &'a BoxCondition,
    pub(crate) settings: &'a AffineSettings,
    pub(crate) waiting: BinaryHeap<Cell>,
    /// Cells of a depth-first stretch, last in first out.
    pub(crate) stack: Vec<Cell>,
    pub(crate) tally: Tally,
    /// Waiting cells beyond which the search goes depth first.
    most_waiting: usize,
    /// How strongly each axis drives the network, 1 per unit.
    gains: [f64; AXES],
}

/// Where a search stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AffineProgress {
    /// Boxes examined so far, earlier runs included.
    pub boxes: u64,
    /// Share of the region that is settled, 0 to 1.
    pub settled_share: f64,
    /// Share of the region proven for the `ε` asked for, or without a state of the safe set, 0 to 1.
    pub proven_share: f64,
    /// Cells waiting.
    pub open_boxes: usize,
    /// `ε` that would hold if the search ended now, m/s; infinite before the first bound.
    pub provable_epsilon_mps: f64,
    /// Lowest `C` met so far.
    pub worst: Option<Witness>,
}

impl<'a> Search<'a> {
    /// Starts with the whole region waiting.
    pub(crate) fn new(condition: &'a BoxCondition, settings: &'a AffineSettings, gains: [f64; AXES]) -> Self {
        let tally =
            Tally { boxes: 0, outside: 0, proven: 0, aside: 0, aside_lower: f64::INFINITY, worst: None };
        let waiting = BinaryHeap::from([Cell::WHOLE]);
        Self { condition, settings, waiting, stack: Vec::new(), tally, most_waiting: MOST_WAITING, gains }
    }

    /// Works until nothing is left, the budget is spent or `on_wave` breaks; `on_wave` sees every wave.
    pub(crate) fn run<E>(
        &mut self,
        on_wave: &mut dyn FnMut(&Self) -> Result<ControlFlow<()>, E>,
    ) -> Result<(), E> {
        while !(self.waiting.is_empty() && self.stack.is_empty()) {
            let left = self.settings.boxes.saturating_sub(self.tally.boxes);
            if left == 0 {
                break;
            }
            self.wave(WAVE.min(usize::try_from(left).unwrap_or(WAVE)));
            if on_wave(self)?.is_break() {
                break;
            }
        }
        Ok(())
    }

    /// Examines the next `count` cells at most.
    fn wave(&mut self, count: usize) {
        let on_stack = !self.stack.is_empty();
        let depth_first = on_stack || self.waiting.len() >= self.most_waiting;
        let mut cells = Vec::with_capacity(count);
        while cells.len() < count {
            // A stretch of depth first starts with the worst cells and then feeds on its own.
            let next = if on_stack { self.stack.pop() } else { self.waiting.pop() };
            let Some(cell) = next else { break };
            cells.push(cell);
        }
        let region = self.settings.region;
        let enclosures: Vec<Enclosure> = cells
            .par_chunks(TASK)
            .flat_map_iter(|cells| {
                let boxes: Vec<_> = cells.iter().map(|cell| cell.centred(&region)).collect();
                self.condition.enclose(&boxes)
            })
            .collect();
        for (cell, enclosure) in cells.iter().zip(&enclosures) {
            self.settle(cell, enclosure, depth_first);
        }
        self.tally.boxes += cells.len() as u64;
    }

    /// Books one cell, or cuts it.
    fn settle(&mut self, cell: &Cell, enclosure: &Enclosure, depth_first: bool) {
        if enclosure.failure_upper_m <= 0.0 || enclosure.barrier.upper_bound() < 0.0 {
            self.tally.outside += cell.share();
            return;
        }
        let centred = cell.centred(&self.settings.region);
        self.note(&centred.centre, enclosure);
        // No number proves nothing; what the larger cell proved holds for its parts.
        let (own, by) = enclosure.condition_lower();
        let lower = if own > cell.lower { own } else { cell.lower };
        if lower >= -self.settings.epsilon_mps {
            self.tally.proven += cell.share();
            return;
        }
        let axis = self.axis_to_cut(&by, &centred.half_width);
        let halves = if lower >= -self.target_mps() { None } else { cell.halves(axis, lower) };
        match halves {
            None => {
                self.tally.aside += cell.share();
                self.tally.aside_lower = self.tally.aside_lower.min(lower);
            }
            Some(halves) if depth_first => self.stack.extend(halves),
            Some(halves) => self.waiting.extend(halves),
        }
    }

    /// Returns the axis whose halving is likely to raise the bound of `by` most.
    ///
    /// Halving axis `i` halves its linear coefficient. The radius is mostly a cube of `Σ gainᵢ wᵢ`, so it shrinks in
    /// proportion to three times the axis's part in that sum.
    fn axis_to_cut(&self, by: &Quadratic, half_width: &[f64; AXES]) -> usize {
        let reach: [f64; AXES] = core::array::from_fn(|i| self.gains[i] * half_width[i]);
        let total: f64 = reach.iter().sum();
        // Where the radius is beyond all measure the linear part says nothing.
        let radius = if by.radius.is_finite() { by.radius } else { 1e9 };
        let gain = |i: &usize| 0.5 * by.linear[*i].abs() + 1.5 * radius * reach[*i] / total;
        let finite = |gain: f64| if gain.is_finite() { gain } else { 0.0 };
        let by_gain = |a: &usize, b: &usize| finite(gain(a)).total_cmp(&finite(gain(b)));
        let by_reach = |a: &usize, b: &usize| reach[*a].total_cmp(&reach[*b]);
        (0..AXES).max_by(|a, b| by_gain(a, b).then_with(|| by_reach(a, b))).unwrap_or(0)
    }

    /// Remembers the centre if it is the worst state so far.
    fn note(&mut self, z: &[f64; AXES], enclosure: &Enclosure) {
        let (barrier_m, condition_mps) = (enclosure.barrier.centre, enclosure.condition_at_centre());
        let failed = z[0].hypot(z[1]) <= self.condition.failure_radius_m();
        let inside = !failed && barrier_m >= SURELY_INSIDE_M;
        if !inside || !condition_mps.is_finite() {
            return;
        }
        if self.tally.worst.is_none_or(|worst| condition_mps < worst.condition_mps) {
            self.tally.worst = Some(Witness { z: *z, barrier_m, condition_mps });
        }
    }

    /// The `ε` still worth proving: the one asked for, or what the worst state leaves.
    fn target_mps(&self) -> f64 {
        let epsilon_mps = self.settings.epsilon_mps;
        match self.tally.worst {
            Some(worst) if worst.condition_mps < -epsilon_mps => self.settings.gap_mps - worst.condition_mps,
            Some(_) | None => epsilon_mps,
        }
    }

    /// The `ε` that holds on the whole region with what is known now.
    pub(crate) fn provable_epsilon_mps(&self) -> f64 {
        let open = self.stack.iter().map(|cell| cell.lower).fold(f64::INFINITY, f64::min);
        let waiting = self.waiting.peek().map_or(f64::INFINITY, |cell| cell.lower);
        let lower = open.min(waiting).min(self.tally.aside_lower);
        self.settings.epsilon_mps.max(-lower)
    }

    /// Returns where the search stands.
    pub(crate) fn progress(&self) -> AffineProgress {
        let settled = self.tally.outside + self.tally.proven;
        AffineProgress {
            boxes: self.tally.boxes,
            settled_share: share(settled + self.tally.aside),
            proven_share: share(settled),
            open_boxes: self.waiting.len() + self.stack.len(),
            provable_epsilon_mps: self.provable_epsilon_mps(),
            worst: self.tally.worst,
        }
    }
}

/// Turns units of `2⁻⁶²` into a share of the region.
pub(crate) fn share(units: u64) -> f64 {
    units as f64 / (1_u64 << MOST_HALVINGS) as f64
}

#[cfg(test)]
mod tests {
    use barrier::{DynamicsKind, InputEncoding};

    use super::*;
    use crate::affine::cell::StateBox;
    use crate::affine::test_models::{metadata, random_model};

    #[test]
    fn depth_first_settles_the_same_cells_with_fewer_waiting() {
        let metadata = metadata(DynamicsKind::DoubleIntegratorPair, InputEncoding::Raw, 1.0);
        let model = random_model(metadata, 3, 1.0);
        let region = StateBox { min: [0.8, -0.4, -0.5, -0.5], max: [1.6, 0.4, 0.5, 0.5] };
        // High enough to be true, so that no counterexample changes what is worth proving.
        let settings = AffineSettings::new(region, 4.0, 1.0);
        let condition = BoxCondition::new(&model, settings.alpha_per_s);
        let run = |most_waiting| {
            let mut search = Search::new(&condition, &settings, [1.0; AXES]);
            search.most_waiting = most_waiting;
            let mut most_open = 0;
            let mut on_wave = |search: &Search<'_>| {
                most_open = most_open.max(search.waiting.len());
                Ok::<_, ()>(ControlFlow::Continue(()))
            };
            search.run(&mut on_wave).unwrap();
            (search.tally, most_open)
        };
        let ((best_first, wide), (depth_first, narrow)) = (run(usize::MAX), run(4));
        assert!(best_first.worst.is_none_or(|worst| worst.condition_mps > -1.0));
        assert!(best_first.boxes > 100 && best_first.boxes == depth_first.boxes, "{}", best_first.boxes);
        assert_eq!((best_first.outside, best_first.proven), (depth_first.outside, depth_first.proven));
        assert!(narrow < wide, "{narrow} {wide}");
    }
}
