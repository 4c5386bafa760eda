//! What every pair must satisfy, ready to be run on a pair of one's own.
//!
//! A sign or a swapped index in a Jacobian still gives a value function, only of another game. These checks find it before
//! hours are spent: they compare what the dynamics claim with differences and with brute force, on a few hundred states
//! that are the same in each run. Call them from a test; the first violation comes back with the numbers that show it.

use crate::{InputBox, RelativeDynamics, RobotObstaclePair, wrap_angle};
use std::f64::consts::PI;

/// States tried per property.
const STATES: usize = 500;
/// Step of differences, in units of the state or s.
const STEP: f64 = 1e-6;

/// A property that does not hold.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{property} does not hold: {detail}")]
pub struct Violation {
    /// What should hold.
    pub property: &'static str,
    /// Where it does not, with both numbers.
    pub detail: String,
}

/// Checks that Hamiltonian and optimal inputs are those of the game over the input boxes, by trying all corners.
///
/// States and costates are spread over `±scale` around zero, in the units of `z`.
///
/// # Errors
/// The first [`Violation`].
pub fn check_game<const NZ: usize, const NU: usize, const ND: usize>(
    dynamics: &impl RelativeDynamics<NZ, NU, ND>,
    scale: &[f64; NZ],
) -> Result<(), Violation> {
    let mut scatter = Scatter(7);
    let (u_box, d_box) = (dynamics.control_box(), dynamics.disturbance_box());
    for _ in 0..STATES {
        let (z, p) = (scatter.state(scale), scatter.vector(2.0));
        let rate = |u: &[f64; NU], d: &[f64; ND]| dot(&p, &dynamics.flow(&z, u, d));
        // An affine function over a box takes its extremes at corners.
        let mut best = f64::NEG_INFINITY;
        for a in 0..1 << NU {
            let mut worst = f64::INFINITY;
            for b in 0..1 << ND {
                worst = worst.min(rate(&corner(u_box, a), &corner(d_box, b)));
            }
            best = best.max(worst);
        }
        let tolerance = 1e-12 * (1.0 + best.abs());
        let hamiltonian = dynamics.hamiltonian(&z, &p);
        require("the Hamiltonian is the value of the game", (hamiltonian - best).abs() <= tolerance, || {
            format!("H = {hamiltonian}, all corners give {best}, at z = {z:?}, p = {p:?}")
        })?;
        let (u, d) = (dynamics.optimal_control(&z, &p), dynamics.optimal_disturbance(&z, &p));
        require("optimal inputs are admissible", u_box.contains(&u) && d_box.contains(&d), || {
            format!("u = {u:?}, d = {d:?}, at z = {z:?}, p = {p:?}")
        })?;
        let (any_u, any_d) = (scatter.inside(u_box), scatter.inside(d_box));
        require("no input beats the optimal ones", rate(&any_u, &d) <= best + tolerance, || {
            format!("u = {any_u:?} gives {} above {best}, at z = {z:?}", rate(&any_u, &d))
        })?;
        require("no input beats the optimal ones", rate(&u, &any_d) >= best - tolerance, || {
            format!("d = {any_d:?} gives {} below {best}, at z = {z:?}", rate(&u, &any_d))
        })?;
    }
    Ok(())
}

/// Checks drift and Jacobians against the motion itself.
///
/// `moved(z, u, d, t)` is where the relative state is after `t` seconds (or was, for negative `t`) under constant inputs,
/// found independently of the dynamics, for instance by moving robot and obstacle in the world and looking from one to the
/// other. It has to be right to second order in `t`.
///
/// # Errors
/// The first [`Violation`].
pub fn check_motion<const NZ: usize, const NU: usize, const ND: usize>(
    dynamics: &impl RelativeDynamics<NZ, NU, ND>,
    scale: &[f64; NZ],
    moved: impl Fn(&[f64; NZ], &[f64; NU], &[f64; ND], f64) -> [f64; NZ],
) -> Result<(), Violation> {
    let mut scatter = Scatter(5);
    for _ in 0..STATES {
        let z = scatter.state(scale);
        let (u, d) = (scatter.inside(dynamics.control_box()), scatter.inside(dynamics.disturbance_box()));
        let flow = dynamics.flow(&z, &u, &d);
        let (after, before) = (moved(&z, &u, &d, STEP), moved(&z, &u, &d, -STEP));
        for i in 0..NZ {
            let difference = difference(after[i], before[i]);
            require("the dynamics are the motion's", (flow[i] - difference).abs() < 1e-7, || {
                format!(
                    "rate {i} is {}, the motion's {difference}, at z = {z:?}, u = {u:?}, d = {d:?}",
                    flow[i]
                )
            })?;
        }
    }
    Ok(())
}

