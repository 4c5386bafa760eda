//! Memory layout of a batch: panels of [`PANEL`] samples, one row of lanes per neuron.
//!
//! A panel is small enough for the first-level cache, and a row is whole vectors on every instruction set, so no
//! kernel has a remainder loop. Sums over samples run over [`LANES`] partial sums whose order never depends on the
//! vector width.

use bytemuck::{Pod, Zeroable};

/// Partial sums of every reduction over samples.
pub(crate) const LANES: usize = 16;
/// Samples in a panel.
pub(crate) const PANEL: usize = 2 * LANES;
/// Panels in a block: what one task works on between two reductions.
pub(crate) const BLOCK_PANELS: usize = 8;
/// Samples in a block.
pub(crate) const BLOCK: usize = PANEL * BLOCK_PANELS;

/// Sixteen aligned values: one vector of AVX-512, two of AVX2.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct Lanes(pub(crate) [f32; LANES]);

impl Lanes {
    /// All zero.
    pub(crate) const ZERO: Self = Self([0.0; LANES]);

    /// Sum of the lanes, by halves.
    #[inline]
    pub(crate) fn sum(&self) -> f32 {
        let mut a = self.0;
        let mut width = LANES / 2;
        while width > 0 {
            for i in 0..width {
                a[i] += a[i + width];
            }
            width /= 2;
        }
        a[0]
    }
}

/// Lane groups that `rows` rows of one panel occupy.
pub(crate) const fn groups(rows: usize) -> usize {
    rows * (PANEL / LANES)
}

/// Value of sample `sample` in row `row` of a panel.
pub(crate) fn at(panel: &[Lanes], row: usize, sample: usize) -> f32 {
    panel[groups(row) + sample / LANES].0[sample % LANES]
}

/// Mutable access to the same.
pub(crate) fn at_mut(panel: &mut [Lanes], row: usize, sample: usize) -> &mut f32 {
    &mut panel[groups(row) + sample / LANES].0[sample % LANES]
}
