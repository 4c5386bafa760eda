//! The failure function of a disc. Not here: what is learned on top of it (`relative_barrier`).

/// Failure function `ℓ(z) = |p| − R` of a disc-shaped robot and a disc-shaped obstacle.
///
/// `p` is the obstacle's centre relative to the robot's, the first two components of `z`; `R` is the sum of
/// both radii plus any buffer. `ℓ ≤ 0` is failure (paper, sections on reachability and experiments).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FailureFunction {
    /// `R`, m.
    pub radius_m: f64,
}

impl FailureFunction {
    /// Returns `ℓ(z)`, m.
    pub fn value(&self, z: &[f64; 4]) -> f64 {
        distance_m(z) - self.radius_m
    }

    /// Returns `∇ℓ(z)`: the unit vector along `p`, and zero at `p = 0`.
    ///
    /// `ℓ` has no gradient at `p = 0`, its minimum; zero is the subgradient there that prefers no direction.
    pub fn gradient(&self, z: &[f64; 4]) -> [f64; 4] {
        let distance_m = distance_m(z);
        if distance_m == 0.0 {
            return [0.0; 4];
        }
        [z[0] / distance_m, z[1] / distance_m, 0.0, 0.0]
    }
}

/// `√(x² + y²)`: rounded alike on every machine, unlike `hypot`.
fn distance_m(z: &[f64; 4]) -> f64 {
    (z[0] * z[0] + z[1] * z[1]).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const DISC: FailureFunction = FailureFunction { radius_m: 0.7 };

    #[test]
    fn value_is_distance_minus_radius() {
        assert!((DISC.value(&[3.0, -4.0, 1.0, 1.0]) - 4.3).abs() < 1e-15);
    }

    #[test]
    fn gradient_is_a_unit_vector_away_from_the_centre_and_zero_at_it() {
        assert_eq!(DISC.gradient(&[3.0, -4.0, 1.0, 1.0]), [0.6, -0.8, 0.0, 0.0]);
        assert_eq!(DISC.gradient(&[0.0; 4]), [0.0; 4]);
        assert_eq!(DISC.value(&[0.0; 4]), -0.7);
    }
}
