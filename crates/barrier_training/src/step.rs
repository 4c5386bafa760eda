//! One optimiser step over a batch: all blocks in parallel, their gradients summed in block order.
//!
//! The order of every sum is fixed by the batch alone, so neither the number of threads nor their timing changes a
//! bit of the result.

use crate::block::{BlockGradient, Loss, Share, Workspace};
use crate::network::PARAMETERS;
use crate::packed::Packed;
use crate::panel::BLOCK;
use crate::pool::Pool;
use pulp::Arch;
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Everything a step needs beside the samples. Allocated once.
pub(crate) struct Stepper {
    arch: Arch,
    packed: Packed,
    /// One per thread of the pool, so never contended.
    workspaces: Vec<Mutex<Workspace>>,
    shares: Vec<Share>,
    gradient: Vec<f32>,
}

impl Stepper {
    /// Room for batches of up to `blocks` blocks.
    pub(crate) fn new(blocks: usize) -> Self {
        let threads = rayon::current_num_threads();
        Self {
            arch: Arch::new(),
            packed: Packed::new(),
            workspaces: (0..threads).map(|_| Mutex::new(Workspace::new())).collect(),
            shares: vec![Share::new(); blocks],
            gradient: vec![0.0; PARAMETERS],
        }
    }

    /// Mean loss of the batch and its gradient at `parameters`. `blocks` index into `pool`.
    pub(crate) fn gradient(
        &mut self,
        pool: &Pool,
        blocks: &[u32],
        parameters: &[f32],
        huber_m: f32,
    ) -> (f64, &[f32]) {
        self.packed.fill(parameters);
        let Self { arch, packed, workspaces, shares, gradient } = self;
        let shares = &mut shares[..blocks.len()];
        let loss = Loss { huber_m, scale: 1.0 / (blocks.len() * BLOCK) as f32 };
        shares.par_iter_mut().zip(blocks).for_each(|(share, &block)| {
            let thread = rayon::current_thread_index().unwrap_or(0);
            let mut workspace = workspaces[thread].lock().unwrap_or_else(PoisonError::into_inner);
            let samples = pool.block(block as usize);
            arch.dispatch(BlockGradient { packed, samples, loss, workspace: &mut workspace, share });
        });
        gradient.fill(0.0);
        let mut sum = 0.0;
        for share in shares.iter() {
            sum += share.loss;
            for (total, part) in gradient.iter_mut().zip(&share.gradient) {
                *total += part;
            }
        }
        (sum, gradient)
    }
}
