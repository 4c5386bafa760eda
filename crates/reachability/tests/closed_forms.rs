//! Games with a known value function.

#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not recognise as such

use dynamics::{DoubleIntegratorPair, InputBox, RelativeDynamics};
use reachability::{
    Axis, Convergence, Dissipation, Grid, Outcome, Solution, SolverSettings, TimeIntegrator, TubeForm,
    UpwindScheme, disc_failure_function, solve,
};
use std::ops::ControlFlow;

fn settings(max_horizon_s: f64) -> SolverSettings {
    SolverSettings {
        upwind: UpwindScheme::Weno3,
        integrator: TimeIntegrator::TvdRk3,
        dissipation: Dissipation::OptimalPlay,
        tube: TubeForm::Variational,
        cfl: 0.75,
        max_horizon_s,
        convergence: Convergence {
            check_interval_s: 0.5,
            unsafe_share_tolerance: 0.0,
            value_tolerance_m: None,
            boundary_layer: 0.08,
        },
    }
}

/// Both players move as they like along each axis, the pursuer faster by `lead_mps`.
struct SimpleMotion<const N: usize> {
    control: InputBox<N>,
    disturbance: InputBox<N>,
}

impl<const N: usize> SimpleMotion<N> {
    fn with_lead(lead_mps: f64) -> Self {
        let d = 1.0 + lead_mps;
        Self {
            control: InputBox::new([-1.0; N], [1.0; N]).unwrap(),
            disturbance: InputBox::new([-d; N], [d; N]).unwrap(),
        }
    }
}

impl<const N: usize> RelativeDynamics<N, N, N> for SimpleMotion<N> {
    fn drift(&self, _z: &[f64; N]) -> [f64; N] {
        [0.0; N]
    }

    fn control_jacobian(&self, _z: &[f64; N]) -> [[f64; N]; N] {
        std::array::from_fn(|i| std::array::from_fn(|j| if i == j { -1.0 } else { 0.0 }))
    }

    fn disturbance_jacobian(&self, _z: &[f64; N]) -> [[f64; N]; N] {
        std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }))
    }

    fn control_box(&self) -> &InputBox<N> {
        &self.control
    }

    fn disturbance_box(&self) -> &InputBox<N> {
        &self.disturbance
    }
}

fn cube<const N: usize>(nodes: usize) -> Grid<N> {
    Grid::new(std::array::from_fn(|_| Axis::bounded(-2.0, 2.0, nodes))).unwrap()
}

fn solved<const N: usize>(game: &SimpleMotion<N>, nodes: usize, horizon_s: f64) -> Solution<N> {
    let failure = |z: &[f64; N]| z.iter().map(|x| x * x).sum::<f64>().sqrt() - 0.5;
    solve(game, &failure, &cube(nodes), &settings(horizon_s), &mut |_| ControlFlow::Continue(())).unwrap()
}

/// Largest error over the nodes at least `away` from the centre, where the closed form is smooth.
///
/// A pursuer faster by `lead` per axis takes `lead · T` off every coordinate: `V = |(|z_i| − lead T)⁺| − R`.
fn largest_error<const N: usize>(solution: &Solution<N>, gain: f64) -> f64 {
    let mut largest = 0.0_f64;
    for (node, &value) in solution.values.iter().enumerate() {
        let z = solution.grid.state(node);
        let exact = z.iter().map(|x| (x.abs() - gain).max(0.0).powi(2)).sum::<f64>().sqrt() - 0.5;
        if z.iter().all(|x| (x.abs() - gain).abs() > 0.3 && x.abs() < 1.8) {
            largest = largest.max((f64::from(value) - exact).abs());
        }
    }
    largest
}

#[test]
fn a_faster_pursuer_gains_its_lead_in_two_dimensions() {
    let (coarse, fine) = (
        solved(&SimpleMotion::<2>::with_lead(0.5), 41, 1.0),
        solved(&SimpleMotion::<2>::with_lead(0.5), 81, 1.0),
    );
    let (coarse, fine) = (largest_error(&coarse, 0.5), largest_error(&fine, 0.5));
    println!("2-D: {coarse:.4} m at 41 nodes, {fine:.4} m at 81");
    // Half a cell at most, and falling faster than the spacing.
    assert!(coarse < 0.05 && fine < 0.025 && fine < coarse / 3.0);
}

