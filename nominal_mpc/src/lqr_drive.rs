//! LQR of the planar double integrator: the paper's nominal controller of the quadrotor.

use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use optimal_control::{LqrError, continuous_lqr};
use settings::LqrSettings;

/// `u = −K (x − x_ref)` with the position error shortened to a chosen length.
#[derive(Debug, Clone)]
pub(crate) struct LqrDrive {
    gain: SMatrix<f64, 2, 4>,
    max_position_error_m: f64,
}

impl LqrDrive {
    /// Solves the Riccati equation of `p' = v, v' = u` for the given weights.
    pub(crate) fn new(settings: &LqrSettings) -> Result<Self, LqrError> {
        let a = DMatrix::from_fn(4, 4, |row, column| f64::from(column == row + 2));
        let b = DMatrix::from_fn(4, 2, |row, column| f64::from(row == column + 2));
        let diagonal = |weights: &[f64]| DMatrix::from_diagonal(&DVector::from_column_slice(weights));
        let lqr =
            continuous_lqr(&a, &b, &diagonal(&settings.state_weight), &diagonal(&settings.control_weight))?;
        Ok(Self {
            gain: SMatrix::from_fn(|row, column| lqr.gain[(row, column)]),
            max_position_error_m: settings.max_position_error_m,
        })
    }

    /// Acceleration `[ax, ay]` in `odom`, m/s², towards a standstill at the goal.
    ///
    /// Not brought into the input box: the filter's QP holds the box, and the authors hand the QP the unclipped
    /// command too. Shortening the error to `e` bounds the cruising speed by `k_p e / k_v`.
    pub(crate) fn control(
        &self,
        position_in_odom_m: [f64; 2],
        velocity_in_odom_mps: [f64; 2],
        goal_in_odom_m: [f64; 2],
    ) -> [f64; 2] {
        let error = [position_in_odom_m[0] - goal_in_odom_m[0], position_in_odom_m[1] - goal_in_odom_m[1]];
        let distance = error[0].hypot(error[1]);
        let shorten =
            if distance > self.max_position_error_m { self.max_position_error_m / distance } else { 1.0 };
        let [vx, vy] = velocity_in_odom_mps;
        let u = -self.gain * SVector::from([shorten * error[0], shorten * error[1], vx, vy]);
        [u[0], u[1]]
    }
}