/// Checks that the game looks the same in a mirror: `H(Sz, Sp) = H(z, p)` for `S` the diagonal of `signs`.
///
/// It holds where turning left is as good as turning right, and then the value function has the same symmetry.
///
/// # Errors
/// The first [`Violation`].
pub fn check_mirror_symmetry<const NZ: usize, const NU: usize, const ND: usize>(
    dynamics: &impl RelativeDynamics<NZ, NU, ND>,
    scale: &[f64; NZ],
    signs: &[f64; NZ],
) -> Result<(), Violation> {
    let mut scatter = Scatter(3);
    let mirrored = |v: &[f64; NZ]| std::array::from_fn(|i| signs[i] * v[i]);
    for _ in 0..STATES {
        let (z, p) = (scatter.state(scale), scatter.vector(2.0));
        let (here, there) =
            (dynamics.hamiltonian(&z, &p), dynamics.hamiltonian(&mirrored(&z), &mirrored(&p)));
        require(
            "the game is its own mirror image",
            (here - there).abs() <= 1e-12 * (1.0 + here.abs()),
            || format!("H = {here}, mirrored {there}, at z = {z:?}, p = {p:?}"),
        )?;
    }
    Ok(())
}

/// Checks the online half of a pair: the Jacobians of `ρ(x, o)` against differences, and `ρ` against the relative dynamics.
///
/// `obstacle_rate(o, d)` is how the obstacle's state moves.
///
/// # Errors
/// The first [`Violation`].
pub fn check_relative_state<const NX: usize, const ND: usize>(
    pair: &(impl RelativeDynamics<4, 2, ND> + RobotObstaclePair<NX>),
    obstacle_rate: impl Fn(&[f64; 4], &[f64; ND]) -> [f64; 4],
) -> Result<(), Violation> {
    let mut scatter = Scatter(11);
    for _ in 0..STATES {
        let (x, o): ([f64; NX], [f64; 4]) = (scatter.vector(3.0), scatter.vector(3.0));
        let (frame, z) = (pair.robot_frame(&x), pair.relative_state(&x, &o));
        let by_robot = pair.relative_state_by_robot(&frame, &z);
        let by_obstacle = pair.relative_state_by_obstacle(&frame, &z);
        for k in 0..NX {
            let at = |step: f64| pair.relative_state(&nudged(&x, k, step), &o);
            compare_column("∂z/∂x is the derivative of ρ", &at, |i| by_robot[i][k], k)?;
        }
        for k in 0..4 {
            let at = |step: f64| pair.relative_state(&x, &nudged(&o, k, step));
            compare_column("∂z/∂o is the derivative of ρ", &at, |i| by_obstacle[i][k], k)?;
        }
        let (u, d) = (scatter.inside(pair.control_box()), scatter.inside(pair.disturbance_box()));
        let (f, g) = (pair.robot_drift(&x), pair.robot_control_jacobian(&x));
        let o_rate = obstacle_rate(&o, &d);
        let flow = pair.flow(&z, &u, &d);
        for i in 0..4 {
            let of_robot: f64 =
                (0..NX).map(|k| by_robot[i][k] * (f[k] + g[k][0] * u[0] + g[k][1] * u[1])).sum();
            let rate = of_robot + dot(&by_obstacle[i], &o_rate);
            require("ż follows from ẋ and ȯ", (rate - flow[i]).abs() < 1e-12, || {
                format!(
                    "rate {i} is {} in the relative dynamics, {rate} by the chain rule, at x = {x:?}, o = {o:?}",
                    flow[i]
                )
            })?;
        }
    }
    Ok(())
}

fn compare_column(
    property: &'static str,
    at: &impl Fn(f64) -> [f64; 4],
    claimed: impl Fn(usize) -> f64,
    k: usize,
) -> Result<(), Violation> {
    let (after, before) = (at(STEP), at(-STEP));
    for i in 0..4 {
        let difference = difference(after[i], before[i]);
        require(property, (claimed(i) - difference).abs() < 1e-7, || {
            format!("entry ({i}, {k}) is {}, the difference quotient {difference}", claimed(i))
        })?;
    }
    Ok(())
}

fn require(property: &'static str, holds: bool, detail: impl FnOnce() -> String) -> Result<(), Violation> {
    if holds { Ok(()) } else { Err(Violation { property, detail: detail() }) }
}

/// Central difference quotient; across the seam of an angle the short way round is meant.
fn difference(after: f64, before: f64) -> f64 {
    let raw = after - before;
    (if raw.abs() > PI { wrap_angle(raw) } else { raw }) / (2.0 * STEP)
}

fn nudged<const N: usize>(v: &[f64; N], k: usize, step: f64) -> [f64; N] {
    std::array::from_fn(|i| if i == k { v[i] + step } else { v[i] })
}

fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    (0..N).map(|i| a[i] * b[i]).sum()
}

fn corner<const N: usize>(bounds: &InputBox<N>, bits: usize) -> [f64; N] {
    std::array::from_fn(|j| if bits >> j & 1 == 1 { bounds.max[j] } else { bounds.min[j] })
}

/// Deterministic numbers in `[-1, 1)`, enough to scatter states (a linear congruential generator after Knuth).
struct Scatter(u64);

impl Scatter {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn vector<const N: usize>(&mut self, scale: f64) -> [f64; N] {
        std::array::from_fn(|_| scale * self.next())
    }

    fn state<const N: usize>(&mut self, scale: &[f64; N]) -> [f64; N] {
        std::array::from_fn(|i| scale[i] * self.next())
    }

    fn inside<const N: usize>(&mut self, bounds: &InputBox<N>) -> [f64; N] {
        std::array::from_fn(|j| bounds.min[j] + 0.5 * (1.0 + self.next()) * (bounds.max[j] - bounds.min[j]))
    }
}
