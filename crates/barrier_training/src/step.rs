//! One optimiser step over a batch: all blocks in parallel, their gradients summed in block order.
//!
//! The order of every sum is fixed by the batch alone, so neither the number of threads nor their timing changes a
//! bit of the result.

use crate::block::{BlockGradient, Loss};
use crate::condition_block::{BlockCondition, CONDITION_BLOCK, ConditionLoss};
use crate::network::Shape;
use crate::packed::Packed;
use crate::panel::BLOCK;
use crate::pass::{Share, Workspace};
use crate::pool::Pool;
use pulp::Arch;
use rayon::prelude::*;
use settings::Encoding;
use std::sync::{Mutex, PoisonError};

/// Everything a step needs beside the samples. Allocated once.
pub(crate) struct Stepper {
    arch: Arch,
    encoding: Encoding,
    packed: Packed,
    /// One per thread of the pool, so never contended.
    workspaces: Vec<Mutex<Workspace>>,
    shares: Vec<Share>,
    gradient: Vec<f32>,
}

/// What a step is taken on.
pub(crate) struct Batch<'a> {
    /// Samples of the value.
    pub(crate) pool: &'a Pool,
    /// Blocks of `pool`.
    pub(crate) blocks: &'a [u32],
    /// δ of the value's loss, m.
    pub(crate) huber_m: f32,
    /// States of the condition, whole blocks, and its loss.
    pub(crate) condition: Option<(&'a [[f32; 4]], ConditionLoss<'a>)>,
}

impl Stepper {
    /// Room for batches of up to `blocks` blocks of either kind together.
    pub(crate) fn new(encoding: Encoding, blocks: usize) -> Self {
        let shape = Shape::of(encoding);
        let threads = rayon::current_num_threads();
        Self {
            arch: Arch::new(),
            encoding,
            packed: Packed::new(shape),
            workspaces: (0..threads).map(|_| Mutex::new(Workspace::new())).collect(),
            shares: vec![Share::new(shape.parameters()); blocks],
            gradient: vec![0.0; shape.parameters()],
        }
    }

    /// Mean loss of the batch's values and the gradient of the whole loss at `parameters`.
    pub(crate) fn gradient(&mut self, batch: &Batch<'_>, parameters: &[f32]) -> (f64, &[f32]) {
        self.packed.fill(parameters);
        let Self { arch, encoding, packed, workspaces, shares, gradient } = self;
        let values = batch.blocks.len();
        let states = batch.condition.as_ref().map_or(&[][..], |(states, _)| states);
        let shares = &mut shares[..values + states.len() / CONDITION_BLOCK];
        let loss = Loss { huber_m: batch.huber_m, scale: 1.0 / (values * BLOCK) as f32 };
        shares.par_iter_mut().enumerate().for_each(|(task, share)| {
            let thread = rayon::current_thread_index().unwrap_or(0);
            let mut workspace = workspaces[thread].lock().unwrap_or_else(PoisonError::into_inner);
            let workspace = &mut workspace;
            if let Some(&block) = batch.blocks.get(task) {
                let samples = batch.pool.block(block as usize);
                arch.dispatch(BlockGradient { packed, samples, loss, workspace, share });
            } else if let Some((states, loss)) = &batch.condition {
                let states = &states[(task - values) * CONDITION_BLOCK..][..CONDITION_BLOCK];
                let (encoding, loss) = (*encoding, *loss);
                arch.dispatch(BlockCondition { packed, encoding, states, loss, workspace, share });
            }
        });
        gradient.fill(0.0);
        for share in shares.iter() {
            for (total, part) in gradient.iter_mut().zip(&share.gradient) {
                *total += part;
            }
        }
        (shares[..values].iter().map(|share| share.loss).sum(), gradient)
    }
}
