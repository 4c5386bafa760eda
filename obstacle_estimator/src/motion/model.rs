//! How obstacles are expected to move: linear models of one axis, the same along both.

use nalgebra::Vector6;

/// A motion that an obstacle may follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MotionModel {
    /// Constant velocity, disturbed by a random acceleration that is constant between two sightings (discrete white-noise
    /// acceleration): Q = q² [[T⁴/4, T³/2], [T³/2, T²]]. The acceleration itself is no part of the state: its mean is zero.
    ConstantVelocity {
        /// q along each axis, m/s².
        acceleration_sd_mps2: f64,
    },
    /// An acceleration that decays with a time constant and is renewed at random, so that its variance stays (Singer's
    /// model). What is renewed comes in linearly over the interval, so the noise has one component whatever its length.
    Manoeuvre {
        /// Stationary standard deviation of the acceleration along each axis, m/s².
        acceleration_sd_mps2: f64,
        /// Time constant of the decay, s.
        time_constant_s: f64,
    },
}

impl MotionModel {
    /// Variance of the acceleration of somebody just met, m²/s⁴.
    pub(super) fn initial_acceleration_variance(&self) -> f64 {
        match self {
            Self::ConstantVelocity { .. } => 0.0,
            Self::Manoeuvre { acceleration_sd_mps2, .. } => acceleration_sd_mps2.powi(2),
        }
    }

    /// What happens within `elapsed_s`, s, ≥ 0.
    pub(super) fn stride(&self, elapsed_s: f64) -> Stride {
        let t = elapsed_s;
        match *self {
            Self::ConstantVelocity { acceleration_sd_mps2: q } => Stride {
                elapsed_s,
                position_from_acceleration_s2: 0.0,
                velocity_from_acceleration_s: 0.0,
                remaining: 0.0,
                noise: [q * t * t / 2.0, q * t, 0.0],
            },
            Self::Manoeuvre { acceleration_sd_mps2, time_constant_s: tau } => {
                let decayed = -(-t / tau).exp_m1();
                // The renewed share has variance σ² (1 - ρ²), with 1 - ρ² = (1 - ρ)(1 + ρ).
                let renewed = acceleration_sd_mps2 * (decayed * (2.0 - decayed)).sqrt();
                Stride {
                    elapsed_s,
                    position_from_acceleration_s2: tau * (t - tau * decayed),
                    velocity_from_acceleration_s: tau * decayed,
                    remaining: 1.0 - decayed,
                    noise: [renewed * t * t / 6.0, renewed * t / 2.0, renewed],
                }
            }
        }
    }
}

/// One model's transition over one interval, along each axis:
///
/// p' = p + T v + c a, v' = v + b a, a' = ρ a, and the covariance gains g gᵀ.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stride {
    /// T.
    elapsed_s: f64,
    /// c.
    position_from_acceleration_s2: f64,
    /// b.
    velocity_from_acceleration_s: f64,
    /// ρ.
    remaining: f64,
    /// g, in m, m/s, m/s².
    pub(super) noise: [f64; 3],
}

impl Stride {
    /// Position, velocity and acceleration along one axis at the end of the stride.
    pub(super) fn apply(&self, [p, v, a]: [f64; 3]) -> [f64; 3] {
        [
            p + self.elapsed_s * v + self.position_from_acceleration_s2 * a,
            v + self.velocity_from_acceleration_s * a,
            self.remaining * a,
        ]
    }

    /// The mean at the end of the stride.
    pub(super) fn mean_after(&self, mean: &Vector6<f64>) -> Vector6<f64> {
        let [x, vx, ax] = self.apply([mean[0], mean[2], mean[4]]);
        let [y, vy, ay] = self.apply([mean[1], mean[3], mean[5]]);
        Vector6::new(x, y, vx, vy, ax, ay)
    }

    /// What multiplies p, v and a in p'.
    pub(super) fn position_row(&self) -> [f64; 3] {
        [1.0, self.elapsed_s, self.position_from_acceleration_s2]
    }
}
