//! LQR against the closed form, against SciPy's stored solutions, and against misuse.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use nalgebra::{DMatrix, dmatrix};
use optimal_control::{Lqr, LqrError, continuous_lqr, discrete_lqr};

fn planar_double_integrator() -> (DMatrix<f64>, DMatrix<f64>) {
    let a = dmatrix![0., 0., 1., 0.; 0., 0., 0., 1.; 0., 0., 0., 0.; 0., 0., 0., 0.];
    let b = dmatrix![0., 0.; 0., 0.; 1., 0.; 0., 1.];
    (a, b)
}

fn weights() -> (DMatrix<f64>, DMatrix<f64>) {
    (DMatrix::from_diagonal(&nalgebra::dvector![4., 4., 1., 1.]), DMatrix::identity(2, 2))
}

#[test]
fn the_authors_gain_comes_out() {
    let (a, b) = planar_double_integrator();
    let (q, r) = weights();
    let lqr = continuous_lqr(&a, &b, &q, &r).unwrap();
    // k_p = √(q_p/r), k_v = √(q_v/r + 2 k_p).
    let damping = 5.0_f64.sqrt();
    let expected = dmatrix![2., 0., damping, 0.; 0., 2., 0., damping];
    assert!((&lqr.gain - &expected).amax() < 1e-12, "{}", lqr.gain);
}

#[test]
fn a_short_step_approaches_the_continuous_gain() {
    let (a, b) = planar_double_integrator();
    let (q, r) = weights();
    let step_s = 1e-4;
    let a_step = DMatrix::identity(4, 4) + &a * step_s;
    let lqr = discrete_lqr(&a_step, &(&b * step_s), &(&q * step_s), &(&r * step_s)).unwrap();
    let continuous = continuous_lqr(&a, &b, &q, &r).unwrap();
    assert!((lqr.gain - continuous.gain).amax() < 1e-3);
}

#[test]
fn scipy_agrees_in_continuous_and_discrete_time() {
    let text = include_str!("../../../tests/data/mpc_lqr_scipy_reference.json");
    let document: serde_json::Value = serde_json::from_str(text).unwrap();
    let cases = document["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 24);
    for case in cases {
        let read = |name: &str| matrix(&case[name]);
        let (a, b, q, r) = (read("a"), read("b"), read("q"), read("r"));
        for (kind, found) in
            [("continuous", continuous_lqr(&a, &b, &q, &r)), ("discrete", discrete_lqr(&a, &b, &q, &r))]
        {
            let Lqr { gain, riccati_solution } = found.unwrap();
            let expected_gain = read(&format!("{kind}_gain"));
            let expected_riccati = read(&format!("{kind}_riccati"));
            assert!((&gain - &expected_gain).norm() < 1e-9 * expected_gain.norm(), "{kind} {a}");
            assert!(
                (&riccati_solution - &expected_riccati).norm() < 1e-9 * expected_riccati.norm(),
                "{kind} {a}"
            );
        }
    }
}

fn matrix(value: &serde_json::Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> = serde_json::from_value(value.clone()).unwrap();
    DMatrix::from_fn(rows.len(), rows[0].len(), |row, column| rows[row][column])
}

#[test]
fn a_matrix_of_the_wrong_shape_is_named() {
    let (a, b) = planar_double_integrator();
    let (q, _) = weights();
    let error = continuous_lqr(&a, &b, &q, &DMatrix::identity(3, 3)).unwrap_err();
    assert!(matches!(error, LqrError::Shape { matrix: "R", rows: 3, expected_rows: 2, .. }), "{error}");
}

#[test]
fn an_indefinite_control_weight_is_refused() {
    let (a, b) = planar_double_integrator();
    let (q, mut r) = weights();
    r[(1, 1)] = -1.0;
    assert_eq!(continuous_lqr(&a, &b, &q, &r), Err(LqrError::IndefiniteControlWeight));
    assert_eq!(discrete_lqr(&a, &b, &q, &r), Err(LqrError::IndefiniteControlWeight));
}

#[test]
fn an_indefinite_state_weight_is_refused() {
    let (a, b) = planar_double_integrator();
    let (mut q, r) = weights();
    q[(0, 0)] = -4.0;
    assert!(matches!(continuous_lqr(&a, &b, &q, &r), Err(LqrError::IndefiniteStateWeight { .. })));
}

#[test]
fn an_asymmetric_weight_is_refused() {
    let (a, b) = planar_double_integrator();
    let (mut q, r) = weights();
    q[(0, 1)] = 0.5;
    assert_eq!(continuous_lqr(&a, &b, &q, &r), Err(LqrError::Asymmetric { matrix: "Q" }));
}

#[test]
fn a_nan_is_refused() {
    let (mut a, b) = planar_double_integrator();
    let (q, r) = weights();
    a[(0, 0)] = f64::NAN;
    assert_eq!(continuous_lqr(&a, &b, &q, &r), Err(LqrError::NonFinite { matrix: "A" }));
}

#[test]
fn an_unreached_growing_mode_is_refused() {
    let (a, mut b) = planar_double_integrator();
    let (q, r) = weights();
    b[(3, 1)] = 0.0;
    assert!(matches!(continuous_lqr(&a, &b, &q, &r), Err(LqrError::NotStabilisable { .. })));
}

#[test]
fn an_unreached_dying_mode_is_fine() {
    let a = dmatrix![0.5, 0.0; 0.0, -1.0];
    let b = dmatrix![1.0; 0.0];
    let lqr = continuous_lqr(&a, &b, &DMatrix::identity(2, 2), &DMatrix::identity(1, 1)).unwrap();
    assert!(lqr.gain[(0, 0)] > 0.5);
}

#[test]
fn an_unweighed_growing_mode_is_refused() {
    let (a, b) = planar_double_integrator();
    let (_, r) = weights();
    // Velocity alone is weighed: nothing pulls the position back.
    let q = DMatrix::from_diagonal(&nalgebra::dvector![0., 0., 1., 1.]);
    assert!(matches!(continuous_lqr(&a, &b, &q, &r), Err(LqrError::NotDetectable { .. })));
}
