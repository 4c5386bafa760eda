//! One Kalman filter: what is believed if a certain model is the right one.

use nalgebra::{Matrix2, Matrix6, Matrix6x2, Vector2, Vector6};

use super::Sighting;
use super::model::{MotionModel, Stride};

/// Mean and covariance of `[x, y, vx, vy, ax, ay]`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hypothesis {
    pub(super) mean: Vector6<f64>,
    pub(super) covariance: Matrix6<f64>,
}

impl Hypothesis {
    pub(super) fn begin(model: &MotionModel, sighting: &Sighting, speed_variance_m2ps2: f64) -> Self {
        let [x, y] = sighting.position_m.into();
        let acceleration_variance = model.initial_acceleration_variance();
        let mut covariance = Matrix6::zeros();
        covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&sighting.covariance_m2);
        for axis in 0..2 {
            covariance[(2 + axis, 2 + axis)] = speed_variance_m2ps2;
            covariance[(4 + axis, 4 + axis)] = acceleration_variance;
        }
        Self { mean: Vector6::new(x, y, 0.0, 0.0, 0.0, 0.0), covariance }
    }

    /// x ← A x, P ← A P Aᵀ + g gᵀ, axis by axis.
    pub(super) fn predict(&mut self, stride: &Stride) {
        self.mean = stride.mean_after(&self.mean);
        let p = &mut self.covariance;
        for axis in 0..2 {
            let at = [axis, 2 + axis, 4 + axis];
            for column in 0..6 {
                let moved = stride.apply(at.map(|row| p[(row, column)]));
                (0..3).for_each(|k| p[(at[k], column)] = moved[k]);
            }
        }
        for axis in 0..2 {
            let at = [axis, 2 + axis, 4 + axis];
            for row in 0..6 {
                let moved = stride.apply(at.map(|column| p[(row, column)]));
                (0..3).for_each(|k| p[(row, at[k])] = moved[k]);
            }
            for (i, gi) in stride.noise.into_iter().enumerate() {
                for (j, gj) in stride.noise.into_iter().enumerate() {
                    p[(at[i], at[j])] += gi * gj;
                }
            }
        }
    }

    /// Covariance of the position alone at the end of a stride, m².
    pub(super) fn position_covariance_after(&self, stride: &Stride) -> Matrix2<f64> {
        let row = stride.position_row();
        let mut covariance = Matrix2::identity() * stride.noise[0].powi(2);
        for i in 0..3 {
            for j in 0..3 {
                covariance += self.covariance.fixed_view::<2, 2>(2 * i, 2 * j) * (row[i] * row[j]);
            }
        }
        covariance
    }

    /// Takes a sighting and returns its log-likelihood, but for a constant.
    ///
    /// S = H P Hᵀ + R, K = P Hᵀ S⁻¹, x ← x + K (y - H x), P ← (I - K H) P (I - K H)ᵀ + K R Kᵀ: Joseph's form, which rounding
    /// cannot make indefinite.
    pub(super) fn correct(&mut self, sighting: &Sighting) -> f64 {
        let p_ht: Matrix6x2<f64> = self.covariance.fixed_columns::<2>(0).into_owned();
        let s = p_ht.fixed_rows::<2>(0) + sighting.covariance_m2;
        let gain = p_ht * inverse(&s);
        let innovation = sighting.position_m - self.mean.fixed_rows::<2>(0);
        self.mean += gain * innovation;
        let half = self.covariance - gain * p_ht.transpose();
        let half_ht: Matrix6x2<f64> = half.fixed_columns::<2>(0).into_owned();
        let after = half + (gain * sighting.covariance_m2 - half_ht) * gain.transpose();
        self.covariance = (after + after.transpose()) * 0.5;
        let (distance2, log_determinant) = surprise(&innovation, &s);
        -0.5 * (distance2 + log_determinant)
    }
}

/// Determinant of the covariance of a position, m⁴. No sighting is more exact than a millimetre, so that is a lower bound
/// which only rounding can undercut.
fn determinant(s: &Matrix2<f64>) -> f64 {
    const LEAST_M4: f64 = 1e-12;
    s.determinant().max(LEAST_M4)
}

fn inverse(s: &Matrix2<f64>) -> Matrix2<f64> {
    Matrix2::new(s.m22, -s.m12, -s.m21, s.m11) / determinant(s)
}

/// Squared Mahalanobis distance of `innovation` under the covariance `s`, and the logarithm of its determinant.
pub(super) fn surprise(innovation: &Vector2<f64>, s: &Matrix2<f64>) -> (f64, f64) {
    (innovation.dot(&(inverse(s) * innovation)), determinant(s).ln())
}