#[test]
fn a_faster_pursuer_gains_its_lead_in_three_dimensions() {
    let solution = solved(&SimpleMotion::<3>::with_lead(0.5), 41, 1.0);
    let error = largest_error(&solution, 0.5);
    println!("3-D: {error:.4} m at 41 nodes");
    assert!(error < 0.05, "half a cell");
}

#[test]
fn a_slower_pursuer_gains_nothing_and_the_solve_converges() {
    let game = SimpleMotion::<2>::with_lead(-0.5);
    let failure = |z: &[f64; 2]| z[0].hypot(z[1]) - 0.5;
    let mut settings = settings(5.0);
    settings.convergence.unsafe_share_tolerance = 1e-9;
    settings.convergence.value_tolerance_m = Some(1e-3);
    let solution = solve(&game, &failure, &cube(41), &settings, &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(solution.outcome, Outcome::Converged);
    assert_eq!(solution.horizon_s, 0.5, "the first check already sees that nothing moves");
    for (node, &value) in solution.values.iter().enumerate() {
        let exact = failure(&solution.grid.state(node));
        // Dissipation blunts the tip of the cone, where the value can only be lower.
        assert!((f64::from(value) - exact).abs() < 0.06, "{value} at {:?}", solution.grid.state(node));
    }
}

/// The quadrotor pair: `V(p, v) = max_{a ∈ [−1,1]²} min_{0 ≤ t ≤ T} |p + v t + a t²/2| − R`.
///
/// Robot ±2 m/s² against obstacle ±1 m/s² leaves a net ±1 m/s² per axis, and an optimal evasion keeps one
/// constant acceleration until the closest approach. The maximum over a grid of accelerations is within a
/// centimetre of it.
fn quadrotor_closed_form(z: &[f64; 4], horizon_s: f64, radius_m: f64) -> f64 {
    let mut best = f64::NEG_INFINITY;
    for i in 0..17 {
        for j in 0..17 {
            let a = [f64::from(i) / 8.0 - 1.0, f64::from(j) / 8.0 - 1.0];
            let mut closest = f64::INFINITY;
            for k in 0..=80 {
                let t = horizon_s * f64::from(k) / 80.0;
                let x = z[0] + z[2] * t + 0.5 * a[0] * t * t;
                let y = z[1] + z[3] * t + 0.5 * a[1] * t * t;
                closest = closest.min(x * x + y * y);
                if closest <= best {
                    break;
                }
            }
            best = best.max(closest);
        }
    }
    best.sqrt() - radius_m
}

/// Mean and largest error on a sample of interior nodes, m.
fn quadrotor_error() -> (f64, f64) {
    let (radius_m, horizon_s) = (0.7, 1.5);
    let pair = DoubleIntegratorPair {
        control: InputBox::new([-2.0; 2], [2.0; 2]).unwrap(),
        disturbance: InputBox::new([-1.0; 2], [1.0; 2]).unwrap(),
    };
    let grid = Grid::new([
        Axis::bounded(-4.0, 4.0, 41),
        Axis::bounded(-4.0, 4.0, 41),
        Axis::bounded(-3.5, 3.5, 15),
        Axis::bounded(-3.5, 3.5, 15),
    ])
    .unwrap();
    let settings = settings(horizon_s);
    let failure = disc_failure_function(radius_m);
    let solution = solve(&pair, &failure, &grid, &settings, &mut |_| ControlFlow::Continue(())).unwrap();
    let (mut sum, mut largest, mut compared) = (0.0, 0.0_f64, 0_u32);
    // A prime stride scatters the sample over the whole grid; edges feel the extrapolation.
    for node in (0..grid.node_count()).step_by(101) {
        let z = grid.state(node);
        if z[0].abs() < 3.0 && z[1].abs() < 3.0 && z[2].abs() < 2.6 && z[3].abs() < 2.6 {
            let exact = quadrotor_closed_form(&z, horizon_s, radius_m);
            let error = (f64::from(solution.values[node]) - exact).abs();
            sum += error;
            largest = largest.max(error);
            compared += 1;
        }
    }
    assert!(compared > 1000);
    let mean = sum / f64::from(compared);
    println!("quadrotor: mean {mean:.4} m, largest {largest:.4} m over {compared} nodes");
    (mean, largest)
}

#[test]
fn quadrotor_pair_matches_its_closed_form() {
    let (mean, largest) = quadrotor_error();
    // Measured 0.0063 m and 0.134 m, the latter on the ridge where two evasions are equally good. Dissipation that does
    // not know that robot and obstacle accelerate against each other gives 0.0145 m and 0.21 m.
    assert!(mean < 0.008 && largest < 0.16);
}
