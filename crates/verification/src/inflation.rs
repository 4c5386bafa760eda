//! The smallest radius inflation at which no sampled state violates the CBF condition. Not here: the sampling.

use crate::condition::Point;

/// Returns the smallest `c ≥ 0` such that no point with `h ≥ c` has `H + α (h − c) < 0`, m; none up to `largest_m`.
///
/// A point with `H < 0` forbids the inflations in `(h + H/α, h]`: at a smaller one its α-term still makes up for H, at a larger
/// one it lies outside the safe set. The answer is the first gap in the union of these intervals.
pub(crate) fn violation_free_inflation(points: &[Point], alpha_per_s: f64, largest_m: f64) -> Option<f64> {
    let mut forbidden: Vec<(f64, f64)> = points
        .iter()
        .filter(|point| point.hamiltonian_mps < 0.0 && point.h_m >= 0.0)
        .map(|point| (point.h_m + point.hamiltonian_mps / alpha_per_s, point.h_m))
        .collect();
    forbidden.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut free_m = 0.0;
    for (above_m, up_to_m) in forbidden {
        if above_m >= free_m {
            break;
        }
        if up_to_m >= free_m {
            free_m = up_to_m.next_up();
        }
    }
    (free_m <= largest_m).then_some(free_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(h_m: f64, hamiltonian_mps: f64) -> Point {
        Point { z: [0.0; 4], h_m, outside_failure: true, hamiltonian_mps }
    }

    #[test]
    fn without_a_violation_no_inflation_is_needed() {
        assert_eq!(violation_free_inflation(&[point(0.1, 0.2), point(0.5, -1.0)], 4.0, 0.5), Some(0.0));
    }

    #[test]
    fn a_violating_state_is_inflated_away() {
        let free_m = violation_free_inflation(&[point(0.1, -0.8)], 4.0, 0.5).unwrap();
        assert!((0.1..0.1 + 1e-12).contains(&free_m), "{free_m}");
    }

    #[test]
    fn a_chain_of_violating_states_leads_to_its_end() {
        let chain: Vec<Point> = (0..=10).map(|i| point(0.03 * f64::from(i), -0.2)).collect();
        let free_m = violation_free_inflation(&chain, 4.0, 0.5).unwrap();
        assert!((0.3..0.3 + 1e-12).contains(&free_m), "{free_m}");
        assert_eq!(violation_free_inflation(&chain, 4.0, 0.2), None);
    }

    #[test]
    fn a_gap_in_the_chain_is_taken() {
        // The first forbids (-0.05, 0.1], the second (0.15, 0.2]: 0.1 and a hair is free.
        let free_m = violation_free_inflation(&[point(0.1, -0.6), point(0.2, -0.2)], 4.0, 0.5).unwrap();
        assert!((0.1..0.1 + 1e-12).contains(&free_m), "{free_m}");
    }
}
