//! The box of relative states the network was trained on, and what holds outside of it.

/// Axis-aligned box of relative states, some axes periodic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrainedDomain {
    min: [f64; 4],
    max: [f64; 4],
    periodic: [bool; 4],
    idle: [bool; 4],
}

/// A state brought into the domain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedState {
    /// The nearest state inside, component by component; periodic components are wrapped.
    pub z: [f64; 4],
    /// Which components carry a gradient: those that were inside and are not idle.
    pub carries_gradient: [bool; 4],
    outside: bool,
}

/// Why limits make no domain.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum DomainError {
    /// An axis without extent or with a bound that is not finite.
    #[error("axis {axis} of the trained domain runs from {min} to {max}; write finite, increasing limits")]
    Axis {
        /// Index of the axis.
        axis: usize,
        /// Lower end given.
        min: f64,
        /// Upper end given.
        max: f64,
    },
}

impl TrainedDomain {
    /// Returns the box `min ≤ z ≤ max`; on a periodic axis `max − min` is the period.
    ///
    /// # Errors
    /// * [`DomainError::Axis`] for an axis without extent or with a bound that is not finite.
    pub fn new(min: [f64; 4], max: [f64; 4], periodic: [bool; 4]) -> Result<Self, DomainError> {
        for axis in 0..4 {
            let (min, max) = (min[axis], max[axis]);
            if !(min.is_finite() && max.is_finite() && min < max) {
                return Err(DomainError::Axis { axis, min, max });
            }
        }
        Ok(Self { min, max, periodic, idle: [false; 4] })
    }

    /// Returns the same box with components that do not matter: they are taken for 0, carry no gradient, and lie
    /// nowhere outside.
    #[must_use]
    pub fn with_idle(self, idle: [bool; 4]) -> Self {
        Self { idle, ..self }
    }

    /// Returns the nearest state inside and what of it still depends on `z`.
    ///
    /// Continuous in `z` (on a periodic axis apart from the seam). A NaN stays NaN.
    pub fn place(&self, z: &[f64; 4]) -> PlacedState {
        let mut placed = PlacedState { z: *z, carries_gradient: [true; 4], outside: false };
        for axis in 0..4 {
            let (min, max) = (self.min[axis], self.max[axis]);
            if self.idle[axis] {
                (placed.z[axis], placed.carries_gradient[axis]) = (0.0_f64.clamp(min, max), false);
            } else if self.periodic[axis] {
                if !(min..max).contains(&z[axis]) {
                    placed.z[axis] = min + (z[axis] - min).rem_euclid(max - min);
                }
            } else {
                placed.z[axis] = z[axis].clamp(min, max);
                placed.carries_gradient[axis] = placed.z[axis] == z[axis];
                placed.outside |= !placed.carries_gradient[axis];
            }
        }
        placed
    }
}

impl PlacedState {
    /// Returns whether a component that matters had to be moved.
    pub fn was_outside(&self) -> bool {
        self.outside
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn ground_robot() -> TrainedDomain {
        TrainedDomain::new([-6.0, -6.0, -PI, 0.0], [6.0, 6.0, PI, 1.5], [false, false, true, false]).unwrap()
    }

    #[test]
    fn a_state_inside_stays_as_it_is() {
        let z = [1.0, -5.9, 3.0, 1.5];
        let placed = ground_robot().place(&z);
        assert_eq!(placed.z, z);
        assert!(!placed.was_outside());
    }

    #[test]
    fn position_and_speed_are_clamped_and_lose_their_gradient() {
        let placed = ground_robot().place(&[9.0, 0.0, 0.5, 2.0]);
        assert_eq!(placed.z, [6.0, 0.0, 0.5, 1.5]);
        assert_eq!(placed.carries_gradient, [false, true, true, false]);
        assert!(placed.was_outside());
    }

    #[test]
    fn an_angle_wraps_and_counts_as_inside() {
        let placed = ground_robot().place(&[0.0, 0.0, 4.0, 1.0]);
        assert!((placed.z[2] - (4.0 - 2.0 * PI)).abs() < 1e-12);
        assert!(!placed.was_outside());
    }

    #[test]
    fn an_idle_component_is_nowhere_outside_and_carries_no_gradient() {
        let placed = ground_robot().with_idle([false, false, true, true]).place(&[1.0, 2.0, 0.5, 9.0]);
        assert_eq!((placed.z, placed.was_outside()), ([1.0, 2.0, 0.0, 0.0], false));
        assert_eq!(placed.carries_gradient, [true, true, false, false]);
    }

    #[test]
    fn an_axis_without_extent_is_refused() {
        let error = TrainedDomain::new([0.0; 4], [1.0, 1.0, 0.0, 1.0], [false; 4]).unwrap_err();
        assert!(matches!(error, DomainError::Axis { axis: 2, .. }));
    }
}
