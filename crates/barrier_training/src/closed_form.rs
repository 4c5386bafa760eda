//! The target without a grid: a value known in closed form, as that of the double-integrator pair.

use crate::residual_grid::failure_function;
use crate::sampler::{Sample, Sampler, TRIES};
use rand::RngExt;
use rand_pcg::Pcg64;
use settings::SampleSettings;

/// Residual beyond which a state is active, m.
const ACTIVE_M: f64 = 0.02;

/// A value function of the relative state, m.
pub type ValueFn = Box<dyn Fn(&[f64; 4]) -> f64 + Send + Sync>;

/// A value function in closed form over a box of relative states `[p, v]`.
///
/// Double integrators only: where inputs are accelerations, `p → λp, v → √λ·v` scales the smallest distance ever reached
/// by `λ`, whatever the input boxes. So any state can be moved to a chosen level of V without a search.
pub struct ClosedForm {
    value_m: ValueFn,
    failure_radius_m: f64,
    min: [f64; 4],
    max: [f64; 4],
}

impl ClosedForm {
    /// The target `value_m` m over the box from `min` to `max`, for the failure radius R, m.
    pub fn new(value_m: ValueFn, failure_radius_m: f64, min: [f64; 4], max: [f64; 4]) -> Self {
        Self { value_m, failure_radius_m, min, max }
    }

    /// Radius of the failure set, m.
    pub fn failure_radius_m(&self) -> f64 {
        self.failure_radius_m
    }

    /// Value at a state, m.
    pub fn value_m(&self, state: &[f64; 4]) -> f64 {
        (self.value_m)(state)
    }

    /// Uniform in the box.
    pub(crate) fn uniform(&self, rng: &mut Pcg64) -> [f64; 4] {
        core::array::from_fn(|k| rng.random_range(self.min[k]..self.max[k]))
    }

    /// The box and values at a few hundred states in it: what tells one closed form from another.
    pub(crate) fn probe(&self) -> impl Iterator<Item = f64> {
        let mut rng = Pcg64::new(1, 0);
        let states: Vec<[f64; 4]> = (0..256).map(|_| self.uniform(&mut rng)).collect();
        let values = states.into_iter().map(|state| self.value_m(&state));
        self.min.into_iter().chain(self.max).chain(values)
    }

    fn contains(&self, state: &[f64; 4]) -> bool {
        (0..4).all(|k| (self.min[k]..=self.max[k]).contains(&state[k]))
    }

    fn failure_m(&self, state: &[f64; 4]) -> f64 {
        failure_function(state, self.failure_radius_m)
    }

    fn sample(&self, state: [f64; 4]) -> Sample {
        Sample { state, residual_m: (self.failure_m(&state) - self.value_m(&state)).max(0.0) }
    }

    /// A state at a value drawn uniformly from the band, outside the failure set.
    fn at_level(&self, band_m: [f64; 2], rng: &mut Pcg64) -> Option<Sample> {
        for _ in 0..TRIES {
            let state = self.uniform(rng);
            let closest_m = self.value_m(&state) + self.failure_radius_m;
            let value_m = rng.random_range(band_m[0]..band_m[1]).max(-0.98 * self.failure_radius_m);
            let scale = (value_m + self.failure_radius_m) / closest_m.max(1e-9);
            let root = libm::sqrt(scale);
            let moved = [scale * state[0], scale * state[1], root * state[2], root * state[3]];
            let failure_m = self.failure_m(&moved);
            if self.contains(&moved) && failure_m > 0.0 {
                return Some(Sample { state: moved, residual_m: (failure_m - value_m).max(0.0) });
            }
        }
        None
    }

    /// A uniform state for which `wanted` holds.
    fn where_holds(&self, rng: &mut Pcg64, wanted: impl Fn(&Sample) -> bool) -> Option<Sample> {
        (0..TRIES).map(|_| self.sample(self.uniform(rng))).find(wanted)
    }

    /// Uniform inside the failure set.
    fn inside(&self, rng: &mut Pcg64) -> Option<Sample> {
        let r = self.failure_radius_m;
        for _ in 0..TRIES {
            let mut state = self.uniform(rng);
            (state[0], state[1]) = (rng.random_range(-r..r), rng.random_range(-r..r));
            if self.contains(&state) && self.failure_m(&state) <= 0.0 {
                return Some(self.sample(state));
            }
        }
        None
    }
}

/// [`ClosedForm`] with the shares to draw by.
pub(crate) struct ClosedFormSampler<'a> {
    pub(crate) target: &'a ClosedForm,
    pub(crate) settings: SampleSettings,
}

impl Sampler for ClosedFormSampler<'_> {
    fn failure_radius_m(&self) -> f64 {
        self.target.failure_radius_m
    }

    fn draw(&self, rng: &mut Pcg64) -> Sample {
        let (target, s) = (self.target, &self.settings);
        let u: f64 = rng.random();
        let drawn = if u < s.share_near {
            target.at_level([-s.near_band_m, s.near_band_m], rng)
        } else if u < s.share_near + s.share_active {
            target.where_holds(rng, |s| s.residual_m > ACTIVE_M && target.failure_m(&s.state) > 0.0)
        } else if u < s.share_near + s.share_active + s.share_inside {
            target.inside(rng)
        } else {
            target.where_holds(rng, |s| target.failure_m(&s.state) > 0.0)
        };
        drawn.unwrap_or_else(|| target.sample(target.uniform(rng)))
    }

    fn near_zero_level(&self, band_m: [f64; 2], rng: &mut Pcg64) -> [f64; 4] {
        let drawn = self.target.at_level(band_m, rng);
        drawn.map_or_else(|| self.target.uniform(rng), |sample| sample.state)
    }
}
