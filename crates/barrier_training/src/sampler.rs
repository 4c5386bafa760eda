//! Where samples come from: states and the residuals to be fitted there, drawn by stratum.

use rand_pcg::Pcg64;

/// A state and its target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sample {
    /// Relative state.
    pub(crate) state: [f64; 4],
    /// Residual `ℓ - V` there, m.
    pub(crate) residual_m: f64,
}

/// Draws samples. The same generator gives the same samples.
pub(crate) trait Sampler: Sync {
    /// `R` of the failure function, m.
    fn failure_radius_m(&self) -> f64;

    /// A sample of the mixture that the settings describe.
    fn draw(&self, rng: &mut Pcg64) -> Sample;

    /// A state outside the failure set with `band_m[0] < V < band_m[1]`, m, on no node in particular. Where the domain has
    /// too few of them, one from elsewhere.
    fn near_zero_level(&self, band_m: [f64; 2], rng: &mut Pcg64) -> [f64; 4];
}

/// How often a rejected draw is repeated before another stratum serves.
pub(crate) const TRIES: usize = 1000;
