//! How far the single-precision kernel on board is from the exact arithmetic the certificate speaks of: measured.

use barrier::{Kernel, KernelError, Model, RelativeBarrier, RelativeObstacle, RelativeSample};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

use super::cell::StateBox;
use super::enclosure::{BoxCondition, CentredBox};
use crate::game::Game;

/// Largest deviations of the kernel on sampled states.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OnboardDeviation {
    /// States compared, uniform in the region.
    pub states: usize,
    /// Kernel compared.
    pub kernel: String,
    /// Largest `|Δh̄|`, m.
    pub barrier_max_m: f64,
    /// Largest `|ΔC|`, m/s.
    pub condition_max_mps: f64,
}

const STATES: usize = 4_096;
/// Nearer to the centre of the disc than this, m, the direction of `∇ℓ` is not compared.
const NEAR_M: f64 = 0.05;

/// Compares kernel and exact arithmetic at states of the region.
pub(crate) fn measure(
    model: &Model,
    condition: &BoxCondition,
    game: &Game,
    region: &StateBox,
    alpha_per_s: f64,
    kernel: Kernel,
) -> Result<OnboardDeviation, KernelError> {
    let mut rng = Pcg64::seed_from_u64(0);
    let boxes: Vec<CentredBox> = (0..STATES)
        .map(|_| CentredBox {
            // On board the state itself is rounded to single precision too.
            centre: core::array::from_fn(|i| rng.random_range(region.min[i]..=region.max[i])),
            half_width: [0.0; 4],
        })
        .filter(|of| of.centre[0].hypot(of.centre[1]) > NEAR_M)
        .collect();
    let radius_m = model.metadata().failure_radius_m;
    let obstacles: Vec<_> = boxes.iter().map(|of| RelativeObstacle { z: of.centre, radius_m }).collect();
    let mut samples = vec![RelativeSample::default(); obstacles.len()];
    RelativeBarrier::new(model, kernel)?.evaluate(&obstacles, &mut samples);
    let mut deviation = OnboardDeviation {
        states: boxes.len(),
        kernel: kernel.to_string(),
        barrier_max_m: 0.0,
        condition_max_mps: 0.0,
    };
    for ((of, sample), exact) in boxes.iter().zip(&samples).zip(condition.enclose(&boxes)) {
        let onboard = game.hamiltonian(&of.centre, &sample.gradient) + alpha_per_s * sample.h_bar;
        let barrier = (sample.h_bar - exact.barrier.centre).abs();
        deviation.barrier_max_m = deviation.barrier_max_m.max(barrier);
        let condition = (onboard - exact.condition_at_centre()).abs();
        deviation.condition_max_mps = deviation.condition_max_mps.max(condition);
    }
    Ok(deviation)
}
