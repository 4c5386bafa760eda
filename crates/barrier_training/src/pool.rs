//! The pool of training samples: drawn once, block by block, from a seed.
//!
//! Every block has a random stream of its own: the pool does not depend on the number of threads.

use crate::block::{OVERESTIMATE_ROW, SAMPLE_BLOCK, SAMPLE_ROWS, TARGET_ROW, UNDERESTIMATE_ROW, put_inputs};
use crate::features::encode;
use crate::panel::{BLOCK, Lanes, PANEL, at_mut, groups};
use crate::residual_grid::failure_function;
use crate::sampler::Sampler;
use rand_pcg::Pcg64;
use rayon::prelude::*;
use settings::TrainingSettings;

/// Samples in panels, `SAMPLE_BLOCK` lane groups per block.
pub(crate) struct Pool {
    samples: Vec<Lanes>,
}

impl Pool {
    /// Draws `settings.samples.count` samples; the margin is added to every target residual.
    pub(crate) fn draw(sampler: &impl Sampler, settings: &TrainingSettings) -> Self {
        let blocks = settings.samples.count.div_ceil(BLOCK);
        let radius_m = sampler.failure_radius_m();
        let mut samples = vec![Lanes::ZERO; blocks * SAMPLE_BLOCK];
        samples.par_chunks_exact_mut(SAMPLE_BLOCK).enumerate().for_each(|(block, samples)| {
            let mut rng = Pcg64::new(u128::from(settings.seed), block as u128);
            for panel in samples.chunks_exact_mut(groups(SAMPLE_ROWS)) {
                for i in 0..PANEL {
                    let sample = sampler.draw(&mut rng);
                    let failure = failure_function(&sample.state, radius_m);
                    let value = failure - sample.residual_m;
                    let nearness = (1.0 - value.abs() / settings.samples.near_band_m).max(0.0);
                    let rise = (value / settings.samples.near_band_m).clamp(0.0, 1.0);
                    let under = settings.underestimate_weight;
                    put_inputs(panel, i, &encode(settings.encoding, &sample.state.map(|c| c as f32)));
                    *at_mut(panel, TARGET_ROW, i) = (sample.residual_m + settings.margin_m) as f32;
                    *at_mut(panel, OVERESTIMATE_ROW, i) =
                        (1.0 + settings.overestimate_weight * nearness) as f32;
                    *at_mut(panel, UNDERESTIMATE_ROW, i) = (under + (1.0 - under) * rise) as f32;
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

#[cfg(test)]
mod tests;
