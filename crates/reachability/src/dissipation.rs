//! Bounds on `|∂H/∂p_i|` at one state: how fast the value can travel along each axis.
//!
//! The gradient of `H(z, p) = p·f + max_u p·G_u u + min_d p·G_d d` by `p` is the flow under optimal inputs,
//! `f + G_u u*(p) + G_d d*(p)`. The bounds differ in what they know of `u*` and `d*`.

use crate::Dissipation;
use dynamics::RelativeDynamics;

/// One input: the direction it pushes the state in and its value by the sign of `p · direction`.
struct Push<const N: usize> {
    direction: [f64; N],
    /// Value of the input where `p · direction > 0`.
    if_positive: f64,
    /// Value of the input where `p · direction < 0`.
    if_negative: f64,
}

/// Returns a bound on `|∂H/∂p_i|` per axis, state units per second.
pub(crate) fn rate_bounds<const N: usize, const NU: usize, const ND: usize>(
    dynamics: &impl RelativeDynamics<N, NU, ND>,
    z: &[f64; N],
    dissipation: Dissipation,
) -> [f64; N] {
    let drift = dynamics.drift(z);
    let (by_control, by_disturbance) = (dynamics.control_jacobian(z), dynamics.disturbance_jacobian(z));
    let (u, d) = (dynamics.control_box(), dynamics.disturbance_box());
    let push = |k: usize| {
        if k < NU {
            Push {
                direction: std::array::from_fn(|i| by_control[i][k]),
                if_positive: u.max[k],
                if_negative: u.min[k],
            }
        } else {
            let k = k - NU;
            Push {
                direction: std::array::from_fn(|i| by_disturbance[i][k]),
                if_positive: d.min[k],
                if_negative: d.max[k],
            }
        }
    };
    let pushes = || (0..NU + ND).map(push);
    match dissipation {
        Dissipation::BoxMagnitude => std::array::from_fn(|i| {
            let largest = |p: Push<N>| p.direction[i].abs() * p.if_positive.abs().max(p.if_negative.abs());
            drift[i].abs() + pushes().map(largest).sum::<f64>()
        }),
        Dissipation::ReachableSpeed => {
            let (mut lowest, mut highest) = (drift, drift);
            for push in pushes() {
                for i in 0..N {
                    let ends = (push.direction[i] * push.if_positive, push.direction[i] * push.if_negative);
                    lowest[i] += ends.0.min(ends.1);
                    highest[i] += ends.0.max(ends.1);
                }
            }
            larger_magnitude(&lowest, &highest)
        }
        Dissipation::OptimalPlay => {
            let (mut lowest, mut highest) = (drift, drift);
            for leader in 0..NU + ND {
                let direction = push(leader).direction;
                // Its group was counted with the group's first member; an input without effect belongs to none.
                if (0..leader).any(|k| parallel(&push(k).direction, &direction) != Parallel::No) {
                    continue;
                }
                // One costate decides for all inputs that push along the same line.
                let (mut positive, mut negative) = ([0.0; N], [0.0; N]);
                for k in leader..NU + ND {
                    let member = push(k);
                    let (if_positive, if_negative) = match parallel(&direction, &member.direction) {
                        Parallel::No => continue,
                        Parallel::Same => (member.if_positive, member.if_negative),
                        Parallel::Opposite => (member.if_negative, member.if_positive),
                    };
                    for i in 0..N {
                        positive[i] += member.direction[i] * if_positive;
                        negative[i] += member.direction[i] * if_negative;
                    }
                }
                for i in 0..N {
                    lowest[i] += positive[i].min(negative[i]);
                    highest[i] += positive[i].max(negative[i]);
                }
            }
            larger_magnitude(&lowest, &highest)
        }
    }
}

fn larger_magnitude<const N: usize>(lowest: &[f64; N], highest: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|i| lowest[i].abs().max(highest[i].abs()))
}

/// Whether two directions lie on one line.
#[derive(PartialEq)]
enum Parallel {
    No,
    Same,
    Opposite,
}

