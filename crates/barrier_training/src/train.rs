//! The training run: pool, shuffled batches, Adam, and the verification of what came out.
//!
//! The result depends on the target, the game and the settings only: not on the number of threads, not on the
//! instruction set, not on the clock (the library has none), not on how often a run was interrupted. Arithmetic is IEEE
//! single precision with fused multiply-adds and `libm`'s portable functions.

use crate::adam::{Adam, Schedule};
use crate::checkpoint::{self, State};
use crate::condition::ConditionStates;
use crate::condition_block::{CONDITION_BLOCK, ConditionLoss};
use crate::error::TrainError;
use crate::judge::{Judge, uniform_states};
use crate::network::{FittedNetwork, Shape, initial};
use crate::panel::BLOCK;
use crate::pool::Pool;
use crate::report::{TrainedNetwork, TrainingReport};
use crate::step::{Batch, Stepper};
use crate::target::Target;
use crate::verify::{barrier_condition, fit_error};
use crate::worst_case::WorstCase;
use core::ops::ControlFlow;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64;
use settings::{ConditionSettings, TrainingSettings};
use sha2::{Digest, Sha256};
use std::path::Path;

/// Random streams that no block of the pool uses.
const WEIGHT_STREAM: u128 = 1 << 64;
const SHUFFLE_STREAM: u128 = 2 << 64;
/// States at which the barrier condition of the result is counted.
const CONDITION_STATES: usize = 400_000;

/// Where a run stands, after each epoch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Finished epochs.
    pub epoch: u64,
    /// Epochs of the whole run.
    pub epochs: u64,
    /// Samples per epoch.
    pub samples: usize,
    /// Mean loss of the value over the epoch, m².
    pub loss: f64,
    /// Share of the states near the zero level that missed or barely met the barrier condition when last looked at; absent
    /// where the condition is not trained.
    pub short_share: Option<f64>,
}

/// All that a run works on.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// What is fitted.
    pub target: Target<'a>,
    /// What the result is measured against: the value of the true game, where `target` is of a harder one.
    pub judge: &'a Judge,
    /// The true game, for the barrier condition and the gain α it is reported at, 1/s.
    pub game: Option<(&'a dyn WorstCase, f64)>,
    /// How to fit.
    pub settings: &'a TrainingSettings,
    /// Written after every epoch; where it exists, the run goes on from it.
    pub checkpoint: Option<&'a Path>,
}

/// Fits the residual network to the target (paper, methodology: `h̄ = ℓ - r_Θ ≈ V`).
///
/// Minimises the mean over drawn states of a pseudo-Huber loss on `r_Θ - (ℓ - V + margin)` by Adam, and where the settings
/// say so a hinge loss on the barrier condition. A positive margin m is, for both pairs, the same as a failure radius larger
/// by it: `V_{R+m} = V_R - m`. `progress` is called after every epoch and may stop the run; with a checkpoint the next call
/// goes on from there, to the same bits as a run without a stop.
///
/// # Errors
/// [`TrainError`]: a setting out of range, a stop by `progress`, divergence, a checkpoint of another run.
pub fn train(
    job: &Job<'_>,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<TrainedNetwork, TrainError> {
    let settings = job.settings;
    settings.validate()?;
    let condition = match (settings.condition, job.game) {
        (Some(condition), Some((game, _))) => Some((condition, game)),
        (Some(_), None) => return Err(TrainError::NoGame),
        (None, _) => None,
    };
    let run_sha256 = fingerprint(job);
    let shape = Shape::of(settings.encoding);
    let resumed = match job.checkpoint {
        Some(path) => checkpoint::load(path, &run_sha256, shape.parameters())?,
        None => None,
    };
    let (pool, states) = job.target.draw(settings, condition);
    let state = resumed.unwrap_or_else(|| {
        let mut rng = Pcg64::new(u128::from(settings.seed), WEIGHT_STREAM);
        let gain = settings.first_layer_gain as f32;
        State {
            epoch: 0,
            history: Vec::with_capacity(settings.epochs as usize),
            parameters: initial(&mut rng, shape, gain, pool.mean_target_m() as f32),
            adam: Adam::new(shape.parameters()),
        }
    });
    let mut save = |state: &State| match job.checkpoint {
        Some(path) => checkpoint::save(path, &run_sha256, state),
        None => Ok(()),
    };
    let state = Run { settings, pool: &pool, states, state, radius_m: job.target.failure_radius_m() }
        .finish(&mut save, progress)?;

    let network = FittedNetwork { encoding: settings.encoding, parameters: state.parameters };
    let report = TrainingReport {
        epochs: settings.epochs,
        samples_per_epoch: pool.blocks() * BLOCK,
        loss_history: state.history,
        fit: fit_error(job.judge, &network),
        condition: job.game.map(|(game, alpha_per_s)| {
            let states = uniform_states(&job.judge.axes, CONDITION_STATES);
            barrier_condition(&states, &network, job.judge.failure_radius_m, game, alpha_per_s)
        }),
    };
    Ok(TrainedNetwork { network, report })
}

