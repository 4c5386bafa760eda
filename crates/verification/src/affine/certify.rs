//! The certificate from question to record.

use std::ops::ControlFlow;
use std::path::Path;

use barrier::{DynamicsKind, Kernel, Model};

use super::checkpoint;
use super::enclosure::BoxCondition;
use super::error::AffineError;
use super::form::AXES;
use super::onboard;
use super::question::{AffineSettings, Identity, check};
use super::record::AffineRecord;
use super::search::{AffineProgress, Search};
use crate::game::Game;

/// A quarter of a trained network's usual gain.
const LEAST_GAIN: f64 = 0.1;

/// Proves, refutes or leaves open that the CBF condition of `model` holds on a region up to `ε`.
///
/// The statement: for all `z` in the region with `h̄(z) ≥ 0` and `ℓ(z) > 0`,
/// `C(z) = max_u min_d ∇h̄·ζ(z, u, d) + α h̄(z) ≥ −ε`, with the model's true boxes and its own radius. `ε > 0` means that
/// on the boundary of the safe set `h̄` falls no faster than `ε`, which `ε/α` more radius covers.
///
/// All cores work; boxes are examined in an order that does not depend on their number, so a budget of boxes gives one
/// record everywhere. `on_progress` sees every few thousand boxes, holds the clock if time is the budget, and ends the
/// search by `Break`: the record then says what is known.
///
/// With `checkpoint` the search is written there now and then and at its end, and goes on from there if the file exists.
///
/// `kernel` is the one that runs on board; its deviation from exact arithmetic is measured for the record.
///
/// # Errors
/// * [`AffineError::Region`], [`AffineError::OutsideDomain`], [`AffineError::NotPositive`] for unusable settings.
/// * [`AffineError::Weights`] for a network whose sums may exceed 1e9.
/// * [`AffineError::Io`], [`AffineError::NoCheckpoint`], [`AffineError::AnotherQuestion`] for the checkpoint.
/// * [`AffineError::Kernel`], [`AffineError::Game`] where the model cannot be judged at all.
pub fn certify(
    model: &Model,
    kernel: Kernel,
    settings: &AffineSettings,
    checkpoint: Option<&Path>,
    on_progress: &mut dyn FnMut(&AffineProgress) -> ControlFlow<()>,
) -> Result<AffineRecord, AffineError> {
    let condition = BoxCondition::new(model, settings.alpha_per_s);
    check(model, settings, &condition)?;
    let game = Game::of(model.metadata()).map_err(Box::new)?;
    let deviation =
        onboard::measure(model, &condition, &game, &settings.region, settings.alpha_per_s, kernel)?;
    let identity = Identity::new(model, settings);
    let mut search = Search::new(&condition, settings, gains(model, &condition));
    if let Some(path) = checkpoint {
        checkpoint::resume(path, &identity, &mut search)?;
    }
    let mut saved = search.tally.boxes;
    search.run(&mut |search| {
        if let Some(path) = checkpoint
            && search.tally.boxes - saved >= settings.checkpoint_boxes
        {
            checkpoint::save(path, &identity, search)?;
            saved = search.tally.boxes;
        }
        Ok::<_, AffineError>(on_progress(&search.progress()))
    })?;
    if let Some(path) = checkpoint {
        checkpoint::save(path, &identity, &search)?;
    }
    Ok(AffineRecord::new(model, &search, deviation))
}

/// How strongly each axis drives what is bounded: the network's first layer, and at least the failure function and flow.
fn gains(model: &Model, condition: &BoxCondition) -> [f64; AXES] {
    let least = match model.metadata().dynamics {
        DynamicsKind::UnicyclePair | DynamicsKind::DoubleIntegratorPair => [LEAST_GAIN; AXES],
        DynamicsKind::UnicycleStaticPair => [LEAST_GAIN, LEAST_GAIN, 0.0, 0.0],
    };
    let by_network = condition.network().input_gains();
    core::array::from_fn(|i| least[i].max(by_network[i]))
}

#[cfg(test)]
#[path = "certify_tests.rs"]
mod certify_tests;
