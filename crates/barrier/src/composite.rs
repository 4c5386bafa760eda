//! The composite barrier `h(x, t)` over all obstacles and the row it puts on the control.
//!
//! Here: eq. `eta` over eq. `h_bar`, and through the pair's Jacobians eq. `h_cn_to_h`. Not here: the
//! minimisation under that row (`qp`), conditions of single obstacles (`pairs`), and who decides what happens
//! without an answer (`cbf_filter`).

mod pairs;

use dynamics::RobotObstaclePair;

pub use pairs::{ObstacleInput, SoftminOffset};

use crate::MAX_OBSTACLES;
use crate::kernel::{Kernel, KernelError};
use crate::model::Model;
use crate::qp::HalfSpace;
use crate::relative_barrier::{RelativeObstacle, RelativeSample};
use crate::relative_barriers::RelativeBarriers;
use crate::softmin::{softmin, softmin_weights};
use pairs::InputRates;

/// One obstacle as the filter knows it, in `odom`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BarrierObstacle {
    /// State `o`, components and units as the pair in `dynamics` states.
    pub state: [f64; 4],
    /// Its time derivative `ȯ`, per second.
    pub rate: [f64; 4],
    /// Distance of the centres that counts as contact, m (see [`crate::RelativeBarrier`] on why it is free).
    pub radius_m: f64,
    /// Which of the composite's models holds for it: 0, or what [`CompositeBarrier::add_model`] returned.
    pub model: usize,
}

/// The composite barrier at one robot state and one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CompositeSample {
    /// There is no obstacle: `h = +∞` and every control is safe.
    Unconstrained,
    /// At least one obstacle bounds the control.
    Constrained(BarrierConstraint),
}

/// Value and derivatives of the composite barrier.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BarrierConstraint {
    /// `h(x, t)`, m.
    pub h: f64,
    /// `L_g h = ∇ₓh · g(x)`, m/s per unit of each control.
    pub lg_h: [f64; 2],
    /// `L_f h + ∂h/∂t`, m/s: how `h` changes at zero control.
    pub drift: f64,
    /// `∂h/∂t`, m/s: the part of `drift` that the obstacles' motion causes.
    pub dh_dt: f64,
    /// `min ℓ(z_i)`, m: the smallest signed distance now.
    pub sdf: f64,
    /// Index of the obstacle with the smallest `h̄_i`.
    pub critical: usize,
    /// How many obstacles lie outside the box the network was trained on.
    pub outside_domain: u32,
}

/// Why the composite barrier has no value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum CompositeError {
    /// More obstacles than the filter takes.
    #[error("{given} obstacles exceed the {MAX_OBSTACLES} the filter takes; pass on the nearest ones only")]
    TooManyObstacles {
        /// Obstacles given.
        given: usize,
    },
    /// An obstacle names a model that the composite does not have.
    #[error("obstacle {index} names model {model}; add that model to the composite first")]
    UnknownModel {
        /// Position in the slice.
        index: usize,
        /// The model it names.
        model: usize,
    },
    /// The robot's state holds a NaN or an infinity.
    #[error("the robot state is not finite; brake and check the odometry")]
    NonFiniteRobot,
    /// An obstacle's state, rate or radius holds a NaN or an infinity.
    #[error("obstacle {index} is not finite; brake and check the estimator")]
    NonFiniteObstacle {
        /// Position in the slice.
        index: usize,
    },
    /// The result overflowed although every input is finite.
    #[error("the barrier is not finite for finite input; brake and check units and model")]
    NonFiniteResult,
}

/// Why a composite barrier cannot be set up.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CompositeSetupError {
    /// The kernel does not run here.
    #[error(transparent)]
    Kernel(#[from] KernelError),
    /// β must be positive.
    #[error("the softmin needs beta > 0, not {beta_per_m}; the paper uses 4")]
    Beta {
        /// Value given, 1/m.
        beta_per_m: f64,
    },
}

/// The composite neural control barrier function of the paper, for up to [`MAX_OBSTACLES`] obstacles.
///
/// One model serves all of them; with [`CompositeBarrier::add_model`] each kind of obstacle has its own, under one `h`.
///
/// Holds every buffer it needs: an evaluation allocates nothing.
pub struct CompositeBarrier {
    relative: RelativeBarriers,
    /// What the obstacles of each model may do.
    input_rates: Vec<InputRates>,
    beta_per_m: f64,
    obstacles: Vec<RelativeObstacle>,
    samples: Vec<RelativeSample>,
    h_bars: Vec<f64>,
    weights: Vec<f64>,
}

