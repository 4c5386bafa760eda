//! One evaluation of the numerical Hamiltonian and its update on the paper's grids, per scheme, on all cores.
//!
//! `cargo bench -p reachability --bench stage`; items are nodes.

#![allow(clippy::unwrap_used)] // a benchmark's set-up

use divan::Bencher;
use divan::counter::ItemsCount;
use dynamics::{DoubleIntegratorPair, InputBox, RelativeDynamics, UnicyclePair};
use reachability::{
    Axis, Convergence, Dissipation, Grid, SolverSettings, Stepper, TimeIntegrator, TubeForm, UpwindScheme,
    disc_failure_function,
};
use std::f64::consts::PI;

const SCHEMES: [UpwindScheme; 4] =
    [UpwindScheme::FirstOrder, UpwindScheme::Eno2, UpwindScheme::Weno3, UpwindScheme::Weno5];

fn main() {
    divan::main();
}

fn stage<const NU: usize, const ND: usize>(
    bencher: Bencher<'_, '_>,
    dynamics: &impl RelativeDynamics<4, NU, ND>,
    grid: &Grid<4>,
    upwind: UpwindScheme,
) {
    let settings = SolverSettings {
        upwind,
        integrator: TimeIntegrator::Euler,
        dissipation: Dissipation::OptimalPlay,
        tube: TubeForm::Variational,
        cfl: 0.75,
        max_horizon_s: 1.0,
        convergence: Convergence {
            check_interval_s: 1.0,
            unsafe_share_tolerance: 0.0,
            value_tolerance_m: None,
            boundary_layer: 0.0,
        },
    };
    let mut stepper = Stepper::new(dynamics, grid, &settings).unwrap();
    let failure = disc_failure_function(0.7);
    let ceiling: Vec<f32> = (0..grid.node_count()).map(|node| failure(&grid.state(node)) as f32).collect();
    let mut values = ceiling.clone();
    let step_s = stepper.longest_step_s();
    bencher
        .counter(ItemsCount::new(grid.node_count()))
        .bench_local(|| stepper.step(&mut values, step_s, Some(&ceiling)));
}

#[divan::bench(args = SCHEMES, sample_count = 20)]
fn ground_robot(bencher: Bencher<'_, '_>, upwind: UpwindScheme) {
    let pair = UnicyclePair {
        control: InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap(),
        disturbance: InputBox::new([-0.35], [0.35]).unwrap(),
    };
    let grid = Grid::new([
        Axis::bounded(-6.0, 6.0, 80),
        Axis::bounded(-6.0, 6.0, 80),
        Axis::periodic(-PI, PI, 20),
        Axis::bounded(0.0, 1.5, 10),
    ])
    .unwrap();
    stage(bencher, &pair, &grid, upwind);
}

#[divan::bench(args = SCHEMES, sample_count = 20)]
fn quadrotor(bencher: Bencher<'_, '_>, upwind: UpwindScheme) {
    let pair = DoubleIntegratorPair {
        control: InputBox::new([-2.0; 2], [2.0; 2]).unwrap(),
        disturbance: InputBox::new([-1.0; 2], [1.0; 2]).unwrap(),
    };
    let half = [4.0, 4.0, 3.5, 3.5];
    let count = [80, 80, 20, 20];
    let grid = Grid::new(std::array::from_fn(|d| Axis::bounded(-half[d], half[d], count[d]))).unwrap();
    stage(bencher, &pair, &grid, upwind);
}
