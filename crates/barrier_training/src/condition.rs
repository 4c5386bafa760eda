//! Which states the barrier condition is asked at: those near the zero level of the current network that fall short.
//!
//! Candidates near the zero level of V are drawn once; at every epoch a part of them is evaluated and the states that miss
//! the condition, or barely meet it, are kept. They are few (ridges where the best evasion changes sides), so that a step
//! spent elsewhere would be lost.

use crate::condition_block::{CONDITION_BLOCK, ConditionLoss};
use crate::network::FittedNetwork;
use crate::residual_grid::failure_function;
use crate::sampler::Sampler;
use crate::verify::{condition_at, evaluate};
use crate::worst_case::WorstCase;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64;
use rayon::prelude::*;
use settings::ConditionSettings;

/// Candidates per sample of the value, and parts they are looked at in, one an epoch.
const PER_SAMPLE: f64 = 0.5;
const PARTS: usize = 4;
/// Candidates per random stream.
const CHUNK: usize = 1 << 12;
/// Random streams that nothing else uses.
const CANDIDATE_STREAM: u128 = 3 << 64;
const ORDER_STREAM: u128 = 4 << 64;
/// Candidates are drawn this much beyond the band, m: the network's level is not that of V.
const REACH_M: f64 = 0.1;
/// A state is kept if its condition exceeds the margin by less than this, m/s.
const SPARE_MPS: f64 = 0.02;

/// The states of one run at which the condition counts.
pub(crate) struct ConditionStates<'a> {
    settings: ConditionSettings,
    game: &'a dyn WorstCase,
    failure_radius_m: f64,
    seed: u64,
    candidates: Vec<[f32; 4]>,
    kept: Vec<[f32; 4]>,
    next: usize,
}

impl<'a> ConditionStates<'a> {
    /// Draws the candidates of a run with this seed and number of samples.
    pub(crate) fn draw(
        sampler: &impl Sampler,
        settings: ConditionSettings,
        game: &'a dyn WorstCase,
        (seed, samples): (u64, usize),
    ) -> Self {
        let band_m = [settings.band_m[0] - REACH_M, settings.band_m[1] + REACH_M];
        let chunks = (PER_SAMPLE * samples as f64 / (PARTS * CHUNK) as f64).ceil() as usize;
        let mut candidates = vec![[0.0; 4]; chunks * PARTS * CHUNK];
        candidates.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, states)| {
            let mut rng = Pcg64::new(u128::from(seed), CANDIDATE_STREAM + chunk as u128);
            states.fill_with(|| sampler.near_zero_level(band_m, &mut rng).map(|c| c as f32));
        });
        let failure_radius_m = sampler.failure_radius_m();
        Self { settings, game, failure_radius_m, seed, candidates, kept: Vec::new(), next: 0 }
    }

    /// Chooses the states of `epoch` by the present network.
    pub(crate) fn refresh(&mut self, epoch: u64, network: &FittedNetwork) {
        let part = self.candidates.len() / PARTS;
        let first = (epoch % PARTS as u64) as usize * part;
        let looked_at = &self.candidates[first..first + part];
        let fitted = evaluate(network, looked_at);
        let [low, high] = self.settings.band_m;
        let short = |(state, &(residual, slope)): (&[f32; 4], &(f32, [f32; 4]))| {
            let z = state.map(f64::from);
            let h = failure_function(&z, self.failure_radius_m) - f64::from(residual);
            (low < h && h < high).then(|| {
                condition_at(
                    &z,
                    residual,
                    &slope,
                    self.failure_radius_m,
                    self.game,
                    self.settings.alpha_per_s,
                ) < self.settings.margin_mps + SPARE_MPS
            }) == Some(true)
        };
        self.kept = looked_at.iter().zip(&fitted).filter(|&pair| short(pair)).map(|(s, _)| *s).collect();
        self.kept.shuffle(&mut Pcg64::new(u128::from(self.seed), ORDER_STREAM + u128::from(epoch)));
        self.next = 0;
    }

    /// The loss per unit of mean violation, with `weight` for the settings' weight.
    pub(crate) fn loss(&self, weight: f64, failure_radius_m: f64) -> ConditionLoss<'a> {
        ConditionLoss {
            game: self.game,
            failure_radius_m,
            alpha_per_s: self.settings.alpha_per_s as f32,
            margin_mps: self.settings.margin_mps as f32,
            knee_mps: self.settings.knee_mps as f32,
            scale: weight as f32,
        }
    }

    /// Share of the states looked at that fell short.
    pub(crate) fn share(&self) -> f64 {
        self.kept.len() as f64 / (self.candidates.len() / PARTS) as f64
    }

    /// The next `blocks` blocks of states, over and over again; nothing where too few fell short.
    pub(crate) fn take(&mut self, blocks: usize) -> &[[f32; 4]] {
        let wanted = (blocks * CONDITION_BLOCK).min(self.kept.len() / CONDITION_BLOCK * CONDITION_BLOCK);
        if self.next + wanted > self.kept.len() {
            self.next = 0;
        }
        self.next += wanted;
        &self.kept[self.next - wanted..self.next]
    }
}
