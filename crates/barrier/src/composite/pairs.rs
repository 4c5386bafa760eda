//! The barrier of each obstacle for itself, as a condition on the control, and the composite made of these conditions. Beyond
//! the paper: this is where the composite's known weaknesses can be answered one by one. The published composite is
//! [`CompositeBarrier::evaluate`], which this agrees with where every choice is the published one.

use dynamics::RobotObstaclePair;

use super::{
    BarrierConstraint, BarrierObstacle, CompositeBarrier, CompositeError, CompositeSample, check, finite,
};
use crate::metadata::{DynamicsKind, ModelMetadata};
use crate::softmin::softmin_weights;

/// What is taken for the obstacle's own input, as part of `ȯ`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ObstacleInput {
    /// What [`BarrierObstacle::rate`] says.
    Measured,
    /// The input `d` within the bounds of the obstacle's model that makes `dh̄/dt` smallest. `h̄` then keeps its condition
    /// whatever an obstacle within its bounds does, and nothing of the estimate's second derivative is used. As the weights
    /// of the composite are not negative, the worst for each is the worst for all.
    WorstCase,
}

/// What becomes of the softmin's offset, `0 ≤ min h̄_i − η ≤ ln(M)/β`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SoftminOffset {
    /// It stays: `h = η`.
    Keep,
    /// What there is of it is added: `h = min h̄_i`. Its rate is taken from the softmin all the same, so the condition is
    /// `Σ w_i dh̄_i/dt + α min h̄_i ≥ −s`: smooth in direction, unpadded in value.
    Remove,
    /// Its bound is added: `h = η + ln(M)/β`. Exact where all values are equal and above the smallest value elsewhere.
    RemoveBound,
}

/// The components of `o` that an obstacle's input drives; the first two are its position.
const DRIVEN: [usize; 2] = [2, 3];

/// Bounds of what the input adds to the rates of the [`DRIVEN`] components.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct InputRates {
    min: [f64; 2],
    max: [f64; 2],
}

impl InputRates {
    /// The bounds that a model was made for. Its metadata has as many as its dynamics has inputs.
    pub(crate) fn of(metadata: &ModelMetadata) -> Self {
        let of = |ends: &[f64], index: usize| ends.get(index).copied().unwrap_or(0.0);
        let (min, max) = (&metadata.disturbance.min, &metadata.disturbance.max);
        match metadata.dynamics {
            // o = [x, y, heading, speed]: the heading turns, the speed stays.
            DynamicsKind::UnicyclePair => Self { min: [of(min, 0), 0.0], max: [of(max, 0), 0.0] },
            // o = [x, y, vx, vy]: both velocities change.
            DynamicsKind::DoubleIntegratorPair => {
                Self { min: [of(min, 0), of(min, 1)], max: [of(max, 0), of(max, 1)] }
            }
            DynamicsKind::UnicycleStaticPair => Self { min: [0.0; 2], max: [0.0; 2] },
        }
    }
}

