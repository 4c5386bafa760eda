//! The barrier of one obstacle in relative coordinates, for many obstacles at once (eq. `h_bar`).
//!
//! Here: `h̄_Θ(z) = ℓ(z) − r_Θ(z)`, its gradient, and what holds outside the trained domain. Not here: how
//! `z` follows from robot and obstacle, and how obstacles are combined (`composite`).

use crate::MAX_OBSTACLES;
use crate::domain::{PlacedState, TrainedDomain};
use crate::failure::FailureFunction;
use crate::kernel::{Kernel, KernelError};
use crate::model::Model;
use crate::network::{NetworkBatch, ResidualNetwork};

/// The relative barrier `h̄_Θ` of a model.
///
/// # Radius
/// With `ℓ = |p| − R` the value function of another radius is exactly `V_{R'} = V_R − (R' − R)`, because
/// `V` is the best worst-case minimum over time of `|p| − R`, and a constant comes out of it. The residual
/// `r = ℓ − V` therefore does not depend on the radius, and each obstacle brings its own `radius_m` (robot
/// plus person plus buffer plus growth by age) without another model.
///
/// # Outside the trained domain
/// The residual is taken at the nearest state inside, the failure function at the true state:
/// `h̄(z) = |p| − R − r_Θ(nearest(z))`. So `h̄` stays continuous, `h̄ ≤ ℓ` holds everywhere, and an obstacle
/// farther away than the box counts with the distance gained. A speed above the trained limit counts with
/// the trained limit, which over-states safety; [`RelativeSample::outside_domain`] says so for either case,
/// and what the value function promises does not extend to such states. Components that were moved carry no
/// gradient of the residual.
///
/// # Static obstacles
/// A model of [`crate::DynamicsKind::UnicycleStaticPair`] looks at the position alone, whatever the other components say.
pub struct RelativeBarrier {
    network: ResidualNetwork,
    domain: TrainedDomain,
    batch: NetworkBatch,
    placed: Box<[PlacedState; MAX_OBSTACLES]>,
}

/// One obstacle seen from the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelativeObstacle {
    /// Relative state, units and frame as the pair in `dynamics` states.
    pub z: [f64; 4],
    /// Distance of the centres that counts as contact, m: robot plus obstacle plus whatever is added.
    pub radius_m: f64,
}

/// The relative barrier at one state.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RelativeSample {
    /// `h̄_Θ(z)`, m.
    pub h_bar: f64,
    /// `∇h̄_Θ(z)`, m per unit of each component; zero after an evaluation of values alone.
    pub gradient: [f64; 4],
    /// `ℓ(z)`, m: the signed distance that is left now.
    pub sdf: f64,
    /// Whether `z` lies outside the box the network was trained on.
    pub outside_domain: bool,
}

impl RelativeBarrier {
    /// Prepares the barrier of `model` on `kernel`.
    ///
    /// # Errors
    /// * [`KernelError::Unsupported`] if this processor cannot run the kernel.
    pub fn new(model: &Model, kernel: Kernel) -> Result<Self, KernelError> {
        let domain = *model.domain();
        Ok(Self {
            network: ResidualNetwork::new(model.weights(), kernel)?,
            domain,
            batch: NetworkBatch::new(),
            placed: Box::new([domain.place(&[0.0; 4]); MAX_OBSTACLES]),
        })
    }

    /// Returns the variant of the network that runs.
    pub fn kernel(&self) -> Kernel {
        self.network.kernel()
    }

    /// Computes values and gradients, `samples[i]` for `obstacles[i]`, any number of them.
    ///
    /// A state that is not finite gives a sample that is not finite.
    ///
    /// # Panics
    /// If `samples` is shorter than `obstacles`.
    pub fn evaluate(&mut self, obstacles: &[RelativeObstacle], samples: &mut [RelativeSample]) {
        self.run::<true>(obstacles, samples);
    }

    /// As [`RelativeBarrier::evaluate`] without gradients, in less than half the time.
    ///
    /// # Panics
    /// If `samples` is shorter than `obstacles`.
    pub fn evaluate_values(&mut self, obstacles: &[RelativeObstacle], samples: &mut [RelativeSample]) {
        self.run::<false>(obstacles, samples);
    }

    fn run<const GRADIENT: bool>(&mut self, obstacles: &[RelativeObstacle], samples: &mut [RelativeSample]) {
        let samples = &mut samples[..obstacles.len()];
        for (obstacles, samples) in obstacles.chunks(MAX_OBSTACLES).zip(samples.chunks_mut(MAX_OBSTACLES)) {
            self.batch.set_len(obstacles.len());
            for (index, obstacle) in obstacles.iter().enumerate() {
                let placed = self.domain.place(&obstacle.z);
                self.batch.set_state(index, &placed.z.map(|component| component as f32));
                self.placed[index] = placed;
            }
            if GRADIENT {
                self.network.evaluate(&mut self.batch);
            } else {
                self.network.evaluate_values(&mut self.batch);
            }
            for (index, (obstacle, sample)) in obstacles.iter().zip(samples).enumerate() {
                *sample = self.sample::<GRADIENT>(index, obstacle);
            }
        }
    }

    /// Subtracts the residual of batch entry `index` from the failure function.
    fn sample<const GRADIENT: bool>(&self, index: usize, obstacle: &RelativeObstacle) -> RelativeSample {
        let failure = FailureFunction { radius_m: obstacle.radius_m };
        let placed = &self.placed[index];
        let sdf = failure.value(&obstacle.z);
        let mut gradient = [0.0; 4];
        if GRADIENT {
            let (by_failure, by_residual) = (failure.gradient(&obstacle.z), self.batch.gradient(index));
            for k in 0..4 {
                let moved = if placed.carries_gradient[k] { f64::from(by_residual[k]) } else { 0.0 };
                gradient[k] = by_failure[k] - moved;
            }
        }
        RelativeSample {
            h_bar: sdf - f64::from(self.batch.residual(index)),
            gradient,
            sdf,
            outside_domain: placed.was_outside(),
        }
    }
}