impl CompositeBarrier {
    /// Sets up the composite of `model` with softmin parameter `beta_per_m` (β of eq. `eta`, 1/m).
    ///
    /// # Errors
    /// * [`CompositeSetupError::Kernel`] if this processor cannot run `kernel`.
    /// * [`CompositeSetupError::Beta`] unless β is positive and finite.
    pub fn new(model: &Model, kernel: Kernel, beta_per_m: f64) -> Result<Self, CompositeSetupError> {
        if !(beta_per_m > 0.0 && beta_per_m.is_finite()) {
            return Err(CompositeSetupError::Beta { beta_per_m });
        }
        Ok(Self {
            relative: RelativeBarriers::new(model, kernel)?,
            input_rates: vec![InputRates::of(model.metadata())],
            beta_per_m,
            obstacles: Vec::with_capacity(MAX_OBSTACLES),
            samples: Vec::with_capacity(MAX_OBSTACLES),
            h_bars: Vec::with_capacity(MAX_OBSTACLES),
            weights: Vec::with_capacity(MAX_OBSTACLES),
        })
    }

    /// Adds a model for obstacles of another kind and returns the index that [`BarrierObstacle::model`] refers to; the first
    /// model has index 0. All must be for the same robot, which the caller has checked.
    ///
    /// # Errors
    /// * [`KernelError::Unsupported`], which the first model would have met.
    pub fn add_model(&mut self, model: &Model) -> Result<usize, KernelError> {
        let index = self.relative.add(model)?;
        self.input_rates.push(InputRates::of(model.metadata()));
        Ok(index)
    }

    /// Returns the variant of the network that runs.
    pub fn kernel(&self) -> Kernel {
        self.relative.kernel()
    }

    /// Returns β, 1/m.
    pub fn beta_per_m(&self) -> f64 {
        self.beta_per_m
    }

    /// Computes `h(x, t)` and the row it puts on the control, eq. `h_cn_to_h`:
    ///
    /// ```text
    /// h       = η(h̄_1, …, h̄_M)                     w_i = ∂η/∂h̄_i
    /// ∇ₓh     = Σ w_i ∇h̄(z_i)ᵀ ∂z_i/∂x
    /// ∂h/∂t   = Σ w_i ∇h̄(z_i)ᵀ ∂z_i/∂o_i ȯ_i
    /// drift   = ∇ₓh f(x) + ∂h/∂t                    L_g h = ∇ₓh g(x)
    /// ```
    ///
    /// # Errors
    /// * [`CompositeError::TooManyObstacles`] for more than [`MAX_OBSTACLES`].
    /// * [`CompositeError::UnknownModel`] for an obstacle whose model was not added.
    /// * [`CompositeError::NonFiniteRobot`], [`CompositeError::NonFiniteObstacle`] for bad input.
    /// * [`CompositeError::NonFiniteResult`] if finite input overflowed on the way.
    pub fn evaluate<const NX: usize, P: RobotObstaclePair<NX>>(
        &mut self,
        pair: &P,
        x: &[f64; NX],
        obstacles: &[BarrierObstacle],
    ) -> Result<CompositeSample, CompositeError> {
        check(x, obstacles, self.relative.count())?;
        let frame = pair.robot_frame(x);
        self.place(pair, &frame, obstacles);
        if obstacles.is_empty() {
            return Ok(CompositeSample::Unconstrained);
        }
        self.relative.evaluate::<true>(&self.obstacles, |index| obstacles[index].model, &mut self.samples);
        self.h_bars.clear();
        self.h_bars.extend(self.samples.iter().map(|sample| sample.h_bar));
        let h = softmin_weights(&self.h_bars, self.beta_per_m, &mut self.weights);

        let mut dh_dx = [0.0; NX];
        let mut dh_dt = 0.0;
        for (index, obstacle) in obstacles.iter().enumerate() {
            let dh_dz = self.samples[index].gradient.map(|component| component * self.weights[index]);
            let z = &self.obstacles[index].z;
            let dz_dx = pair.relative_state_by_robot(&frame, z);
            let dz_do = pair.relative_state_by_obstacle(&frame, z);
            for k in 0..4 {
                for j in 0..NX {
                    dh_dx[j] += dh_dz[k] * dz_dx[k][j];
                }
                for j in 0..4 {
                    dh_dt += dh_dz[k] * dz_do[k][j] * obstacle.rate[j];
                }
            }
        }

        let (f, g) = (pair.robot_drift(x), pair.robot_control_jacobian(x));
        let lf_h: f64 = (0..NX).map(|j| dh_dx[j] * f[j]).sum();
        let lg_h = [0, 1].map(|control| (0..NX).map(|j| dh_dx[j] * g[j][control]).sum());
        let constraint = self.constraint(h, lg_h, lf_h + dh_dt, dh_dt);
        if finite(&constraint) {
            Ok(CompositeSample::Constrained(constraint))
        } else {
            Err(CompositeError::NonFiniteResult)
        }
    }