impl CompositeBarrier {
    /// Computes for each obstacle the constraint that it alone puts on the control, in the order given, into `constraints`,
    /// whose capacity of [`crate::MAX_OBSTACLES`] suffices. Each has itself as the critical one.
    ///
    /// ```text
    /// h = h̄(z_i)    ∇ₓh = ∇h̄(z_i)ᵀ ∂z_i/∂x    ∂h/∂t = ∇h̄(z_i)ᵀ ∂z_i/∂o_i ȯ_i    (ȯ_i as `input` says)
    /// ```
    ///
    /// # Errors
    /// As [`CompositeBarrier::evaluate`].
    pub fn evaluate_pairs<const NX: usize, P: RobotObstaclePair<NX>>(
        &mut self,
        pair: &P,
        x: &[f64; NX],
        obstacles: &[BarrierObstacle],
        input: ObstacleInput,
        constraints: &mut Vec<BarrierConstraint>,
    ) -> Result<(), CompositeError> {
        constraints.clear();
        check(x, obstacles, self.relative.count())?;
        let frame = pair.robot_frame(x);
        self.place(pair, &frame, obstacles);
        self.relative.evaluate::<true>(&self.obstacles, |index| obstacles[index].model, &mut self.samples);
        let (f, g) = (pair.robot_drift(x), pair.robot_control_jacobian(x));
        for (index, obstacle) in obstacles.iter().enumerate() {
            let (sample, z) = (&self.samples[index], &self.obstacles[index].z);
            let dz_dx = pair.relative_state_by_robot(&frame, z);
            let dz_do = pair.relative_state_by_obstacle(&frame, z);
            let by_robot: [f64; NX] =
                std::array::from_fn(|j| (0..4).map(|k| sample.gradient[k] * dz_dx[k][j]).sum());
            let by_obstacle: [f64; 4] =
                std::array::from_fn(|j| (0..4).map(|k| sample.gradient[k] * dz_do[k][j]).sum());
            let by_position = by_obstacle[0] * obstacle.rate[0] + by_obstacle[1] * obstacle.rate[1];
            let rates = &self.input_rates[obstacle.model];
            let by_input: f64 = (0..2)
                .map(|k| {
                    let slope = by_obstacle[DRIVEN[k]];
                    match input {
                        ObstacleInput::Measured => slope * obstacle.rate[DRIVEN[k]],
                        ObstacleInput::WorstCase => (slope * rates.min[k]).min(slope * rates.max[k]),
                    }
                })
                .sum();
            let dh_dt = by_position + by_input;
            let lf_h: f64 = (0..NX).map(|j| by_robot[j] * f[j]).sum();
            let constraint = BarrierConstraint {
                h: sample.h_bar,
                lg_h: [0, 1].map(|control| (0..NX).map(|j| by_robot[j] * g[j][control]).sum()),
                drift: lf_h + dh_dt,
                dh_dt,
                sdf: sample.sdf,
                critical: index,
                outside_domain: u32::from(sample.outside_domain),
            };
            if !finite(&constraint) {
                return Err(CompositeError::NonFiniteResult);
            }
            constraints.push(constraint);
        }
        Ok(())
    }

    /// Combines the constraints of single obstacles to that of their composite: `h` by the softmin with its offset treated
    /// as `offset` says, and everything that is linear in `∇h` by the softmin's weights, which [`CompositeBarrier::weights`]
    /// gives afterwards.
    ///
    /// # Errors
    /// * [`CompositeError::NonFiniteResult`] if the result is not finite.
    pub fn compose(
        &mut self,
        constraints: &[BarrierConstraint],
        offset: SoftminOffset,
    ) -> Result<CompositeSample, CompositeError> {
        let Some(smallest) = constraints.iter().min_by(|a, b| a.h.total_cmp(&b.h)) else {
            return Ok(CompositeSample::Unconstrained);
        };
        self.h_bars.clear();
        self.h_bars.extend(constraints.iter().map(|constraint| constraint.h));
        self.weights.resize(constraints.len(), 0.0);
        let softmin = softmin_weights(&self.h_bars, self.beta_per_m, &mut self.weights);
        let h = match offset {
            SoftminOffset::Keep => softmin,
            SoftminOffset::Remove => smallest.h,
            SoftminOffset::RemoveBound => softmin + libm::log(constraints.len() as f64) / self.beta_per_m,
        };
        let weighted = |part: &dyn Fn(&BarrierConstraint) -> f64| -> f64 {
            constraints.iter().zip(&self.weights).map(|(constraint, weight)| weight * part(constraint)).sum()
        };
        let composite = BarrierConstraint {
            h,
            lg_h: [0, 1].map(|control| weighted(&|constraint| constraint.lg_h[control])),
            drift: weighted(&|constraint| constraint.drift),
            dh_dt: weighted(&|constraint| constraint.dh_dt),
            sdf: constraints.iter().map(|constraint| constraint.sdf).fold(f64::INFINITY, f64::min),
            critical: smallest.critical,
            outside_domain: constraints.iter().map(|constraint| constraint.outside_domain).sum(),
        };
        if finite(&composite) {
            Ok(CompositeSample::Constrained(composite))
        } else {
            Err(CompositeError::NonFiniteResult)
        }
    }
}
