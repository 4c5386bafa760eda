//! Neighbours of whole planes of nodes, ghost nodes included.
//!
//! A *plane* is the block of nodes that share their indices on all but the last two axes, or on a
//! two-dimensional grid on all but the last one, so that there are planes to share out among cores. It is
//! contiguous in storage. Along an axis before the plane's the neighbours of a plane are other planes; along
//! the plane's own it is copied into a wider one with ghost nodes around it.

use crate::upwind::{CENTRE, Stencil};
use crate::{Axis, Grid};

/// Returns how many of the last axes of an `axes`-dimensional grid a plane spans.
pub(crate) const fn plane_axes(axes: usize) -> usize {
    if axes > 2 { 2 } else { 1 }
}

/// Where a plane lies and how its neighbours are found.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlaneLayout<const N: usize> {
    axes: [Axis; N],
    strides: [usize; N],
    /// Neighbours read to either side.
    radius: usize,
}

/// Buffers for the ghost nodes of one plane, reused from plane to plane.
pub(crate) struct GhostBuffers {
    planes: [Vec<f32>; 6],
    padded: Vec<f32>,
}

impl<const N: usize> PlaneLayout<N> {
    pub(crate) fn new(grid: &Grid<N>, radius: usize) -> Self {
        Self { axes: *grid.axes(), strides: grid.strides(), radius }
    }

    /// Returns the number of nodes of a plane.
    pub(crate) fn plane_len(&self) -> usize {
        self.rows() * self.axes[N - 1].count
    }

    /// Returns the number of rows, along the last axis, of a plane.
    fn rows(&self) -> usize {
        self.axes[N - plane_axes(N)..N - 1].iter().map(|axis| axis.count).product()
    }

    /// Returns the width of a row padded along the last axis.
    pub(crate) fn padded_row(&self) -> usize {
        self.axes[N - 1].count + 2 * self.radius
    }

    /// Returns how many nodes [`Self::along_last`] lets the derivatives run over.
    pub(crate) fn padded_run(&self) -> usize {
        self.rows() * self.padded_row() - 2 * self.radius
    }

    pub(crate) fn buffers(&self) -> GhostBuffers {
        let longest = (self.rows() + 2 * self.radius) * self.padded_row();
        GhostBuffers {
            planes: std::array::from_fn(|_| vec![0.0; self.plane_len()]),
            padded: vec![0.0; longest],
        }
    }

    /// Returns the neighbouring planes of `plane` along an `axis` before the plane's own.
    #[inline(always)]
    pub(crate) fn along_leading<'a>(
        &self,
        values: &'a [f32],
        plane: usize,
        axis: usize,
        ghosts: &'a mut GhostBuffers,
    ) -> Stencil<'a> {
        let len = self.plane_len();
        let Axis { count, periodic, .. } = self.axes[axis];
        let planes_apart = self.strides[axis] / len;
        let own = plane / planes_apart % count;
        let base = plane - own * planes_apart;
        let at = |index: usize| &values[(base + index * planes_apart) * len..][..len];

        let mut stencil: Stencil<'a> = [&[]; 7];
        let mut free = ghosts.planes.iter_mut();
        for k in CENTRE - self.radius..=CENTRE + self.radius {
            // Index of the neighbour, shifted by `CENTRE` to stay unsigned.
            let shifted = own + k;
            stencil[k] = if shifted >= CENTRE && shifted - CENTRE < count {
                at(shifted - CENTRE)
            } else if periodic {
                at((shifted + count - CENTRE) % count)
            } else {
                let (end, inner, steps) = if shifted < CENTRE {
                    (at(0), at(1), CENTRE - shifted)
                } else {
                    (at(count - 1), at(count - 2), shifted - CENTRE - (count - 1))
                };
                match free.next() {
                    Some(ghost) => {
                        away_from_zero(end, inner, steps, ghost);
                        ghost
                    }
                    // Six buffers serve the six neighbours a stencil has.
                    None => end,
                }
            };
        }
        stencil
    }

    /// Returns the neighbours of the plane `centre` along the last axis but one, where that is the plane's own.
    #[inline(always)]
    pub(crate) fn along_last_but_one<'a>(&self, centre: &[f32], ghosts: &'a mut GhostBuffers) -> Stencil<'a> {
        let (r, len) = (self.radius, self.plane_len());
        let row = self.axes[N - 1].count;
        let Axis { count, periodic, .. } = self.axes[N - 2];
        let (before, rest) = ghosts.padded.split_at_mut(r * row);
        let (middle, after) = rest.split_at_mut(len);
        middle.copy_from_slice(centre);
        let at = |index: usize| &centre[index * row..][..row];
        for k in 1..=r {
            let (below, above) = (&mut before[(r - k) * row..][..row], &mut after[(k - 1) * row..][..row]);
            if periodic {
                below.copy_from_slice(at(count - k));
                above.copy_from_slice(at(k - 1));
            } else {
                away_from_zero(at(0), at(1), k, below);
                away_from_zero(at(count - 1), at(count - 2), k, above);
            }
        }
        let padded = &ghosts.padded;
        let mut stencil: Stencil<'a> = [&[]; 7];
        for k in 0..=2 * r {
            stencil[CENTRE - r + k] = &padded[k * row..][..len];
        }
        stencil
    }

    /// Returns the neighbours of the plane `centre` along the last axis.
    ///
    /// The slices run through all padded rows: node `i` of row `j` is at `j · padded_row() + i`, and the
    /// places between rows hold numbers without meaning.
    #[inline(always)]
    pub(crate) fn along_last<'a>(&self, centre: &[f32], ghosts: &'a mut GhostBuffers) -> Stencil<'a> {
        let r = self.radius;
        let Axis { count, periodic, .. } = self.axes[N - 1];
        let rows = centre.chunks_exact(count).zip(ghosts.padded.chunks_exact_mut(self.padded_row()));
        for (row, padded) in rows {
            padded[r..r + count].copy_from_slice(row);
            for k in 1..=r {
                let (below, above) = (r - k, r + count - 1 + k);
                if periodic {
                    padded[below] = row[count - k];
                    padded[above] = row[k - 1];
                } else {
                    padded[below] = ghost(row[0], row[1], k);
                    padded[above] = ghost(row[count - 1], row[count - 2], k);
                }
            }
        }
        let padded = &ghosts.padded;
        let mut stencil: Stencil<'a> = [&[]; 7];
        for k in 0..=2 * r {
            stencil[CENTRE - r + k] = &padded[k..][..self.padded_run()];
        }
        stencil
    }
}

/// Writes the ghost nodes `steps` beyond `end`.
#[inline(always)]
fn away_from_zero(end: &[f32], inner: &[f32], steps: usize, out: &mut [f32]) {
    for ((out, &end), &inner) in out.iter_mut().zip(end).zip(inner) {
        *out = ghost(end, inner, steps);
    }
}

/// Returns the value `steps` beyond `end`, moved away from zero at the slope found at the end.
///
/// hj_reachability's `extrapolate_away_from_zero`: no zero crossing, hence no danger, is invented outside.
#[inline(always)]
fn ghost(end: f32, inner: f32, steps: usize) -> f32 {
    let sign = if end > 0.0 {
        1.0
    } else if end < 0.0 {
        -1.0
    } else {
        0.0
    };
    end + sign * (inner - end).abs() * steps as f32
}
