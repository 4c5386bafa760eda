//! One piece of the region: a dyadic box, so that pieces neither overlap nor leave gaps and their shares are exact.

use std::cmp::Ordering;

use super::enclosure::CentredBox;
use super::form::AXES;
use super::rounding::ROUNDING;

/// Most halvings of one cell, all axes together. Shares are counted in units of `2⁻⁶²`.
pub(crate) const MOST_HALVINGS: u32 = 62;
/// Most halvings along one axis: an index stays below 2³¹.
const MOST_ALONG_AXIS: u8 = 31;

/// A box of relative states, units and frame as the pair in `dynamics` states.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StateBox {
    /// Lower ends.
    pub min: [f64; AXES],
    /// Upper ends; may equal the lower ones.
    pub max: [f64; AXES],
}

/// A piece of a [`StateBox`]: along axis `i` the piece `index[i]` of `2^halvings[i]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cell {
    pub(crate) halvings: [u8; AXES],
    pub(crate) index: [u32; AXES],
    /// What is known from the cells it came from: `C` is nowhere below this where `h̄ ≥ 0`.
    pub(crate) lower: f64,
}

impl Cell {
    /// The whole region.
    pub(crate) const WHOLE: Self = Self { halvings: [0; AXES], index: [0; AXES], lower: f64::NEG_INFINITY };

    /// Returns whether halvings and index can belong to a cell and the bound is a number.
    pub(crate) fn is_possible(&self) -> bool {
        let inside = |i: usize| {
            self.halvings[i] <= MOST_ALONG_AXIS && u64::from(self.index[i]) < 1 << self.halvings[i]
        };
        let total: u32 = self.halvings.iter().map(|h| u32::from(*h)).sum();
        (0..AXES).all(inside) && total <= MOST_HALVINGS && !self.lower.is_nan()
    }

    /// Returns the cell's share of the region in units of `2⁻⁶²`.
    pub(crate) fn share(&self) -> u64 {
        1 << (MOST_HALVINGS - self.halvings.iter().map(|h| u32::from(*h)).sum::<u32>())
    }

    /// Returns the cell as a box, a little larger than it is so that cells cover the region whatever the rounding.
    pub(crate) fn centred(&self, region: &StateBox) -> CentredBox {
        let mut of = CentredBox { centre: [0.0; AXES], half_width: [0.0; AXES] };
        for i in 0..AXES {
            let (min, extent) = (region.min[i], region.max[i] - region.min[i]);
            let pieces = (1_u64 << self.halvings[i]) as f64;
            of.centre[i] = min + extent * ((f64::from(self.index[i]) + 0.5) / pieces);
            let size = region.min[i].abs().max(region.max[i].abs());
            of.half_width[i] = 0.5 * extent / pieces + ROUNDING * 1e-3 * size;
        }
        of
    }

    /// Returns the two halves along `axis`, or nothing where the cell is too small to be cut.
    pub(crate) fn halves(&self, axis: usize, lower: f64) -> Option<[Self; 2]> {
        if self.halvings[axis] >= MOST_ALONG_AXIS || self.share() == 1 {
            return None;
        }
        Some([0, 1].map(|side| {
            let mut half = Self { lower, ..*self };
            half.halvings[axis] += 1;
            half.index[axis] = 2 * self.index[axis] + side;
            half
        }))
    }
}

impl Eq for Cell {}

impl Ord for Cell {
    /// The cell with the lowest bound is the greatest, so that a heap yields it first. No two cells of one search are
    /// equal, hence the order of work is always the same.
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |cell: &Self| (cell.halvings, cell.index);
        other.lower.total_cmp(&self.lower).then_with(|| key(self).cmp(&key(other)))
    }
}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REGION: StateBox = StateBox { min: [-1.5, 0.0, -3.2, 1.0], max: [1.5, 0.1, 3.2, 1.0] };

    #[test]
    fn halves_share_the_volume_and_cover_the_cell() {
        let mut cell = Cell::WHOLE;
        for step in 0..20 {
            let axis = step % 3;
            let [low, high] = cell.halves(axis, 0.0).unwrap();
            assert_eq!(low.share() + high.share(), cell.share());
            let (low, high, whole) = (low.centred(&REGION), high.centred(&REGION), cell.centred(&REGION));
            let end = |of: &CentredBox, side: f64| of.centre[axis] + side * of.half_width[axis];
            assert!(end(&low, 1.0) >= end(&high, -1.0));
            assert!((end(&low, -1.0) - end(&whole, -1.0)).abs() < 1e-12);
            cell = cell.halves(axis, 0.0).unwrap()[step % 2];
        }
    }

    #[test]
    fn a_cell_cut_62_times_is_cut_no_more() {
        let mut cell = Cell::WHOLE;
        for step in 0..62 {
            cell = cell.halves(step % 4, 0.0).unwrap()[1];
        }
        assert_eq!(cell.share(), 1);
        assert_eq!(cell.halves(0, 0.0), None);
    }

    #[test]
    fn the_lowest_bound_comes_first() {
        let [a, b] = Cell::WHOLE.halves(0, -1.0).unwrap();
        let worse = Cell { lower: -2.0, ..b };
        assert!(worse > a && Cell { lower: f64::NEG_INFINITY, ..a } > worse);
    }
}
