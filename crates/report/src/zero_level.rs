//! The composite's zero level h = 0 in the world frame, at the robot's heading of the moment.
//!
//! The barrier's values come from the caller; here is the grid that holds them.

use crate::level_set::level_rings;
use crate::{Moment, RunRecord};

/// Values of the composite h on a grid of robot positions; everything else of the moment is held as it was.
#[derive(Debug, Clone, PartialEq)]
pub struct BarrierGrid {
    min_m: [f64; 2],
    step_m: f64,
    side: usize,
    values_m: Vec<f64>,
}

/// Why a grid cannot be laid.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "a grid needs a finite centre, a positive half width and at least 2 points a side; got {side} points over ±{half_width_m} m"
)]
pub struct GridError {
    /// Points per side asked for.
    pub side: usize,
    /// Half width asked for, m.
    pub half_width_m: f64,
}

impl BarrierGrid {
    /// Evaluates `h_m(position)` at `side` × `side` positions around `centre_m`, ± `half_width_m` in x and y of `odom`.
    ///
    /// `h_m` takes a robot position `[x, y]` in `odom`, m, and returns h, m; `+∞` where there is no obstacle.
    ///
    /// # Errors
    /// [`GridError`] if the grid would be empty or not finite.
    pub fn around(
        centre_m: [f64; 2],
        half_width_m: f64,
        side: usize,
        mut h_m: impl FnMut([f64; 2]) -> f64,
    ) -> Result<Self, GridError> {
        if side < 2
            || !(half_width_m > 0.0 && half_width_m.is_finite())
            || !centre_m.iter().all(|x| x.is_finite())
        {
            return Err(GridError { side, half_width_m });
        }
        let min_m = centre_m.map(|centre| centre - half_width_m);
        let step_m = 2.0 * half_width_m / (side - 1) as f64;
        let at = |index: usize, axis: usize| min_m[axis] + step_m * index as f64;
        let values_m =
            (0..side * side).map(|index| h_m([at(index % side, 0), at(index / side, 1)])).collect();
        Ok(Self { min_m, step_m, side, values_m })
    }

    /// Where h < 0, as rings in `odom`, m.
    fn unsafe_regions(&self) -> Vec<Vec<[f64; 2]>> {
        let depth: Vec<f64> = self.values_m.iter().map(|h_m| -h_m).collect();
        let in_odom_m = |point: [f64; 2]| [0, 1].map(|axis| self.min_m[axis] + self.step_m * point[axis]);
        level_rings(&depth, self.side, 0.0)
            .into_iter()
            .map(|ring| ring.into_iter().map(in_odom_m).collect())
            .collect()
    }

    fn max_m(&self) -> [f64; 2] {
        self.min_m.map(|min| min + self.step_m * (self.side - 1) as f64)
    }
}

/// The set h < 0 at one time; its outline, apart from the border of the grid, is the zero level.
#[derive(Debug, Clone, PartialEq)]
pub struct ZeroLevel {
    /// The time it holds for, stack clock, ns.
    pub time_ns: u64,
    /// Lower left corner of the grid it was found on, `[x, y]` in `odom`, m.
    pub min_m: [f64; 2],
    /// Upper right corner of that grid, `[x, y]` in `odom`, m.
    pub max_m: [f64; 2],
    /// Closed rings around the set, `[x, y]` in `odom`, m; holes are rings of their own (even-odd rule).
    pub rings_m: Vec<Vec<[f64; 2]>>,
}

impl ZeroLevel {
    /// The zero level of one grid.
    pub fn of(time_ns: u64, grid: &BarrierGrid) -> Self {
        Self { time_ns, min_m: grid.min_m, max_m: grid.max_m(), rings_m: grid.unsafe_regions() }
    }

    /// The curves h = 0: the rings without the stretches that run along the border of the grid, where h < 0 goes on.
    pub fn curves_m(&self) -> Vec<Vec<[f64; 2]>> {
        let mut curves = Vec::new();
        for ring in &self.rings_m {
            let mut curve: Vec<[f64; 2]> = Vec::new();
            for pair in ring.windows(2) {
                if self.along_border(pair[0], pair[1]) {
                    curves.extend((curve.len() > 1).then(|| core::mem::take(&mut curve)));
                    curve.clear();
                } else {
                    if curve.is_empty() {
                        curve.push(pair[0]);
                    }
                    curve.push(pair[1]);
                }
            }
            curves.extend((curve.len() > 1).then_some(curve));
        }
        curves
    }

    fn along_border(&self, from: [f64; 2], to: [f64; 2]) -> bool {
        const NEAR_M: f64 = 1e-9;
        let both_at = |axis: usize, value: f64| {
            (from[axis] - value).abs() < NEAR_M && (to[axis] - value).abs() < NEAR_M
        };
        [0, 1].iter().any(|&axis| both_at(axis, self.min_m[axis]) || both_at(axis, self.max_m[axis]))
    }
}

/// Traces the zero level for every frame of the playback of [`crate::html`].
///
/// `grid_at` lays the grid of a moment with [`BarrierGrid::around`], or returns nothing where the barrier means nothing.
/// With 61 points a side over ±6 m a grid takes 3,721 evaluations; there are at most 901 frames.
pub fn trace_zero_levels(
    record: &RunRecord,
    grid_at: &mut dyn FnMut(&Moment<'_>) -> Option<BarrierGrid>,
) -> Vec<ZeroLevel> {
    let moments = record.frame_times_ns().into_iter().filter_map(|time_ns| record.moment_at(time_ns));
    moments.filter_map(|moment| grid_at(&moment).map(|grid| ZeroLevel::of(moment.time_ns, &grid))).collect()
}