/// Compares exactly: directions that are parallel up to rounding count as not, which only makes the bound larger. The zero
/// direction is parallel to none.
fn parallel<const N: usize>(a: &[f64; N], b: &[f64; N]) -> Parallel {
    let on_one_line = (0..N).all(|i| (0..i).all(|k| a[i] * b[k] == a[k] * b[i]));
    let product: f64 = (0..N).map(|i| a[i] * b[i]).sum();
    if !on_one_line || product == 0.0 {
        Parallel::No
    } else if product > 0.0 {
        Parallel::Same
    } else {
        Parallel::Opposite
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dynamics::{DoubleIntegratorPair, InputBox, UnicyclePair};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    fn quadrotor() -> DoubleIntegratorPair {
        DoubleIntegratorPair {
            control: InputBox::new([-2.0; 2], [2.0; 2]).unwrap(),
            disturbance: InputBox::new([-1.0; 2], [1.0; 2]).unwrap(),
        }
    }

    fn ground_robot() -> UnicyclePair {
        UnicyclePair {
            control: InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap(),
            disturbance: InputBox::new([-0.35], [0.35]).unwrap(),
        }
    }

    /// No costate makes the value travel faster than the bound; some make it travel as fast.
    ///
    /// `reached` names the axes along which the bound is met by one of the costates.
    fn bounds_hold<const NU: usize, const ND: usize>(
        dynamics: &impl RelativeDynamics<4, NU, ND>,
        reached: [bool; 4],
    ) {
        let mut random = Pcg64Mcg::seed_from_u64(5);
        for _ in 0..300 {
            let z: [f64; 4] = std::array::from_fn(|_| random.random_range(-4.0..4.0));
            let bounds = rate_bounds(dynamics, &z, Dissipation::OptimalPlay);
            let looser = rate_bounds(dynamics, &z, Dissipation::ReachableSpeed);
            let loosest = rate_bounds(dynamics, &z, Dissipation::BoxMagnitude);
            let mut fastest = [0.0_f64; 4];
            for _ in 0..300 {
                let p: [f64; 4] = std::array::from_fn(|_| random.random_range(-1.0..1.0));
                let u = dynamics.optimal_control(&z, &p);
                let d = dynamics.optimal_disturbance(&z, &p);
                let flow = dynamics.flow(&z, &u, &d);
                for i in 0..4 {
                    fastest[i] = fastest[i].max(flow[i].abs());
                }
            }
            for i in 0..4 {
                assert!(fastest[i] <= bounds[i] + 1e-12, "axis {i}: {} above {}", fastest[i], bounds[i]);
                assert!(bounds[i] <= looser[i] + 1e-12 && looser[i] <= loosest[i] + 1e-12, "axis {i}");
                assert!(!reached[i] || bounds[i] <= fastest[i] + 1e-12, "axis {i}: {} is loose", bounds[i]);
            }
        }
    }

    #[test]
    fn no_costate_makes_the_value_travel_faster() {
        bounds_hold(&quadrotor(), [true; 4]);
        // A costate near one corner of four signs may be missed by the sample, hence no tightness along x, y and θ.
        bounds_hold(&ground_robot(), [false, false, false, true]);
    }

    #[test]
    fn opposed_accelerations_cancel() {
        let z = [1.0, -2.0, 0.5, -1.5];
        assert_eq!(rate_bounds(&quadrotor(), &z, Dissipation::BoxMagnitude), [0.5, 1.5, 3.0, 3.0]);
        assert_eq!(rate_bounds(&quadrotor(), &z, Dissipation::ReachableSpeed), [0.5, 1.5, 3.0, 3.0]);
        assert_eq!(rate_bounds(&quadrotor(), &z, Dissipation::OptimalPlay), [0.5, 1.5, 1.0, 1.0]);
    }

    #[test]
    fn independent_turn_rates_do_not_cancel() {
        let z = [1.0, 2.0, 0.0, 1.5];
        let close = |a: [f64; 4], b: [f64; 4]| (0..4).all(|i| (a[i] - b[i]).abs() < 1e-12);
        // x: 1.5 + 0.8·2 − 0.25; y: 0.8·1; θ: 0.8 + 0.35, for the robot's turn also moves x and y.
        assert!(close(rate_bounds(&ground_robot(), &z, Dissipation::OptimalPlay), [2.85, 0.8, 1.15, 0.0]));
        // Robot and obstacle in one place: both turns push θ alone, against each other.
        let touching = rate_bounds(&ground_robot(), &[0.0, 0.0, 0.0, 1.5], Dissipation::OptimalPlay);
        assert!(close(touching, [1.25, 0.0, 0.8 - 0.35, 0.0]), "{touching:?}");
    }
}