    /// Computes `h` alone, m; `+∞` without obstacles. For pictures: the rates of the obstacles are not used.
    ///
    /// # Errors
    /// As [`CompositeBarrier::evaluate`].
    pub fn h_at<const NX: usize, P: RobotObstaclePair<NX>>(
        &mut self,
        pair: &P,
        x: &[f64; NX],
        obstacles: &[BarrierObstacle],
    ) -> Result<f64, CompositeError> {
        check(x, obstacles, self.relative.count())?;
        self.place(pair, &pair.robot_frame(x), obstacles);
        self.relative.evaluate::<false>(&self.obstacles, |index| obstacles[index].model, &mut self.samples);
        self.h_bars.clear();
        self.h_bars.extend(self.samples.iter().map(|sample| sample.h_bar));
        let h = softmin(&self.h_bars, self.beta_per_m);
        if h.is_nan() { Err(CompositeError::NonFiniteResult) } else { Ok(h) }
    }

    /// Returns the relative barrier of each obstacle of the last evaluation, in the order given.
    pub fn values(&self) -> &[RelativeSample] {
        &self.samples
    }

    /// Returns the weight `w_i = ∂h/∂h̄_i` of each obstacle of the last [`CompositeBarrier::evaluate`]; they
    /// sum to one.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Fills the relative states and sizes the buffers; all capacities suffice.
    fn place<const NX: usize, P: RobotObstaclePair<NX>>(
        &mut self,
        pair: &P,
        frame: &P::Frame,
        obstacles: &[BarrierObstacle],
    ) {
        self.obstacles.clear();
        self.obstacles.extend(obstacles.iter().map(|obstacle| RelativeObstacle {
            z: pair.relative_state_in(frame, &obstacle.state),
            radius_m: obstacle.radius_m,
        }));
        self.samples.resize(obstacles.len(), RelativeSample::default());
        self.weights.resize(obstacles.len(), 0.0);
    }

    /// Collects what the samples say about the whole; there is at least one.
    fn constraint(&self, h: f64, lg_h: [f64; 2], drift: f64, dh_dt: f64) -> BarrierConstraint {
        let mut critical = 0;
        let mut sdf = f64::INFINITY;
        let mut outside_domain = 0;
        for (index, sample) in self.samples.iter().enumerate() {
            if sample.h_bar < self.samples[critical].h_bar {
                critical = index;
            }
            sdf = sdf.min(sample.sdf);
            outside_domain += u32::from(sample.outside_domain);
        }
        BarrierConstraint { h, lg_h, drift, dh_dt, sdf, critical, outside_domain }
    }
}

impl CompositeSample {
    /// Returns `h`, m; `+∞` without obstacles.
    pub fn h(&self) -> f64 {
        match self {
            Self::Unconstrained => f64::INFINITY,
            Self::Constrained(constraint) => constraint.h,
        }
    }

    /// Returns the row of the CBF-QP for the class-K function `α(h) = α·h`, α in 1/s; none without obstacles.
    pub fn row(&self, alpha_per_s: f64) -> Option<HalfSpace<2>> {
        match self {
            Self::Unconstrained => None,
            Self::Constrained(constraint) => Some(constraint.row(alpha_per_s)),
        }
    }
}

impl BarrierConstraint {
    /// Returns the half-space `L_g h·u + (L_f h + ∂h/∂t + α·h) ≥ 0` of controls (eq. `cbf_qp`), α in 1/s.
    pub fn row(&self, alpha_per_s: f64) -> HalfSpace<2> {
        HalfSpace { normal: self.lg_h, offset: self.drift + alpha_per_s * self.h }
    }
}

/// Whether neither value nor row holds a NaN or an infinity.
fn finite(constraint: &BarrierConstraint) -> bool {
    (constraint.h + constraint.drift + constraint.lg_h[0] + constraint.lg_h[1]).is_finite()
}

fn check<const NX: usize>(
    x: &[f64; NX],
    obstacles: &[BarrierObstacle],
    models: usize,
) -> Result<(), CompositeError> {
    if obstacles.len() > MAX_OBSTACLES {
        return Err(CompositeError::TooManyObstacles { given: obstacles.len() });
    }
    if !x.iter().all(|component| component.is_finite()) {
        return Err(CompositeError::NonFiniteRobot);
    }
    let finite = |obstacle: &BarrierObstacle| {
        obstacle.radius_m.is_finite() && obstacle.state.iter().chain(&obstacle.rate).all(|v| v.is_finite())
    };
    if let Some(index) = obstacles.iter().position(|obstacle| obstacle.model >= models) {
        return Err(CompositeError::UnknownModel { index, model: obstacles[index].model });
    }
    match obstacles.iter().position(|obstacle| !finite(obstacle)) {
        Some(index) => Err(CompositeError::NonFiniteObstacle { index }),
        None => Ok(()),
    }
}
