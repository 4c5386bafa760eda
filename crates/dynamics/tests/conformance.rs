//! The conformance suite run on every pair of this crate, and on pairs that it must refuse.

#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not recognise as such

use dynamics::conformance::{check_game, check_mirror_symmetry, check_motion, check_relative_state};
use dynamics::{
    DoubleIntegratorPair, InputBox, RelativeDynamics, RobotObstaclePair, UnicyclePair, UnicycleStaticPair,
    wrap_angle,
};
use std::f64::consts::{PI, TAU};

const SCALE: [f64; 4] = [4.0, 4.0, 3.0, 1.5];
const LEFT_IS_RIGHT: [f64; 4] = [1.0, -1.0, -1.0, 1.0];

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

fn unicycle_static() -> UnicycleStaticPair {
    UnicycleStaticPair { control: unicycle().control }
}

/// Moves a unicycle by the midpoint rule, right to second order.
fn drive(pose: [f64; 3], speed_mps: f64, yaw_rate_radps: f64, time_s: f64) -> [f64; 3] {
    let heading = pose[2] + 0.5 * yaw_rate_radps * time_s;
    [
        pose[0] + speed_mps * time_s * heading.cos(),
        pose[1] + speed_mps * time_s * heading.sin(),
        pose[2] + yaw_rate_radps * time_s,
    ]
}

#[test]
fn hamiltonians_match_brute_force_over_the_boxes() {
    check_game(&unicycle(), &SCALE).unwrap();
    check_game(&double_integrator(), &SCALE).unwrap();
    check_game(&unicycle_static(), &SCALE).unwrap();
}

#[test]
fn relative_dynamics_are_the_motion_of_robot_and_obstacle() {
    // The robot starts at the origin, so that the obstacle's state in odom is the relative one.
    check_motion(&unicycle(), &SCALE, |z, u, d, t| {
        let [x, y, heading] = drive([z[0], z[1], z[2]], z[3], d[0], t);
        unicycle().relative_state(&drive([0.0; 3], u[0], u[1], t), &[x, y, heading, z[3]])
    })
    .unwrap();
    check_motion(&unicycle_static(), &SCALE, |z, u, _, t| {
        let seen = unicycle_static().relative_state(&drive([0.0; 3], u[0], u[1], t), &[z[0], z[1], 0.3, 0.0]);
        [seen[0], seen[1], z[2], z[3]]
    })
    .unwrap();
    check_motion(&double_integrator(), &SCALE, |z, u, d, t| {
        let along = |k: usize| {
            let a = d[k] - u[k];
            (z[k] + t * z[k + 2] + 0.5 * t * t * a, z[k + 2] + t * a)
        };
        let ((x, vx), (y, vy)) = (along(0), along(1));
        [x, y, vx, vy]
    })
    .unwrap();
}

#[test]
fn relative_states_follow_from_robot_and_obstacle() {
    check_relative_state(&unicycle(), |o, d| [o[3] * o[2].cos(), o[3] * o[2].sin(), d[0], 0.0]).unwrap();
    check_relative_state(&double_integrator(), |o, d| [o[2], o[3], d[0], d[1]]).unwrap();
    check_relative_state(&unicycle_static(), |_, _: &[f64; 0]| [0.0; 4]).unwrap();
}

#[test]
fn games_are_their_own_mirror_images() {
    check_mirror_symmetry(&unicycle(), &SCALE, &LEFT_IS_RIGHT).unwrap();
    check_mirror_symmetry(&unicycle_static(), &SCALE, &LEFT_IS_RIGHT).unwrap();
    check_mirror_symmetry(&double_integrator(), &SCALE, &[-1.0, 1.0, -1.0, 1.0]).unwrap();
    check_mirror_symmetry(&double_integrator(), &SCALE, &[1.0, -1.0, 1.0, -1.0]).unwrap();
    let mut turns_left_only = unicycle();
    turns_left_only.control.min[1] = 0.0;
    let violation = check_mirror_symmetry(&turns_left_only, &SCALE, &LEFT_IS_RIGHT).unwrap_err();
    assert!(violation.to_string().contains("mirror"), "{violation}");
}

/// The unicycle with one mistake.
struct Mistaken {
    pair: UnicyclePair,
    mistake: Mistake,
}

#[derive(Clone, Copy, PartialEq)]
enum Mistake {
    TurnMovesTheWrongWay,
    DriftForgetsTheSine,
    ControlSeeksTheObstacle,
    HamiltonianForgetsTheDisturbance,
}

impl RelativeDynamics<4, 2, 1> for Mistaken {
    fn drift(&self, z: &[f64; 4]) -> [f64; 4] {
        let mut drift = self.pair.drift(z);
        if self.mistake == Mistake::DriftForgetsTheSine {
            drift[1] = 0.0;
        }
        drift
    }

    fn control_jacobian(&self, z: &[f64; 4]) -> [[f64; 2]; 4] {
        let mut jacobian = self.pair.control_jacobian(z);
        if self.mistake == Mistake::TurnMovesTheWrongWay {
            jacobian[1][1] = z[0];
        }
        jacobian
    }

    fn disturbance_jacobian(&self, z: &[f64; 4]) -> [[f64; 1]; 4] {
        self.pair.disturbance_jacobian(z)
    }

    fn control_box(&self) -> &InputBox<2> {
        self.pair.control_box()
    }

    fn disturbance_box(&self) -> &InputBox<1> {
        self.pair.disturbance_box()
    }

    fn optimal_control(&self, z: &[f64; 4], p: &[f64; 4]) -> [f64; 2] {
        let p = if self.mistake == Mistake::ControlSeeksTheObstacle { p.map(|x| -x) } else { *p };
        self.pair.optimal_control(z, &p)
    }

    fn hamiltonian(&self, z: &[f64; 4], p: &[f64; 4]) -> f64 {
        let d = match self.mistake {
            Mistake::HamiltonianForgetsTheDisturbance => [0.0],
            _ => self.optimal_disturbance(z, p),
        };
        let flow = self.flow(z, &self.optimal_control(z, p), &d);
        (0..4).map(|i| p[i] * flow[i]).sum()
    }
}

#[test]
fn mistakes_are_found() {
    let moved = |z: &[f64; 4], u: &[f64; 2], d: &[f64; 1], t: f64| {
        let [x, y, heading] = drive([z[0], z[1], z[2]], z[3], d[0], t);
        unicycle().relative_state(&drive([0.0; 3], u[0], u[1], t), &[x, y, heading, z[3]])
    };
    for mistake in [Mistake::TurnMovesTheWrongWay, Mistake::DriftForgetsTheSine] {
        let violation = check_motion(&Mistaken { pair: unicycle(), mistake }, &SCALE, moved).unwrap_err();
        assert!(violation.detail.starts_with("rate 1"), "{violation}");
    }
    for mistake in [Mistake::ControlSeeksTheObstacle, Mistake::HamiltonianForgetsTheDisturbance] {
        assert!(check_game(&Mistaken { pair: unicycle(), mistake }, &SCALE).is_err());
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
