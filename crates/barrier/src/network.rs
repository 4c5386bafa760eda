//! The residual network `r_Θ(z)`: values and input gradients of many states in one call.
//!
//! Here: the public face, the batch in memory and the choice of the kernel. Not here: the arithmetic
//! (`network_pass`) and what the residual is subtracted from (`relative_barrier`).

use std::ops::Range;

use crate::MAX_OBSTACLES;
use crate::kernel::{Kernel, KernelError};
use crate::lanes::{Group, Group8, PortableLanes};
#[cfg(target_arch = "x86_64")]
use crate::lanes_avx512::Group16;
use crate::network_pass::{self, PassArguments, PassBuffers, PassWeights};
use crate::weights::NetworkWeights;

/// The residual network of the paper, inputs-48-48-24-24-12-12-1 with sines and a softplus output, in `f32`.
///
/// `r_Θ(z) ≥ 0` for every `z` by the softplus. The inputs follow from `z` (metres, radians, metres per second) by the
/// weights' [`crate::InputEncoding`]; gradients are with respect to `z`.
pub struct ResidualNetwork {
    weights: Box<PassWeights>,
    engine: Engine,
}

/// A kernel with the buffers it needs.
enum Engine {
    Portable(PassBuffers<Group8>),
    #[cfg(target_arch = "x86_64")]
    Avx2Fma(PassBuffers<Group8>),
    #[cfg(target_arch = "x86_64")]
    Avx512 {
        wide: PassBuffers<Group16>,
        narrow: PassBuffers<Group8>,
    },
}

/// One number per state, aligned for the widest load.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
struct Row([f32; MAX_OBSTACLES]);

/// Up to [`MAX_OBSTACLES`] states with their residuals and gradients, a structure of arrays.
#[derive(Debug, Clone)]
pub struct NetworkBatch {
    len: usize,
    states: [Row; 4],
    residuals: Row,
    gradients: [Row; 4],
}

impl NetworkBatch {
    /// Returns an empty batch.
    pub fn new() -> Self {
        let zeros = || std::array::from_fn(|_| Row([0.0; MAX_OBSTACLES]));
        Self { len: 0, states: zeros(), residuals: Row([0.0; MAX_OBSTACLES]), gradients: zeros() }
    }

    /// Sets how many states the batch holds.
    ///
    /// # Panics
    /// If `len` exceeds [`MAX_OBSTACLES`].
    pub fn set_len(&mut self, len: usize) {
        assert!(len <= MAX_OBSTACLES, "a batch holds at most {MAX_OBSTACLES} states, not {len}");
        self.len = len;
    }

    /// Writes state `index`.
    pub fn set_state(&mut self, index: usize, z: &[f32; 4]) {
        for component in 0..4 {
            self.states[component].0[index] = z[component];
        }
    }

    /// Returns `r_Θ` of state `index`, m, as of the last evaluation.
    pub fn residual(&self, index: usize) -> f32 {
        self.residuals.0[index]
    }

    /// Returns `∇r_Θ` of state `index`, m per unit of each component, as of the last evaluation with gradients.
    pub fn gradient(&self, index: usize) -> [f32; 4] {
        std::array::from_fn(|component| self.gradients[component].0[index])
    }
}

impl Default for NetworkBatch {
    fn default() -> Self {
        Self::new()
    }
}

impl ResidualNetwork {
    /// Lays the parameters out for `kernel`.
    ///
    /// # Errors
    /// * [`KernelError::Unsupported`] if this processor cannot run it.
    pub fn new(weights: &NetworkWeights, kernel: Kernel) -> Result<Self, KernelError> {
        if !kernel.is_supported() {
            return Err(KernelError::Unsupported { kernel });
        }
        let engine = match kernel {
            Kernel::Portable => Engine::Portable(PassBuffers::new()),
            #[cfg(target_arch = "x86_64")]
            Kernel::Avx2Fma => Engine::Avx2Fma(PassBuffers::new()),
            #[cfg(target_arch = "x86_64")]
            Kernel::Avx512 => Engine::Avx512 { wide: PassBuffers::new(), narrow: PassBuffers::new() },
            #[cfg(not(target_arch = "x86_64"))]
            Kernel::Avx2Fma | Kernel::Avx512 => return Err(KernelError::Unsupported { kernel }),
        };
        Ok(Self { weights: PassWeights::new(weights), engine })
    }

    /// Returns the variant that runs.
    pub fn kernel(&self) -> Kernel {
        match self.engine {
            Engine::Portable(_) => Kernel::Portable,
            #[cfg(target_arch = "x86_64")]
            Engine::Avx2Fma(_) => Kernel::Avx2Fma,
            #[cfg(target_arch = "x86_64")]
            Engine::Avx512 { .. } => Kernel::Avx512,
        }
    }

    /// Computes residual and gradient of every state in the batch: one forward and one reverse pass.
    pub fn evaluate(&mut self, batch: &mut NetworkBatch) {
        self.run(batch, true);
    }

    /// Computes the residuals alone; gradients in the batch are left as they were.
    pub fn evaluate_values(&mut self, batch: &mut NetworkBatch) {
        self.run(batch, false);
    }

    #[allow(unsafe_code)] // the calls into code compiled for another instruction set
    fn run(&mut self, batch: &mut NetworkBatch, with_gradient: bool) {
        let weights = &self.weights;
        let lanes = batch.len.next_multiple_of(Group8::LANES);
        match &mut self.engine {
            Engine::Portable(buffers) => {
                let arguments = arguments(weights, buffers, batch, 0..lanes, with_gradient);
                network_pass::residuals::<PortableLanes>(arguments);
            }
            #[cfg(target_arch = "x86_64")]
            Engine::Avx2Fma(buffers) => {
                let arguments = arguments(weights, buffers, batch, 0..lanes, with_gradient);
                // SAFETY: `ResidualNetwork::new` refuses the kernel where the processor lacks AVX2 or FMA.
                unsafe { crate::lanes_avx2::residuals(arguments) }
            }
            #[cfg(target_arch = "x86_64")]
            Engine::Avx512 { wide, narrow } => {
                // Eight lanes or fewer cost less on the narrow form, whose bits are the same.
                let split = lanes - lanes % Group16::LANES;
                let arguments_wide = arguments(weights, wide, batch, 0..split, with_gradient);
                // SAFETY: `ResidualNetwork::new` refuses the kernel where the processor lacks AVX-512F.
                unsafe { crate::lanes_avx512::residuals(arguments_wide) }
                let arguments_narrow = arguments(weights, narrow, batch, split..lanes, with_gradient);
                // SAFETY: a processor with AVX-512F has AVX2 and FMA, and `Kernel::is_supported` asks for all three.
                unsafe { crate::lanes_avx2::residuals(arguments_narrow) }
            }
        }
    }
}

/// The states `lanes` of the batch, whole groups; those behind the last state are computed along.
fn arguments<'a, M: Group>(
    weights: &'a PassWeights,
    buffers: &'a mut PassBuffers<M>,
    batch: &'a mut NetworkBatch,
    lanes: Range<usize>,
    with_gradient: bool,
) -> PassArguments<'a, M> {
    PassArguments {
        weights,
        buffers,
        states: batch.states.each_ref().map(|row| &row.0[lanes.clone()]),
        residuals: &mut batch.residuals.0[lanes.clone()],
        gradients: with_gradient.then(|| batch.gradients.each_mut().map(|row| &mut row.0[lanes.clone()])),
    }
}