/// What tells this run from any other: settings, values, game and program version.
fn fingerprint(job: &Job<'_>) -> String {
    let mut hash = Sha256::new();
    hash.update(env!("CARGO_PKG_VERSION"));
    hash.update(format!("{:?}", job.settings));
    job.target.hash_into(&mut hash);
    if let Some((game, _)) = job.game {
        for state in uniform_states(&job.judge.axes, 64) {
            // Any gradient tells the boxes apart; those of the distance look toward and away from the obstacle.
            for flow in [game.flow(&state, &state), game.flow(&state, &state.map(|c| -c))] {
                for rate in flow {
                    hash.update(rate.to_le_bytes());
                }
            }
        }
    }
    hash.finalize().iter().fold(String::new(), |hex, byte| hex + &format!("{byte:02x}"))
}

/// A run under way.
struct Run<'a> {
    settings: &'a TrainingSettings,
    pool: &'a Pool,
    states: Option<ConditionStates<'a>>,
    state: State,
    radius_m: f64,
}

impl Run<'_> {
    /// Runs all epochs that are left.
    fn finish(
        mut self,
        save: &mut dyn FnMut(&State) -> Result<(), checkpoint::CheckpointError>,
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<State, TrainError> {
        let settings = self.settings;
        let (epochs, samples) = (settings.epochs, self.pool.blocks() * BLOCK);
        let batch_blocks = (settings.batch_size / BLOCK).min(self.pool.blocks());
        let steps_per_epoch = self.pool.blocks().div_ceil(batch_blocks) as u64;
        let steps = epochs * steps_per_epoch;
        let schedule = Schedule {
            peak: settings.learning_rate,
            last: settings.final_learning_rate,
            warm_up: (settings.warm_up_share * steps as f64) as u64,
            steps,
        };
        let condition_blocks = settings.condition.map_or(0, |c| {
            (c.samples_per_value * (batch_blocks * BLOCK / CONDITION_BLOCK) as f64).ceil() as usize
        });
        let mut stepper = Stepper::new(settings.encoding, batch_blocks + condition_blocks);
        while self.state.epoch < epochs {
            let epoch = self.state.epoch;
            let weight = settings.condition.map_or(0.0, |c| condition_weight(&c, epoch, epochs));
            let short_share = self.refresh(epoch, weight);
            let mut order: Vec<u32> = (0..self.pool.blocks() as u32).collect();
            order.shuffle(&mut Pcg64::new(u128::from(settings.seed), SHUFFLE_STREAM + u128::from(epoch)));
            let mut sum = 0.0;
            for (step, blocks) in order.chunks(batch_blocks).enumerate() {
                let condition = self.states.as_mut().filter(|_| weight > 0.0).map(|states| {
                    let loss = states.loss(weight, self.radius_m);
                    let taken = states.take(condition_blocks);
                    let scale = loss.scale / taken.len().max(1) as f32;
                    (taken, ConditionLoss { scale, ..loss })
                });
                let huber_m = settings.huber_m as f32;
                let batch = Batch { pool: self.pool, blocks, huber_m, condition };
                let (loss, gradient) = stepper.gradient(&batch, &self.state.parameters);
                let rate = schedule.rate(epoch * steps_per_epoch + step as u64);
                self.state.adam.step(&mut self.state.parameters, gradient, rate);
                sum += loss * blocks.len() as f64;
            }
            self.state.epoch += 1;
            let (epoch, loss) = (self.state.epoch, sum / self.pool.blocks() as f64);
            if !loss.is_finite() || self.state.parameters.iter().any(|p| !p.is_finite()) {
                return Err(TrainError::Diverged { epoch });
            }
            self.state.history.push(loss);
            save(&self.state)?;
            match progress(Progress { epoch, epochs, samples, loss, short_share }) {
                ControlFlow::Continue(()) => {}
                ControlFlow::Break(()) => return Err(TrainError::Stopped { epoch }),
            }
        }
        // Too high a rate need not end in infinities: the weights of the sines grow until the fit is noise. A sound run
        // ends near its lowest loss, since the rate decays. Where the condition pulls as well, the value yields to it.
        let lowest = self.state.history.iter().copied().fold(f64::INFINITY, f64::min);
        match self.state.history.last() {
            Some(&last) if last > 2.0 * lowest && settings.condition.is_none() => {
                Err(TrainError::Diverged { epoch: epochs })
            }
            _ => Ok(self.state),
        }
    }

    /// Chooses the states of the condition anew; returns the share of candidates that fell short.
    fn refresh(&mut self, epoch: u64, weight: f64) -> Option<f64> {
        let states = self.states.as_mut().filter(|_| weight > 0.0)?;
        let network =
            FittedNetwork { encoding: self.settings.encoding, parameters: self.state.parameters.clone() };
        states.refresh(epoch, &network);
        Some(states.share())
    }
}

/// Weight of the condition in `epoch`, from 0: none, then rising, then whole.
fn condition_weight(condition: &ConditionSettings, epoch: u64, epochs: u64) -> f64 {
    let start = condition.start_share * epochs as f64;
    let ramp = ((epoch as f64 + 1.0 - start) / start.max(1.0)).clamp(0.0, 1.0);
    condition.weight * ramp
}
