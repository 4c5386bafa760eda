//! The newest sightings of one obstacle, and what they tell of the noise.

/// Sightings a residual is made of.
const SPAN: usize = 4;
/// Across a longer gap people do more than a parabola can, s.
const LONGEST_GAP_S: f64 = 0.15;

/// Positions one after another, none of which perception gave an uncertainty of its own.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Recent {
    /// The newest one last, m.
    positions_m: [[f64; 2]; SPAN],
    /// From each to the next one, s.
    intervals_s: [f64; SPAN - 1],
    count: usize,
}

/// What four sightings do beyond a parabola.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Residuals {
    /// Along each axis a number that white noise gives its own standard deviation, m. None along an axis without any change:
    /// such positions are old, or rounded, rather than exact.
    pub(crate) along_m: [Option<f64>; 2],
    /// The larger magnitude of the two, m.
    pub(crate) largest_m: f64,
    /// How far off the newest sighting is for each metre of residual, if it alone is to blame.
    pub(crate) newest_m_per_m: f64,
    /// Change of the acceleration from one interval to the next that would explain the larger one, m/s².
    pub(crate) step_mps2: f64,
}

impl Recent {
    /// Nothing seen.
    pub(crate) const NOTHING: Self =
        Self { positions_m: [[0.0; 2]; SPAN], intervals_s: [0.0; SPAN - 1], count: 0 };

    /// Takes a sighting `elapsed_s` after the last one, s, > 0.
    pub(crate) fn take(&mut self, elapsed_s: f64, position_m: [f64; 2]) {
        self.positions_m.rotate_left(1);
        self.intervals_s.rotate_left(1);
        self.positions_m[SPAN - 1] = position_m;
        self.intervals_s[SPAN - 2] = elapsed_s;
        self.count = if elapsed_s <= LONGEST_GAP_S { SPAN.min(self.count + 1) } else { 1 };
    }

    /// Velocity between the two newest of four sightings, m/s.
    pub(crate) fn difference_mps(&self) -> [f64; 2] {
        let [.., before, last] = self.positions_m;
        let [.., interval_s] = self.intervals_s;
        std::array::from_fn(|k| (last[k] - before[k]) / interval_s)
    }

    /// The shortest time between two of four sightings, s.
    pub(crate) fn shortest_interval_s(&self) -> f64 {
        self.intervals_s.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// With the third divided difference Σ wᵢ zᵢ, wᵢ = 1 / ∏ⱼ (tᵢ − tⱼ), j ≠ i, the residual is e = Σ wᵢ zᵢ / ‖w‖. An
    /// acceleration that changes by a from one of equal intervals T to the next gives Σ wᵢ zᵢ = a / (6 T). `None` without
    /// four sightings.
    pub(crate) fn residuals(&self) -> Option<Residuals> {
        if self.count < SPAN {
            return None;
        }
        let [first, second, third] = self.intervals_s;
        let times_s = [0.0, first, first + second, first + second + third];
        let weights: [f64; SPAN] = std::array::from_fn(|i| {
            let others = (0..SPAN).filter(|&j| j != i);
            1.0 / others.map(|j| times_s[i] - times_s[j]).product::<f64>()
        });
        let norm = weights.iter().map(|weight| weight * weight).sum::<f64>().sqrt();
        let along_m: [Option<f64>; 2] = std::array::from_fn(|axis| {
            let along = self.positions_m.map(|position_m| position_m[axis]);
            let sum: f64 = weights.iter().zip(along).map(|(weight, at)| weight * (at - along[0])).sum();
            along.iter().any(|&at| at != along[0]).then_some(sum / norm)
        });
        let largest_m = along_m
            .iter()
            .flatten()
            .fold(0.0, |largest: f64, residual_m: &f64| largest.max(residual_m.abs()));
        let interval_s = times_s[SPAN - 1] / 3.0;
        Some(Residuals {
            along_m,
            largest_m,
            newest_m_per_m: norm / weights[SPAN - 1],
            step_mps2: 6.0 * largest_m * norm * interval_s,
        })
    }
}
