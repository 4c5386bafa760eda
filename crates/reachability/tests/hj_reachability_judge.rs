//! The same game solved by hj_reachability 0.7.0 (JAX), another group's implementation.
//!
//! The stored values come from `tests/judges/hj_reachability_reference.py`. Scheme, dissipation and step size are
//! the same, so the two differ by f32 rounding only, which the weights of the WENO schemes amplify where the
//! value function has kinks.

#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not recognise as such

use dynamics::{InputBox, UnicyclePair};
use reachability::{
    Axis, Convergence, Dissipation, Grid, SolverSettings, TimeIntegrator, TubeForm, UpwindScheme,
    disc_failure_function, solve,
};
use safetensors::SafeTensors;
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::path::Path;

/// Every second node along x and y is stored.
const STRIDE: usize = 2;

/// Solves the judge's problem and returns the largest and the mean distance to its values, m.
fn distance_to_judge(
    name: &str,
    upwind: UpwindScheme,
    integrator: TimeIntegrator,
    tube: TubeForm,
) -> (f64, f64) {
    let pair = UnicyclePair {
        control: InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap(),
        disturbance: InputBox::new([-0.35], [0.35]).unwrap(),
    };
    let grid = Grid::new([
        Axis::bounded(-6.0, 6.0, 31),
        Axis::bounded(-6.0, 6.0, 31),
        Axis::periodic(-PI, PI, 16),
        Axis::bounded(0.0, 1.5, 5),
    ])
    .unwrap();
    let settings = SolverSettings {
        upwind,
        integrator,
        dissipation: Dissipation::BoxMagnitude,
        tube,
        cfl: 0.75,
        max_horizon_s: 2.0,
        convergence: Convergence {
            check_interval_s: 2.0,
            unsafe_share_tolerance: 0.0,
            value_tolerance_m: None,
            boundary_layer: 0.0,
        },
    };
    let solution =
        solve(&pair, &disc_failure_function(0.7), &grid, &settings, &mut |_| ControlFlow::Continue(()))
            .unwrap();

    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/hj_unicycle_reference.safetensors");
    let bytes = std::fs::read(path).unwrap();
    let file = SafeTensors::deserialize(&bytes).unwrap();
    let tensor = file.tensor(name).unwrap();
    assert_eq!(tensor.shape(), [16, 16, 16, 5]);
    let mut stored = tensor.data().as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b));
    let (mut largest, mut sum, mut compared) = (0.0_f64, 0.0, 0_u32);
    for (node, &value) in solution.values.iter().enumerate() {
        let index = grid.index(node);
        if index[0] % STRIDE == 0 && index[1] % STRIDE == 0 {
            let difference = f64::from((value - stored.next().unwrap()).abs());
            largest = largest.max(difference);
            sum += difference;
            compared += 1;
        }
    }
    assert!(stored.next().is_none());
    let mean = sum / f64::from(compared);
    println!("{name}: largest difference {largest:.2e} m, mean {mean:.2e} m");
    (largest, mean)
}

#[test]
fn first_order_agrees() {
    let (largest, mean) = distance_to_judge(
        "first_order_euler",
        UpwindScheme::FirstOrder,
        TimeIntegrator::Euler,
        TubeForm::Variational,
    );
    // Measured 5e-6 and 5e-7.
    assert!(largest < 1e-5 && mean < 1e-6);
}

#[test]
fn eno2_agrees() {
    let (largest, mean) =
        distance_to_judge("eno2_rk2", UpwindScheme::Eno2, TimeIntegrator::TvdRk2, TubeForm::Variational);
    // Measured 8e-4 and 2e-6: where two candidates are equally smooth, rounding decides between them.
    assert!(largest < 2e-3 && mean < 3e-6);
}

#[test]
fn weno3_agrees() {
    let (largest, mean) =
        distance_to_judge("weno3_rk3", UpwindScheme::Weno3, TimeIntegrator::TvdRk3, TubeForm::Variational);
    // Measured 3e-5 and 1e-6.
    assert!(largest < 1e-4 && mean < 3e-6);
}

#[test]
fn weno5_agrees() {
    let (largest, mean) =
        distance_to_judge("weno5_rk3", UpwindScheme::Weno5, TimeIntegrator::TvdRk3, TubeForm::Variational);
    // Measured 5e-5 and 1e-6.
    assert!(largest < 1e-4 && mean < 3e-6);
}

#[test]
fn weno3_with_freezing_agrees() {
    let (largest, mean) = distance_to_judge(
        "weno3_rk3_freezing",
        UpwindScheme::Weno3,
        TimeIntegrator::TvdRk3,
        TubeForm::Freezing,
    );
    // Measured 2e-4 and 1e-6: where Ĥ is nearly zero, rounding decides whether a node is frozen.
    assert!(largest < 1e-3 && mean < 3e-6);
}
