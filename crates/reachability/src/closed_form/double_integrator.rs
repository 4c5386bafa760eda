//! The exact value of the double-integrator pair.
//!
//! Robot and obstacle accelerate against each other along the same two axes, so the Hamiltonian is that of a single
//! player who chooses the relative acceleration `a = d − u` from what the robot has to spare:
//!
//! ```text
//! V(p, v) = max_a min_{t ≥ 0} |p + v t + a t²/2| − R,      a_k ∈ [d_max − u_max, d_min − u_min]
//! ```
//!
//! with `a` constant until the closest approach: the costate of the position is then a constant direction `n`, that of the
//! velocity `n (τ − t)`, so no component of `a` changes sign. As long as the robot can cancel whatever the obstacle does
//! (`a = 0` is possible), the best `a` is one of the box's four corners. That was found by search, not by proof: over
//! twelve million states and boxes no edge, balance of two approaches or interior point was ever better.

use super::approach::{Approach, Start};
use dynamics::InputBox;

/// Why the pair has no closed form.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ClosedFormError {
    /// The robot cannot cancel every acceleration of the obstacle, so the game does not reduce to one evasion.
    #[error(
        "along axis {axis} the obstacle accelerates within {obstacle_mps2:?} m/s², which is not within the robot's \
         {robot_mps2:?}; solve on a grid instead"
    )]
    StrongerObstacle {
        /// Index of the axis.
        axis: usize,
        /// The robot's interval.
        robot_mps2: [f64; 2],
        /// The obstacle's interval.
        obstacle_mps2: [f64; 2],
    },
    /// The failure radius is no length.
    #[error("the failure radius is {radius_m} m; give a finite one of at least 0")]
    Radius {
        /// What was given.
        radius_m: f64,
    },
}

/// `V` of [`DoubleIntegratorPair`](dynamics::DoubleIntegratorPair) with `ℓ = |p| − R` and an unlimited horizon.
///
/// As in the pair itself, velocities are unbounded: what the robot's and obstacle's top speeds forbid is not seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DoubleIntegratorValue {
    /// The corners of the box of relative accelerations, m/s².
    corners_mps2: [[f64; 2]; 4],
    failure_radius_m: f64,
}

impl DoubleIntegratorValue {
    /// Returns the value function for accelerations of robot and obstacle within `control` and `disturbance`, m/s², and the
    /// failure radius `R`.
    ///
    /// # Errors
    /// * [`ClosedFormError::StrongerObstacle`] where the obstacle's interval reaches beyond the robot's.
    /// * [`ClosedFormError::Radius`] if the radius is negative or not finite.
    pub fn new(
        control: &InputBox<2>,
        disturbance: &InputBox<2>,
        failure_radius_m: f64,
    ) -> Result<Self, ClosedFormError> {
        let (u, d) = (control, disturbance);
        for axis in 0..2 {
            if !(u.min[axis] <= d.min[axis] && d.max[axis] <= u.max[axis]) {
                return Err(ClosedFormError::StrongerObstacle {
                    axis,
                    robot_mps2: [u.min[axis], u.max[axis]],
                    obstacle_mps2: [d.min[axis], d.max[axis]],
                });
            }
        }
        if !(failure_radius_m.is_finite() && failure_radius_m >= 0.0) {
            return Err(ClosedFormError::Radius { radius_m: failure_radius_m });
        }
        let low: [f64; 2] = std::array::from_fn(|axis| d.max[axis] - u.max[axis]);
        let high: [f64; 2] = std::array::from_fn(|axis| d.min[axis] - u.min[axis]);
        let corners_mps2 = [low, [low[0], high[1]], [high[0], low[1]], high];
        Ok(Self { corners_mps2, failure_radius_m })
    }

    /// Returns `V(z)`, m, at `z = [x_m, y_m, vx_mps, vy_mps]`; NaN where `z` is.
    pub fn value_m(&self, z: &[f64; 4]) -> f64 {
        self.best_evasion(&start(z)).1.distance_sq.sqrt() - self.failure_radius_m
    }

    /// Returns `V(z)`, m, and `∇V(z)`, m per state unit.
    ///
    /// With the closest approach at time `τ` in direction `n`: `∂V/∂p = n`, `∂V/∂v = n τ`. Where `V` has a kink, because
    /// two evasions or two approaches are equally good, this is the gradient of one side; where the path hits the origin
    /// itself it is zero.
    pub fn value_and_gradient(&self, z: &[f64; 4]) -> (f64, [f64; 4]) {
        let start = start(z);
        let (acceleration, Approach { distance_sq, time_s }) = self.best_evasion(&start);
        let distance_m = distance_sq.sqrt();
        let position = start.position_at(acceleration, time_s);
        let n = if distance_m > 0.0 { position.map(|x| x / distance_m) } else { [0.0; 2] };
        (distance_m - self.failure_radius_m, [n[0], n[1], n[0] * time_s, n[1] * time_s])
    }

    /// Returns the acceleration that keeps the closest approach farthest, and that approach.
    fn best_evasion(&self, start: &Start) -> (&[f64; 2], Approach) {
        let [first, others @ ..] = &self.corners_mps2;
        let mut best = (first, start.closest_approach(first));
        for corner in others {
            let approach = start.closest_approach(corner);
            if approach.distance_sq > best.1.distance_sq {
                best = (corner, approach);
            }
        }
        best
    }
}

fn start(z: &[f64; 4]) -> Start {
    Start { position: [z[0], z[1]], velocity: [z[2], z[3]] }
}
