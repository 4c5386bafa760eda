//! Closest approach of a point under one constant acceleration.

use kurbo::common::solve_cubic;

/// When and how near a path passes the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Approach {
    /// Squared distance, m².
    pub(crate) distance_sq: f64,
    /// Time of it, s, at least 0.
    pub(crate) time_s: f64,
}

/// Start of a relative motion in the plane: position in m, velocity in m/s.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Start {
    pub(crate) position: [f64; 2],
    pub(crate) velocity: [f64; 2],
}

impl Start {
    /// Returns the position at `time_s` under the constant `acceleration`.
    #[inline]
    pub(crate) fn position_at(&self, acceleration: &[f64; 2], time_s: f64) -> [f64; 2] {
        std::array::from_fn(|axis| {
            self.position[axis] + time_s * (self.velocity[axis] + 0.5 * acceleration[axis] * time_s)
        })
    }

    /// Returns the nearest that the path under `acceleration` ever comes to the origin, at any time from now on.
    ///
    /// The squared distance is a quartic of time; the candidates are now and the roots of its derivative.
    pub(crate) fn closest_approach(&self, acceleration: &[f64; 2]) -> Approach {
        let (p, v, a) = (&self.position, &self.velocity, acceleration);
        let dot = |x: &[f64; 2], y: &[f64; 2]| x[0] * y[0] + x[1] * y[1];
        let mut nearest = Approach { distance_sq: dot(p, p), time_s: 0.0 };
        // Half the derivative of the squared distance.
        let (c0, c1, c2, c3) = (dot(p, v), dot(v, v) + dot(p, a), 1.5 * dot(v, a), 0.5 * dot(a, a));
        for root in solve_cubic(c0, c1, c2, c3) {
            if root > 0.0 {
                // One step of Newton mends what cancellation in the root's formula may have cost.
                let slope = c1 + root * (2.0 * c2 + root * 3.0 * c3);
                let step = (c0 + root * (c1 + root * (c2 + root * c3))) / slope;
                let time_s = if step.abs() < 0.1 * root { root - step } else { root };
                let at = self.position_at(a, time_s);
                let distance_sq = dot(&at, &at);
                if distance_sq < nearest.distance_sq {
                    nearest = Approach { distance_sq, time_s };
                }
            }
        }
        nearest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_stops_and_turns_are_found() {
        let start = |p, v| Start { position: p, velocity: v };
        // Straight past at 1 m after 3 s.
        let found = start([3.0, 1.0], [-1.0, 0.0]).closest_approach(&[0.0, 0.0]);
        assert!((found.distance_sq - 1.0).abs() < 1e-12 && (found.time_s - 3.0).abs() < 1e-12);
        // Brakes from 2 m/s at 1 m/s²: 2 m of way, then back.
        let found = start([3.0, 0.0], [-2.0, 0.0]).closest_approach(&[1.0, 0.0]);
        assert!((found.distance_sq - 1.0).abs() < 1e-12 && (found.time_s - 2.0).abs() < 1e-6);
        // Leaves at once.
        let found = start([3.0, 0.0], [2.0, 0.0]).closest_approach(&[1.0, 1.0]);
        assert_eq!(found, Approach { distance_sq: 9.0, time_s: 0.0 });
        // At rest for ever.
        let found = start([3.0, 4.0], [0.0, 0.0]).closest_approach(&[0.0, 0.0]);
        assert_eq!(found, Approach { distance_sq: 25.0, time_s: 0.0 });
    }

    #[test]
    fn no_time_is_nearer() {
        let mut seed = 1_u64;
        let mut next = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        for _ in 0..2_000 {
            let start =
                Start { position: [4.0 * next(), 4.0 * next()], velocity: [3.5 * next(), 3.5 * next()] };
            let acceleration = [next(), next()];
            let found = start.closest_approach(&acceleration);
            let at = |time_s: f64| {
                let [x, y] = start.position_at(&acceleration, time_s);
                x * x + y * y
            };
            assert!((at(found.time_s) - found.distance_sq).abs() < 1e-12);
            for k in 0..2_000 {
                let nearer = found.distance_sq - at(0.01 * f64::from(k));
                assert!(nearer < 1e-9, "{start:?} {acceleration:?}: {nearer} nearer at {k}");
            }
        }
    }
}
