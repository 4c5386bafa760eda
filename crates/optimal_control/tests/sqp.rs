//! The SQP against the discrete LQR, against differences, and against misuse.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use nalgebra::{DMatrix, dmatrix};
use optimal_control::{
    DiscreteDynamics, EulerUnicycle, Linearisation, QuadraticWeights, Sqp, SqpSettings, SqpSetupError,
    SqpStatus, discrete_lqr,
};

/// `[position_m, velocity_mps]` under an acceleration, Euler step 0.1 s.
struct Cart;

impl DiscreteDynamics<2, 1> for Cart {
    fn next(&self, &[position, velocity]: &[f64; 2], &[acceleration]: &[f64; 1]) -> [f64; 2] {
        [position + 0.1 * velocity, velocity + 0.1 * acceleration]
    }

    fn linearise(&self, _: &[f64; 2], _: &[f64; 1]) -> Linearisation<2, 1> {
        Linearisation { by_state: [[1.0, 0.1], [0.0, 1.0]], by_control: [[0.0], [0.1]] }
    }
}

fn cart_settings() -> SqpSettings<2, 1> {
    SqpSettings {
        horizon_steps: 200,
        weights: QuadraticWeights { stage_state: [3.0, 0.5], terminal_state: [3.0, 0.5], control: [0.2] },
        control_min: [-100.0],
        control_max: [100.0],
        iteration_limit: 5,
        step_tolerance: 1e-7,
    }
}

#[test]
fn a_long_horizon_without_active_bounds_is_the_discrete_regulator() {
    let a = dmatrix![1.0, 0.1; 0.0, 1.0];
    let b = dmatrix![0.0; 0.1];
    let q = dmatrix![3.0, 0.0; 0.0, 0.5];
    let lqr = discrete_lqr(&a, &b, &q, &DMatrix::from_element(1, 1, 0.2)).unwrap();
    let mut sqp = Sqp::new(Cart, cart_settings(), &[1.0, 0.0]).unwrap();
    let start = [1.3, -0.4];
    let report = sqp.solve(&start, &[0.0; 2]).unwrap();
    assert_eq!(report.status, SqpStatus::Converged);
    let expected = -(lqr.gain[(0, 0)] * start[0] + lqr.gain[(0, 1)] * start[1]);
    assert!((sqp.controls()[0][0] - expected).abs() < 1e-5, "{} {expected}", sqp.controls()[0][0]);
    let p = &lqr.riccati_solution;
    let cost_to_go = p[(0, 0)] * start[0] * start[0]
        + 2.0 * p[(0, 1)] * start[0] * start[1]
        + p[(1, 1)] * start[1] * start[1];
    assert!((report.cost / cost_to_go - 1.0).abs() < 1e-6, "{} {cost_to_go}", report.cost);
}

#[test]
fn a_problem_that_is_its_own_model_takes_one_qp() {
    let mut sqp = Sqp::new(Cart, cart_settings(), &[1.0, 0.0]).unwrap();
    for start in [[1.3, -0.4], [-2.0, 1.0], [5.0, 0.0]] {
        let report = sqp.solve(&start, &[0.0; 2]).unwrap();
        assert_eq!((report.status, report.iterations), (SqpStatus::Converged, 1), "{start:?} {report:?}");
    }
}

#[test]
fn a_step_ends_at_the_box() {
    let mut settings = cart_settings();
    settings.control_min = [-0.5];
    settings.control_max = [0.7];
    let mut sqp = Sqp::new(Cart, settings, &[1.0, 0.0]).unwrap();
    sqp.solve(&[-50.0, 0.0], &[0.0; 2]).unwrap();
    assert!((sqp.controls()[0][0] - 0.7).abs() < 1e-6);
    assert!(sqp.controls().iter().all(|[u]| (-0.5..=0.7).contains(u)));
}

#[test]
fn predicted_states_obey_the_dynamics() {
    let mut sqp = Sqp::new(Cart, cart_settings(), &[1.0, 0.0]).unwrap();
    sqp.solve(&[2.0, 1.0], &[0.5, 0.0]).unwrap();
    for k in 0..200 {
        assert_eq!(sqp.states()[k + 1], Cart.next(&sqp.states()[k], &sqp.controls()[k]));
    }
}

#[test]
fn the_reference_is_what_is_driven_to() {
    let mut sqp = Sqp::new(Cart, cart_settings(), &[1.0, 0.0]).unwrap();
    sqp.solve(&[2.0, 1.0], &[0.5, 0.0]).unwrap();
    assert!((sqp.states()[200][0] - 0.5).abs() < 1e-3);
}

#[test]
fn a_guess_is_shifted_by_whole_and_broken_steps() {
    let mut settings = cart_settings();
    settings.horizon_steps = 4;
    let mut sqp = Sqp::new(Cart, settings, &[1.0, 0.0]).unwrap();
    let fill = |sqp: &mut Sqp<Cart, 2, 1>| sqp.guess_by_policy(&[0.0; 2], |k, _| [k as f64]);
    for (steps, expected) in [
        (0.5, [0.5, 1.5, 2.5, 3.0]),
        (1.0, [1.0, 2.0, 3.0, 3.0]),
        (1.25, [1.25, 2.25, 3.0, 3.0]),
        (99.0, [3.0; 4]),
        (-1.0, [0.0, 1.0, 2.0, 3.0]),
        (f64::NAN, [0.0, 1.0, 2.0, 3.0]),
    ] {
        fill(&mut sqp);
        sqp.shift_guess(steps);
        assert_eq!(sqp.controls().as_flattened(), expected, "{steps}");
    }
}

