//! What holds for every solve: order, symmetry, determinism, refusals.

#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not recognise as such

use dynamics::{InputBox, RelativeDynamics, UnicyclePair};
use reachability::{
    Axis, Convergence, Dissipation, Grid, Outcome, SolveError, SolverSettings, TimeIntegrator, TubeForm,
    UpwindScheme, disc_failure_function, memory_available_bytes, memory_needed_at_most_bytes, solve,
};
use std::f64::consts::PI;
use std::ops::ControlFlow;

fn pair() -> UnicyclePair {
    UnicyclePair {
        control: InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap(),
        disturbance: InputBox::new([-0.35], [0.35]).unwrap(),
    }
}

/// Odd node counts along y and even ones along θ put the mirror image of every node on a node.
fn grid() -> Grid<4> {
    Grid::new([
        Axis::bounded(-4.0, 4.0, 17),
        Axis::bounded(-4.0, 4.0, 17),
        Axis::periodic(-PI, PI, 12),
        Axis::bounded(0.0, 1.5, 4),
    ])
    .unwrap()
}

fn settings() -> SolverSettings {
    SolverSettings {
        upwind: UpwindScheme::Weno3,
        integrator: TimeIntegrator::TvdRk3,
        dissipation: Dissipation::OptimalPlay,
        tube: TubeForm::Variational,
        cfl: 0.75,
        max_horizon_s: 1.0,
        convergence: Convergence {
            check_interval_s: 0.5,
            unsafe_share_tolerance: 0.0,
            value_tolerance_m: None,
            boundary_layer: 0.0,
        },
    }
}

fn solved(settings: &SolverSettings) -> Vec<f32> {
    solve(&pair(), &disc_failure_function(0.7), &grid(), settings, &mut |_| ControlFlow::Continue(()))
        .unwrap()
        .values
}

#[test]
fn value_stays_below_the_failure_function_and_falls_with_the_horizon() {
    let failure = disc_failure_function(0.7);
    let grid = grid();
    let (short, long) = (solved(&SolverSettings { max_horizon_s: 0.5, ..settings() }), solved(&settings()));
    let freezing = solved(&SolverSettings { tube: TubeForm::Freezing, ..settings() });
    let frozen_short = solved(&SolverSettings { tube: TubeForm::Freezing, max_horizon_s: 0.5, ..settings() });
    for node in 0..grid.node_count() {
        let ceiling = failure(&grid.state(node)) as f32;
        assert!(long[node] <= ceiling && short[node] <= ceiling);
        // The stages' weights sum to one only up to rounding, step after step.
        assert!(freezing[node] <= ceiling + 1e-5);
        assert!(freezing[node] <= frozen_short[node] + 1e-5, "a frozen value never rises");
    }
    assert!(long.iter().zip(&short).any(|(long, short)| long + 0.3 < *short), "nothing happened");
}

#[test]
fn value_is_mirror_symmetric() {
    let (grid, values) = (grid(), solved(&settings()));
    let mut largest = 0.0_f32;
    for node in 0..grid.node_count() {
        let [x, y, theta, speed] = grid.index(node);
        let mirrored = grid.node(&[x, 16 - y, (12 - theta) % 12, speed]);
        largest = largest.max((values[node] - values[mirrored]).abs());
    }
    // Sums run in another order in the mirror image, so only rounding may differ.
    assert!(largest < 1e-4, "V(x,y,θ,v) and V(x,−y,−θ,v) differ by {largest} m");
}

#[test]
fn result_does_not_depend_on_the_number_of_threads() {
    let with = |threads: usize| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| solved(&settings()))
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn progress_can_stop_a_solve() {
    let mut calls = 0;
    let solution = solve(&pair(), &disc_failure_function(0.7), &grid(), &settings(), &mut |progress| {
        calls += 1;
        assert_eq!(progress.steps, calls);
        if calls == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })
    .unwrap();
    assert_eq!((solution.outcome, solution.steps), (Outcome::Interrupted, 3));
    assert!(solution.horizon_s > 0.0 && solution.horizon_s < 0.5);
}

