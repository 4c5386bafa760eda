//! What every pair must satisfy, run on each of them.

#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not recognise as such

use dynamics::{
    DoubleIntegratorPair, InputBox, RelativeDynamics, RobotObstaclePair, UnicyclePair, wrap_angle,
};
use std::f64::consts::{PI, TAU};

/// Deterministic numbers in `[-1, 1)`, enough to scatter test states.
struct Scatter(u64);

impl Scatter {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn vector<const N: usize>(&mut self, scale: f64) -> [f64; N] {
        std::array::from_fn(|_| scale * self.next())
    }

    fn inside<const N: usize>(&mut self, bounds: &InputBox<N>) -> [f64; N] {
        std::array::from_fn(|j| bounds.min[j] + 0.5 * (1.0 + self.next()) * (bounds.max[j] - bounds.min[j]))
    }
}

fn unicycle() -> UnicyclePair {
    UnicyclePair {
        control: InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap(),
        disturbance: InputBox::new([-0.35], [0.35]).unwrap(),
    }
}

fn double_integrator() -> DoubleIntegratorPair {
    DoubleIntegratorPair {
        control: InputBox::new([-2.0; 2], [2.0; 2]).unwrap(),
        disturbance: InputBox::new([-1.0; 2], [1.0; 2]).unwrap(),
    }
}

/// `H` lies above every `min_d` over the box's corners and below every `max_u`, and is reached.
fn hamiltonian_is_the_game_value<const NZ: usize, const NU: usize, const ND: usize>(
    dynamics: &impl RelativeDynamics<NZ, NU, ND>,
) {
    let mut scatter = Scatter(7);
    let dot = |p: &[f64; NZ], v: [f64; NZ]| (0..NZ).map(|i| p[i] * v[i]).sum::<f64>();
    for _ in 0..500 {
        let (z, p) = (scatter.vector(4.0), scatter.vector(2.0));
        // An affine function over a box takes its extremes at corners: try all of them.
        let corner =
            |lo: &[f64], hi: &[f64], bits: usize, j: usize| if bits >> j & 1 == 1 { hi[j] } else { lo[j] };
        let (u_box, d_box) = (*dynamics.control_box(), *dynamics.disturbance_box());
        let value = (0..1 << NU)
            .map(|a| {
                let u: [f64; NU] = std::array::from_fn(|j| corner(&u_box.min, &u_box.max, a, j));
                (0..1 << ND)
                    .map(|b| {
                        let d: [f64; ND] = std::array::from_fn(|j| corner(&d_box.min, &d_box.max, b, j));
                        dot(&p, dynamics.flow(&z, &u, &d))
                    })
                    .fold(f64::INFINITY, f64::min)
            })
            .fold(f64::NEG_INFINITY, f64::max);
        let hamiltonian = dynamics.hamiltonian(&z, &p);
        assert!((hamiltonian - value).abs() < 1e-12, "H = {hamiltonian}, brute force {value}");

        let (u, d) = (scatter.inside(&u_box), scatter.inside(&d_box));
        assert!(u_box.contains(&dynamics.optimal_control(&z, &p)));
        assert!(dot(&p, dynamics.flow(&z, &u, &dynamics.optimal_disturbance(&z, &p))) <= value + 1e-12);
        assert!(dot(&p, dynamics.flow(&z, &dynamics.optimal_control(&z, &p), &d)) >= value - 1e-12);
    }
}