#[test]
fn one_iteration_is_never_worse_than_its_guess() {
    let mut settings = cart_settings();
    settings.iteration_limit = 1;
    let mut sqp = Sqp::new(Cart, settings, &[1.0, 0.0]).unwrap();
    for start in [[5.0, 0.0], [-3.0, 8.0], [0.0, 0.0], [1e-9, 0.0], [1e6, 0.0]] {
        let report = sqp.solve(&start, &[0.0; 2]).unwrap();
        assert!(report.cost <= report.guess_cost, "{start:?} {report:?}");
        assert_eq!(report.iterations, 1);
    }
}

#[test]
fn unicycle_jacobians_agree_with_differences() {
    let unicycle = EulerUnicycle { step_s: 0.1 };
    let step = 1e-6;
    for k in 0..50 {
        let state = [f64::from(k) * 0.3, -1.0, f64::from(k) * 0.37 - 9.0];
        let control = [0.25 + f64::from(k) * 0.015, 0.8 - f64::from(k) * 0.03];
        let exact = unicycle.linearise(&state, &control);
        let pattern = unicycle.sparsity();
        for j in 0..3 {
            let shifted = |by: f64| {
                let mut moved = state;
                moved[j] += by;
                unicycle.next(&moved, &control)
            };
            let (ahead, behind) = (shifted(step), shifted(-step));
            for i in 0..3 {
                assert!((exact.by_state[i][j] - (ahead[i] - behind[i]) / (2.0 * step)).abs() < 1e-8);
                assert!(pattern.by_state[i][j] != 0.0 || exact.by_state[i][j] == 0.0);
            }
        }
        for j in 0..2 {
            let shifted = |by: f64| {
                let mut moved = control;
                moved[j] += by;
                unicycle.next(&state, &moved)
            };
            let (ahead, behind) = (shifted(step), shifted(-step));
            for i in 0..3 {
                assert!((exact.by_control[i][j] - (ahead[i] - behind[i]) / (2.0 * step)).abs() < 1e-8);
                assert!(pattern.by_control[i][j] != 0.0 || exact.by_control[i][j] == 0.0);
            }
        }
    }
}

#[test]
fn the_unicycles_curvature_is_the_positive_second_difference_of_the_lagrangian() {
    let unicycle = EulerUnicycle { step_s: 0.1 };
    let (costate, control, step) = ([-3.0, 1.5, 0.7], [0.8, 0.3], 1e-3);
    for k in 0..24 {
        let heading = f64::from(k) * 0.3;
        let lagrangian = |heading: f64| {
            let next = unicycle.next(&[1.0, 2.0, heading], &control);
            (0..3).map(|i| costate[i] * next[i]).sum::<f64>()
        };
        let difference = (lagrangian(heading + step) - 2.0 * lagrangian(heading)
            + lagrangian(heading - step))
            / (step * step);
        let [x, y, theta] = unicycle.curvature(&[1.0, 2.0, heading], &control, &costate);
        assert_eq!([x, y], [0.0; 2]);
        assert!((theta - difference.max(0.0)).abs() < 1e-5, "{heading}: {theta} {difference}");
    }
}

fn refused(change: impl FnOnce(&mut SqpSettings<2, 1>)) -> SqpSetupError {
    let mut settings = cart_settings();
    change(&mut settings);
    Sqp::new(Cart, settings, &[1.0, 0.0]).err().unwrap()
}

#[test]
fn an_empty_horizon_is_refused() {
    assert_eq!(refused(|s| s.horizon_steps = 0), SqpSetupError::EmptyHorizon);
}

#[test]
fn no_iterations_are_refused() {
    assert_eq!(refused(|s| s.iteration_limit = 0), SqpSetupError::NoIterations);
}

#[test]
fn a_control_that_costs_nothing_is_refused() {
    let error = refused(|s| s.weights.control = [0.0]);
    assert_eq!(error, SqpSetupError::Weight { weight: "control", index: 0, value: 0.0 });
}

#[test]
fn a_negative_state_weight_is_refused() {
    let error = refused(|s| s.weights.terminal_state[1] = -1.0);
    assert_eq!(error, SqpSetupError::Weight { weight: "terminal_state", index: 1, value: -1.0 });
}

#[test]
fn an_empty_control_box_is_refused() {
    let error = refused(|s| s.control_max = [-100.0]);
    assert_eq!(error, SqpSetupError::ControlBox { index: 0, min: -100.0, max: -100.0 });
}

#[test]
fn a_tolerance_of_nan_is_refused() {
    assert!(matches!(refused(|s| s.step_tolerance = f64::NAN), SqpSetupError::NotPositive { .. }));
}