#[test]
fn history_tells_every_check() {
    let solution =
        solve(&pair(), &disc_failure_function(0.7), &grid(), &settings(), &mut |_| ControlFlow::Continue(()))
            .unwrap();
    assert_eq!(solution.outcome, Outcome::HorizonReached);
    assert_eq!(solution.history.iter().map(|h| h.time_s).collect::<Vec<_>>(), [0.5, 1.0]);
    let below = solution.values.iter().filter(|v| **v < 0.0).count();
    assert_eq!(solution.history[1].unsafe_share, below as f64 / solution.values.len() as f64);
    assert!(solution.history.iter().all(|h| h.max_change_m > 0.1 && h.max_change_m < 2.0));
}

#[test]
fn bad_settings_dynamics_and_failure_functions_are_refused() {
    let attempt = |pair: UnicyclePair, radius_m: f64, settings: SolverSettings| {
        solve(&pair, &disc_failure_function(radius_m), &grid(), &settings, &mut |_| ControlFlow::Continue(()))
            .unwrap_err()
    };
    for bad in [0.0, 1.5, f64::NAN] {
        let error = attempt(pair(), 0.7, SolverSettings { cfl: bad, ..settings() });
        assert!(error.to_string().contains("`cfl`"), "{error}");
        let horizon = if bad == 1.5 { f64::INFINITY } else { bad };
        let error = attempt(pair(), 0.7, SolverSettings { max_horizon_s: horizon, ..settings() });
        assert!(error.to_string().contains("`max_horizon_s`"), "{error}");
    }
    assert_eq!(attempt(pair(), f64::NAN, settings()), SolveError::NonFiniteFailureFunction);
    // The fields of a box are public: the solver still must not hang on them.
    let mut broken = pair();
    broken.control.max[0] = f64::INFINITY;
    assert_eq!(attempt(broken, 0.7, settings()), SolveError::NonFiniteDynamics);
}

#[test]
fn a_grid_beyond_this_machines_memory_is_refused_before_it_is_allocated() {
    // 10¹⁴ nodes: petabytes.
    let vast =
        Grid::new([Axis::bounded(-4.0, 4.0, 10_000_000), Axis::bounded(-4.0, 4.0, 10_000_000)]).unwrap();
    let still = Still(InputBox::new([], []).unwrap());
    let failure = disc_failure_function(0.7);
    let error = solve(&still, &failure, &vast, &settings(), &mut |_| ControlFlow::Continue(())).unwrap_err();
    assert!(matches!(error, SolveError::Memory { needed_bytes: 4_000_000_000_000_000, .. }), "{error}");
    assert!(memory_available_bytes() > 0);
}

/// Nothing moves.
struct Still(InputBox<0>);

impl RelativeDynamics<2, 0, 0> for Still {
    fn drift(&self, _z: &[f64; 2]) -> [f64; 2] {
        [0.0; 2]
    }

    fn control_jacobian(&self, _z: &[f64; 2]) -> [[f64; 0]; 2] {
        [[]; 2]
    }

    fn disturbance_jacobian(&self, _z: &[f64; 2]) -> [[f64; 0]; 2] {
        [[]; 2]
    }

    fn control_box(&self) -> &InputBox<0> {
        &self.0
    }

    fn disturbance_box(&self) -> &InputBox<0> {
        &self.0
    }
}

#[test]
fn memory_is_stated_beforehand() {
    let paper = Grid::new([
        Axis::bounded(-6.0, 6.0, 80),
        Axis::bounded(-6.0, 6.0, 80),
        Axis::periodic(-PI, PI, 20),
        Axis::bounded(0.0, 1.5, 10),
    ])
    .unwrap();
    assert_eq!(memory_needed_at_most_bytes(&paper, 3), 1_280_000 * 4 * (6 + 4 * 5));
}