/// Jacobians of `ρ` against central differences, and `ρ` against the relative dynamics:
/// `∂z/∂x ẋ + ∂z/∂o ȯ = ζ(z, u, d)` (paper, equation `relative_dynamics`).
fn relative_state_is_consistent<P, const NX: usize, const ND: usize>(
    pair: &P,
    obstacle_rate: impl Fn(&[f64; 4], &[f64; ND]) -> [f64; 4],
) where
    P: RobotObstaclePair<NX> + RelativeDynamics<4, 2, ND>,
{
    let mut scatter = Scatter(11);
    let step = 1e-6;
    let difference = |plus: [f64; 4], minus: [f64; 4], i: usize| {
        let raw = plus[i] - minus[i];
        // Across the seam of the relative heading, the short way round is meant.
        (if raw.abs() > PI { wrap_angle(raw) } else { raw }) / (2.0 * step)
    };
    for _ in 0..500 {
        let (x, o): ([f64; NX], [f64; 4]) = (scatter.vector(3.0), scatter.vector(3.0));
        let (dz_dx, dz_do) = (pair.relative_state_by_robot(&x, &o), pair.relative_state_by_obstacle(&x, &o));
        for k in 0..NX {
            let (mut plus, mut minus) = (x, x);
            plus[k] += step;
            minus[k] -= step;
            let (plus, minus) = (pair.relative_state(&plus, &o), pair.relative_state(&minus, &o));
            for i in 0..4 {
                assert!((dz_dx[i][k] - difference(plus, minus, i)).abs() < 1e-7, "dz{i}/dx{k}");
            }
        }
        for k in 0..4 {
            let (mut plus, mut minus) = (o, o);
            plus[k] += step;
            minus[k] -= step;
            let (plus, minus) = (pair.relative_state(&x, &plus), pair.relative_state(&x, &minus));
            for i in 0..4 {
                assert!((dz_do[i][k] - difference(plus, minus, i)).abs() < 1e-7, "dz{i}/do{k}");
            }
        }

        let (u, d) = (scatter.inside(pair.control_box()), scatter.inside(pair.disturbance_box()));
        let (f, g) = (pair.robot_drift(&x), pair.robot_control_jacobian(&x));
        let o_rate = obstacle_rate(&o, &d);
        let flow = pair.flow(&pair.relative_state(&x, &o), &u, &d);
        for i in 0..4 {
            let by_robot: f64 = (0..NX).map(|k| dz_dx[i][k] * (f[k] + g[k][0] * u[0] + g[k][1] * u[1])).sum();
            let by_obstacle: f64 = (0..4).map(|k| dz_do[i][k] * o_rate[k]).sum();
            assert!((by_robot + by_obstacle - flow[i]).abs() < 1e-12, "row {i}");
        }
    }
}

#[test]
fn unicycle_hamiltonian_matches_brute_force_over_the_boxes() {
    hamiltonian_is_the_game_value(&unicycle());
}

#[test]
fn double_integrator_hamiltonian_matches_brute_force_over_the_boxes() {
    hamiltonian_is_the_game_value(&double_integrator());
}

#[test]
fn unicycle_relative_state_follows_from_robot_and_obstacle() {
    relative_state_is_consistent(&unicycle(), |o, d: &[f64; 1]| {
        [o[3] * o[2].cos(), o[3] * o[2].sin(), d[0], 0.0]
    });
}

#[test]
fn double_integrator_relative_state_follows_from_robot_and_obstacle() {
    relative_state_is_consistent(&double_integrator(), |o, d: &[f64; 2]| [o[2], o[3], d[0], d[1]]);
}

/// Mirroring the scene about the robot's axis leaves the game unchanged, hence V(x,y,θ,v) = V(x,−y,−θ,v).
#[test]
fn unicycle_hamiltonian_is_mirror_symmetric() {
    let pair = unicycle();
    let mut scatter = Scatter(3);
    for _ in 0..500 {
        let (z, p): ([f64; 4], [f64; 4]) = (scatter.vector(4.0), scatter.vector(2.0));
        let mirrored = |v: [f64; 4]| [v[0], -v[1], -v[2], v[3]];
        let (here, there) = (pair.hamiltonian(&z, &p), pair.hamiltonian(&mirrored(z), &mirrored(p)));
        assert!((here - there).abs() < 1e-12, "{here} and {there}");
    }
}

#[test]
fn relative_heading_stays_in_its_interval() {
    for turns in -3..=3 {
        for k in -8..8 {
            let angle = f64::from(k) * PI / 8.0;
            let wrapped = wrap_angle(angle + f64::from(turns) * TAU);
            assert!((-PI..PI).contains(&wrapped));
            assert!(((wrapped - angle) / TAU - ((wrapped - angle) / TAU).round()).abs() < 1e-12);
        }
    }
    assert_eq!(wrap_angle(PI), -PI);
    assert!((wrap_angle(-PI - 1e-9) - (PI - 1e-9)).abs() < 1e-15);
    for tiny in [(-PI).next_down(), PI.next_down(), -1e-300] {
        assert!((-PI..PI).contains(&wrap_angle(tiny)), "{tiny}");
    }
    assert!(wrap_angle(f64::NAN).is_nan() && wrap_angle(f64::INFINITY).is_nan());
}
