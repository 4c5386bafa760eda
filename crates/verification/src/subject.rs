//! What is judged: a model on the kernel that runs on board, its true game, and states of its box.
//!
//! Not here: the judgements.

use std::ops::ControlFlow;

use barrier::{Kernel, Model, RelativeBarrier, RelativeObstacle, RelativeSample};
use rand::RngExt;
use rand_pcg::Pcg64;
use rayon::prelude::*;

use crate::error::VerificationError;
use crate::game::Game;

/// Where a verification stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// What is being done.
    pub phase: Phase,
    /// How much of it is done.
    pub done: usize,
    /// How much there is: states, or rollouts.
    pub total: usize,
}

/// The parts of a verification that take time. The number of each seeds its random stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Phase {
    /// `h ≤ ℓ` at sampled states.
    Structure,
    /// Error against the truth.
    ValueError,
    /// Share of the unsafe shell called safe.
    Shell,
    /// CBF condition at sampled states.
    Condition,
    /// Search for its worst state.
    WorstCondition,
    /// Closed-loop rollouts.
    Rollouts,
}

/// Called between rounds of work; `Break` ends the verification with [`VerificationError::Stopped`].
pub type OnProgress<'a> = &'a mut dyn FnMut(&Progress) -> ControlFlow<()>;

/// A model to be judged.
#[derive(Debug, Clone, Copy)]
pub struct Subject<'a> {
    model: &'a Model,
    kernel: Kernel,
    game: Game,
}

/// Pieces of work between two calls of the progress callback, per thread.
const ROUND: usize = 4;

impl<'a> Subject<'a> {
    /// Prepares `model` for judgement on `kernel`, which should be the one that runs on board.
    ///
    /// # Errors
    /// * [`VerificationError::Kernel`] if this processor cannot run the kernel.
    /// * [`VerificationError::Disturbance`], [`VerificationError::NothingOutside`] for a model without a game.
    pub fn new(model: &'a Model, kernel: Kernel) -> Result<Self, VerificationError> {
        RelativeBarrier::new(model, kernel)?;
        let metadata = model.metadata();
        let farthest = |axis: usize| metadata.grid.min[axis].abs().max(metadata.grid.max[axis].abs());
        let (reach_m, radius_m) = (farthest(0).hypot(farthest(1)), metadata.failure_radius_m);
        if reach_m <= radius_m {
            return Err(VerificationError::NothingOutside { reach_m, radius_m });
        }
        Ok(Self { model, kernel, game: Game::of(metadata)? })
    }

    /// Returns the model.
    pub fn model(&self) -> &'a Model {
        self.model
    }

    /// Returns the kernel.
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// Returns the game with the model's true boxes.
    pub fn game(&self) -> &Game {
        &self.game
    }

    /// Returns the failure radius, m.
    pub fn radius_m(&self) -> f64 {
        self.model.metadata().failure_radius_m
    }

    /// Returns whether `z` lies in the trained box; a periodic component always does.
    pub fn contains(&self, z: &[f64; 4]) -> bool {
        !self.model.domain().place(z).was_outside()
    }

    /// Draws a state uniformly from the trained box.
    pub(crate) fn draw(&self, rng: &mut Pcg64) -> [f64; 4] {
        let grid = &self.model.metadata().grid;
        std::array::from_fn(|axis| rng.random_range(grid.min[axis]..grid.max[axis]))
    }

    /// Draws a state uniformly from the part of the trained box outside the failure disc, `ℓ > 0`.
    pub(crate) fn draw_outside_failure(&self, rng: &mut Pcg64) -> [f64; 4] {
        loop {
            let z = self.draw(rng);
            if self.failure_m(&z) > 0.0 {
                return z;
            }
        }
    }

    /// Returns `ℓ(z)`, m.
    pub(crate) fn failure_m(&self, z: &[f64; 4]) -> f64 {
        (z[0] * z[0] + z[1] * z[1]).sqrt() - self.radius_m()
    }

    /// Runs `work` on all cores over `total` items in pieces of at most `piece`, each with its own barrier buffers and its own
    /// random stream, and returns the results in order: the same for any number of threads.
    ///
    /// `work` takes the number of items of its piece.
    pub(crate) fn in_pieces<T: Send>(
        &self,
        (phase, seed): (Phase, u64),
        (total, piece): (usize, usize),
        progress: OnProgress<'_>,
        work: impl Fn(&mut Judge, usize) -> T + Sync,
    ) -> Result<Vec<T>, VerificationError> {
        let pieces = total.div_ceil(piece);
        let round = ROUND * rayon::current_num_threads();
        let mut results = Vec::with_capacity(pieces);
        for first in (0..pieces).step_by(round) {
            let last = pieces.min(first + round);
            let found: Result<Vec<T>, VerificationError> = (first..last)
                .into_par_iter()
                .map(|index| {
                    let mut judge = Judge::new(self, stream(phase, seed, index))?;
                    Ok(work(&mut judge, piece.min(total - index * piece)))
                })
                .collect();
            results.extend(found?);
            let done = total.min(last * piece);
            if progress(&Progress { phase, done, total }).is_break() {
                return Err(VerificationError::Stopped);
            }
        }
        Ok(results)
    }
}

/// The random stream of one piece of work.
fn stream(phase: Phase, seed: u64, index: usize) -> Pcg64 {
    Pcg64::new(u128::from(seed), ((phase as u128) << 64) | index as u128)
}

/// What one piece of work has to itself.
pub(crate) struct Judge {
    barrier: RelativeBarrier,
    pub(crate) rng: Pcg64,
    radius_m: f64,
    obstacles: Vec<RelativeObstacle>,
    samples: Vec<RelativeSample>,
}

impl Judge {
    fn new(subject: &Subject<'_>, rng: Pcg64) -> Result<Self, VerificationError> {
        Ok(Self {
            barrier: RelativeBarrier::new(subject.model, subject.kernel)?,
            rng,
            radius_m: subject.radius_m(),
            obstacles: Vec::new(),
            samples: Vec::new(),
        })
    }

    /// Evaluates `h̄` and its gradient at `states`, with the model's own radius.
    pub(crate) fn evaluate(&mut self, states: &[[f64; 4]]) -> &[RelativeSample] {
        self.place(states);
        self.barrier.evaluate(&self.obstacles, &mut self.samples);
        &self.samples
    }

    /// Evaluates `h̄` alone.
    pub(crate) fn evaluate_values(&mut self, states: &[[f64; 4]]) -> &[RelativeSample] {
        self.place(states);
        self.barrier.evaluate_values(&self.obstacles, &mut self.samples);
        &self.samples
    }

    fn place(&mut self, states: &[[f64; 4]]) {
        let radius_m = self.radius_m;
        self.obstacles.clear();
        self.obstacles.extend(states.iter().map(|&z| RelativeObstacle { z, radius_m }));
        self.samples.resize(states.len(), RelativeSample::default());
    }
}
