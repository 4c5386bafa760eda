//! The residual network `r_Θ(z)`: values and input gradients of many states in one call.
//!
//! Here: the public face, the batch in memory and the choice of the kernel. Not here: the arithmetic
//! (`network_pass`) and what the residual is subtracted from (`relative_barrier`).

use crate::MAX_OBSTACLES;
use crate::kernel::{Kernel, KernelError};
use crate::lanes::{Group, LANES, PortableLanes};
use crate::network_pass::{self, PassArguments, PassBuffers, PassWeights};
use crate::weights::NetworkWeights;

/// Groups of a full batch.
const GROUPS: usize = MAX_OBSTACLES / LANES;

/// The residual network of the paper, inputs-48-48-24-24-12-12-1 with sines and a softplus output, in `f32`.
///
/// `r_Θ(z) ≥ 0` for every `z` by the softplus. The inputs follow from `z` (metres, radians, metres per second) by the
/// weights' [`crate::InputEncoding`]; gradients are with respect to `z`.
pub struct ResidualNetwork {
    weights: Box<PassWeights>,
    kernel: Kernel,
    buffers: PassBuffers,
}

/// Up to [`MAX_OBSTACLES`] states with their residuals and gradients, a structure of arrays.
#[derive(Debug, Clone)]
pub struct NetworkBatch {
    len: usize,
    states: [[Group; GROUPS]; 4],
    residuals: [Group; GROUPS],
    gradients: [[Group; GROUPS]; 4],
}

impl NetworkBatch {
    /// Returns an empty batch.
    pub fn new() -> Self {
        let zero = [Group::ZERO; GROUPS];
        Self { len: 0, states: [zero; 4], residuals: zero, gradients: [zero; 4] }
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
            self.states[component][index / LANES].0[index % LANES] = z[component];
        }
    }

    /// Returns `r_Θ` of state `index`, m, as of the last evaluation.
    pub fn residual(&self, index: usize) -> f32 {
        self.residuals[index / LANES].0[index % LANES]
    }

    /// Returns `∇r_Θ` of state `index`, m per unit of each component, as of the last evaluation with gradients.
    pub fn gradient(&self, index: usize) -> [f32; 4] {
        std::array::from_fn(|component| self.gradients[component][index / LANES].0[index % LANES])
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
        Ok(Self { weights: PassWeights::new(weights), kernel, buffers: PassBuffers::new() })
    }

    /// Returns the variant that runs.
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// Computes residual and gradient of every state in the batch: one forward and one reverse pass.
    pub fn evaluate(&mut self, batch: &mut NetworkBatch) {
        self.run(batch, true);
    }

    /// Computes the residuals alone; gradients in the batch are left as they were.
    pub fn evaluate_values(&mut self, batch: &mut NetworkBatch) {
        self.run(batch, false);
    }

    fn run(&mut self, batch: &mut NetworkBatch, with_gradient: bool) {
        let groups = batch.len.div_ceil(LANES);
        let arguments = PassArguments {
            weights: &self.weights,
            buffers: &mut self.buffers,
            states: batch.states.each_ref().map(|component| &component[..groups]),
            residuals: &mut batch.residuals[..groups],
            gradients: with_gradient
                .then(|| batch.gradients.each_mut().map(|component| &mut component[..groups])),
        };
        match self.kernel {
            Kernel::Portable => network_pass::residuals::<PortableLanes>(arguments),
            #[cfg(target_arch = "x86_64")]
            Kernel::Avx2Fma => run_avx2(arguments),
            #[cfg(not(target_arch = "x86_64"))]
            Kernel::Avx2Fma => unreachable!("`new` refuses this kernel on other processors"),
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)] // the one call into code compiled for another instruction set
fn run_avx2(arguments: PassArguments<'_>) {
    // SAFETY: `ResidualNetwork::new` refuses the kernel where the processor lacks AVX2 or FMA.
    unsafe { crate::lanes_avx2::residuals(arguments) }
}
