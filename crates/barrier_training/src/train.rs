//! The training run: pool, shuffled batches, Adam, and the verification of what came out.
//!
//! The result depends on the target, the settings and the recipe only: not on the number of threads, not on the
//! instruction set, not on the clock (the library has none). Arithmetic is IEEE single precision with fused
//! multiply-adds and `libm`'s portable functions.

use crate::adam::{Adam, Schedule};
use crate::error::TrainError;
use crate::network::{PARAMETERS, initial};
use crate::panel::BLOCK;
use crate::pool::Pool;
use crate::recipe::{Recipe, require};
use crate::report::{TrainedModel, TrainingReport};
use crate::residual_grid::ResidualGrid;
use crate::step::Stepper;
use crate::verify::fit_error;
use core::ops::ControlFlow;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64;
use settings::TrainingSettings;

/// Random streams that no block of the pool uses.
const WEIGHT_STREAM: u128 = 1 << 64;
const SHUFFLE_STREAM: u128 = 2 << 64;

/// Where a run stands, after each epoch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Finished epochs.
    pub epoch: u64,
    /// Epochs of the whole run.
    pub epochs: u64,
    /// Samples per epoch.
    pub samples: usize,
    /// Mean loss over the epoch, m².
    pub loss: f64,
}

/// Fits the residual network to `target` (paper, methodology: `h̄ = ℓ - r_Θ ≈ V`).
///
/// Minimises the mean over drawn states of a pseudo-Huber loss on `r_Θ - (ℓ - V + margin)` by Adam. A positive
/// `settings.margin_m` m is, for both pairs, the same as a failure radius larger by it: `V_{R+m} = V_R - m`.
/// `progress` is called after every epoch and may stop the run.
///
/// # Errors
/// [`TrainError`]: a setting out of range, a stop by `progress`, divergence.
pub fn train(
    target: &ResidualGrid,
    settings: &TrainingSettings,
    recipe: &Recipe,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<TrainedModel, TrainError> {
    validate(settings, recipe)?;
    let pool = Pool::draw(target, recipe, settings.margin_m, settings.seed);
    let mut rng = Pcg64::new(u128::from(settings.seed), WEIGHT_STREAM);
    let mut parameters = initial(&mut rng, recipe.first_layer_gain as f32, pool.mean_target_m() as f32);
    let loss_history = minimise(&mut parameters, &pool, settings, recipe, progress)?;
    let report = TrainingReport {
        epochs: settings.epochs,
        samples_per_epoch: pool.blocks() * BLOCK,
        loss_history,
        fit: fit_error(target, &parameters),
    };
    Ok(TrainedModel { parameters, report })
}

fn validate(settings: &TrainingSettings, recipe: &Recipe) -> Result<(), TrainError> {
    recipe.validate()?;
    let positive = |setting, value: f64| {
        require(value.is_finite() && value > 0.0, setting, value, "use a positive number")
    };
    positive("epochs", settings.epochs as f64)?;
    positive("learning_rate", settings.learning_rate)?;
    positive("final_learning_rate", settings.final_learning_rate)?;
    let batch = settings.batch_size;
    require(
        batch > 0 && batch.is_multiple_of(BLOCK),
        "batch_size",
        batch as f64,
        "use a positive multiple of 256",
    )?;
    let margin = settings.margin_m;
    require(margin.is_finite() && margin >= 0.0, "margin_m", margin, "use 0 or more")
}

/// Runs all epochs; returns the mean loss of each.
fn minimise(
    parameters: &mut [f32],
    pool: &Pool,
    settings: &TrainingSettings,
    recipe: &Recipe,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Vec<f64>, TrainError> {
    let batch_blocks = (settings.batch_size / BLOCK).min(pool.blocks());
    let steps = settings.epochs * pool.blocks().div_ceil(batch_blocks) as u64;
    let schedule = Schedule {
        peak: settings.learning_rate,
        last: settings.final_learning_rate,
        warm_up: (recipe.warm_up_share * steps as f64) as u64,
        steps,
    };
    let mut rng = Pcg64::new(u128::from(settings.seed), SHUFFLE_STREAM);
    let mut order: Vec<u32> = (0..pool.blocks() as u32).collect();
    let mut adam = Adam::new(PARAMETERS);
    let mut stepper = Stepper::new(batch_blocks);
    let mut history = Vec::with_capacity(settings.epochs as usize);
    let mut step = 0;
    for epoch in 1..=settings.epochs {
        order.shuffle(&mut rng);
        let mut sum = 0.0;
        for blocks in order.chunks(batch_blocks) {
            let (loss, gradient) = stepper.gradient(pool, blocks, parameters, recipe.huber_m as f32);
            adam.step(parameters, gradient, schedule.rate(step));
            sum += loss * blocks.len() as f64;
            step += 1;
        }
        let loss = sum / pool.blocks() as f64;
        if !loss.is_finite() || parameters.iter().any(|p| !p.is_finite()) {
            return Err(TrainError::Diverged { epoch });
        }
        history.push(loss);
        let samples = pool.blocks() * BLOCK;
        match progress(Progress { epoch, epochs: settings.epochs, samples, loss }) {
            ControlFlow::Continue(()) => {}
            ControlFlow::Break(()) => return Err(TrainError::Stopped { epoch }),
        }
    }
    // Too high a rate need not end in infinities: the weights of the sines grow until the fit is noise. A sound run
    // ends near its lowest loss, since the rate decays.
    let lowest = history.iter().copied().fold(f64::INFINITY, f64::min);
    match history.last() {
        Some(&last) if last > 2.0 * lowest => Err(TrainError::Diverged { epoch: settings.epochs }),
        _ => Ok(history),
    }
}
