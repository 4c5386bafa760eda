//! The closed form of the double-integrator pair against brute force, differences and our own grid.

#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not recognise as such

use dynamics::{DoubleIntegratorPair, InputBox};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use reachability::closed_form::{ClosedFormError, DoubleIntegratorValue};
use reachability::{
    Axis, Convergence, Dissipation, Grid, SolverSettings, TimeIntegrator, TubeForm, UpwindScheme,
    disc_failure_function, solve,
};
use std::ops::ControlFlow;

const RADIUS_M: f64 = 0.7;

fn boxed(half: [f64; 2]) -> InputBox<2> {
    InputBox::new(half.map(|x| -x), half).unwrap()
}

fn quadrotor() -> DoubleIntegratorValue {
    DoubleIntegratorValue::new(&boxed([2.0; 2]), &boxed([1.0; 2]), RADIUS_M).unwrap()
}

/// States spread over the paper's domain.
fn states(count: usize, seed: u64) -> impl Iterator<Item = [f64; 4]> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    (0..count).map(move |_| std::array::from_fn(|i| [4.0, 4.0, 3.5, 3.5][i] * random.random_range(-1.0..1.0)))
}

/// Best over a grid of constant accelerations of the smallest distance over a grid of times, both fine.
fn brute_force_m(z: &[f64; 4], min: [f64; 2], max: [f64; 2]) -> f64 {
    let mut best = 0.0_f64;
    for i in 0..33 {
        for j in 0..33 {
            let a = [
                min[0] + f64::from(i) / 32.0 * (max[0] - min[0]),
                min[1] + f64::from(j) / 32.0 * (max[1] - min[1]),
            ];
            let mut closest = f64::INFINITY;
            // Ten seconds: by then any of these accelerations has turned the motion around and away.
            for k in 0..=1000 {
                let t = 0.01 * f64::from(k);
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
    best.sqrt() - RADIUS_M
}

#[test]
fn no_constant_acceleration_is_better_and_one_is_as_good() {
    let value = quadrotor();
    let (mut above, mut below) = (0.0_f64, 0.0_f64);
    for z in states(300, 11) {
        let difference = value.value_m(&z) - brute_force_m(&z, [-1.0; 2], [1.0; 2]);
        above = above.max(difference);
        below = below.max(-difference);
    }
    println!("closed form above brute force by at most {above:.4} m, below by at most {below:.5} m");
    // The grid of times misses the closest approach by up to 5 ms, which flatters brute force; the grid of accelerations
    // may miss the best by a step of 1/16 m/s². Measured 0.0000 m and 0.0005 m.
    assert!(below < 1e-3, "brute force found a better acceleration: {below}");
    assert!(above < 2e-3, "promises more than any acceleration keeps: {above}");
}

#[test]
fn boxes_need_not_be_symmetric() {
    let control = InputBox::new([-2.0, -1.5], [1.5, 2.5]).unwrap();
    let disturbance = InputBox::new([-0.5, -1.0], [0.4, 0.3]).unwrap();
    let value = DoubleIntegratorValue::new(&control, &disturbance, RADIUS_M).unwrap();
    let mut largest = 0.0_f64;
    for z in states(60, 12) {
        let brute = brute_force_m(&z, [0.4 - 1.5, 0.3 - 2.5], [-0.5 + 2.0, -1.0 + 1.5]);
        largest = largest.max((value.value_m(&z) - brute).abs());
    }
    println!("unequal boxes: {largest:.4} m");
    assert!(largest < 2e-3, "{largest}");
}

#[test]
fn gradient_matches_differences_away_from_kinks() {
    let value = quadrotor();
    let step = 1e-5;
    let (mut compared, mut kinks) = (0, 0);
    for z in states(20_000, 13) {
        let (here, gradient) = value.value_and_gradient(&z);
        assert_eq!(here, value.value_m(&z));
        let mut one_sided = [[0.0; 2]; 4];
        for i in 0..4 {
            for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
                let mut moved = z;
                moved[i] += sign * step;
                one_sided[i][side] = sign * (value.value_m(&moved) - here) / step;
            }
        }
        // A kink within a step shows as two sides that disagree.
        if one_sided.iter().any(|[up, down]| (up - down).abs() > 1e-2) {
            kinks += 1;
            continue;
        }
        compared += 1;
        for i in 0..4 {
            let difference = 0.5 * (one_sided[i][0] + one_sided[i][1]);
            assert!(
                (gradient[i] - difference).abs() < 1e-2,
                "{z:?}, component {i}: {gradient:?}, {one_sided:?}"
            );
        }
    }
    println!("{compared} gradients compared, {kinks} at kinks");
    assert!(kinks < 200);
}

#[test]
fn known_cases() {
    let value = quadrotor();
    assert!((value.value_m(&[2.0, 0.0, 1.0, 0.0]) - 1.3).abs() < 1e-12, "moving away");
    let (v, gradient) = value.value_and_gradient(&[3.0, 4.0, 0.0, 0.0]);
    assert!((v - 4.3).abs() < 1e-12);
    assert!((gradient[0] - 0.6).abs() < 1e-12 && (gradient[1] - 0.8).abs() < 1e-12 && gradient[2] == 0.0);
    assert!(value.value_m(&[f64::NAN, 0.0, 0.0, 0.0]).is_nan());
    assert!(value.value_m(&[0.0; 4]) >= -RADIUS_M);
}

#[test]
fn a_stronger_obstacle_is_refused() {
    let error = DoubleIntegratorValue::new(&boxed([2.0, 1.0]), &boxed([1.0, 1.5]), RADIUS_M).unwrap_err();
    assert!(matches!(error, ClosedFormError::StrongerObstacle { axis: 1, .. }), "{error}");
    let error = DoubleIntegratorValue::new(&boxed([2.0; 2]), &boxed([1.0; 2]), f64::NAN).unwrap_err();
    assert!(matches!(error, ClosedFormError::Radius { .. }));
    let equal = DoubleIntegratorValue::new(&boxed([1.0; 2]), &boxed([1.0; 2]), RADIUS_M).unwrap();
    assert!((equal.value_m(&[3.0, 0.5, -1.0, 0.0]) - (0.5 - RADIUS_M)).abs() < 1e-12, "straight past");
}

#[test]
fn agrees_with_the_grid() {
    let pair = DoubleIntegratorPair { control: boxed([2.0; 2]), disturbance: boxed([1.0; 2]) };
    let grid = Grid::new([
        Axis::bounded(-4.0, 4.0, 41),
        Axis::bounded(-4.0, 4.0, 41),
        Axis::bounded(-3.5, 3.5, 15),
        Axis::bounded(-3.5, 3.5, 15),
    ])
    .unwrap();
    let settings = SolverSettings {
        upwind: UpwindScheme::Weno3,
        integrator: TimeIntegrator::TvdRk3,
        dissipation: Dissipation::OptimalPlay,
        tube: TubeForm::Variational,
        cfl: 0.75,
        max_horizon_s: 3.0,
        convergence: Convergence {
            check_interval_s: 3.0,
            unsafe_share_tolerance: 0.0,
            value_tolerance_m: None,
            boundary_layer: 0.08,
        },
    };
    let failure = disc_failure_function(RADIUS_M);
    let solution = solve(&pair, &failure, &grid, &settings, &mut |_| ControlFlow::Continue(())).unwrap();
    let value = quadrotor();
    let (mut sum, mut compared) = (0.0, 0);
    for node in (0..grid.node_count()).step_by(101) {
        let z = grid.state(node);
        if z[0].abs() < 3.0 && z[1].abs() < 3.0 && z[2].abs() < 2.6 && z[3].abs() < 2.6 {
            sum += (f64::from(solution.values[node]) - value.value_m(&z)).abs();
            compared += 1;
        }
    }
    let mean = sum / f64::from(compared);
    println!("mean distance to the grid {mean:.4} m over {compared} nodes");
    assert!(mean < 0.01);
}
