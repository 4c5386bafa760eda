//! Inequalities along a trajectory: hard, soft, impossible, and moved between solves.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use optimal_control::{
    ConstraintRow, DiscreteDynamics, EulerUnicycle, Linearisation, QuadraticWeights, Sqp, SqpSettings,
    SqpSetupError, SqpStatus, StageConstraints, StepPoint,
};

/// A position that moves by its control: `x⁺ = x + u`.
struct Slider;

impl DiscreteDynamics<1, 1> for Slider {
    fn next(&self, &[x]: &[f64; 1], &[u]: &[f64; 1]) -> [f64; 1] {
        [x + u]
    }

    fn linearise(&self, _: &[f64; 1], _: &[f64; 1]) -> Linearisation<1, 1> {
        Linearisation { by_state: [[1.0]], by_control: [[1.0]] }
    }
}

/// `x_{k+1} ≥ wall` and `u_k ≤ speed + share · x_k`: one row on the next state, one on state and control.
struct Bounds {
    wall: f64,
    speed: f64,
    share: f64,
}

impl StageConstraints<1, 1> for Bounds {
    fn rows_per_step(&self) -> usize {
        2
    }

    fn values(&mut self, point: &StepPoint<1, 1>, values: &mut [f64]) {
        values[0] = point.next[0] - self.wall;
        values[1] = self.speed + self.share * point.state[0] - point.control[0];
    }

    fn linearise(&mut self, point: &StepPoint<1, 1>, rows: &mut [ConstraintRow<1, 1>]) {
        let mut values = [0.0; 2];
        self.values(point, &mut values);
        rows[0] = ConstraintRow { by_next: [1.0], ..ConstraintRow::constant(values[0]) };
        rows[1] = ConstraintRow {
            by_state: [self.share],
            by_control: [-1.0],
            ..ConstraintRow::constant(values[1])
        };
    }
}

fn slider(bounds: Bounds, violation_weight: f64) -> Sqp<Slider, 1, 1, Bounds> {
    let settings = SqpSettings {
        horizon_steps: 2,
        weights: QuadraticWeights { stage_state: [1.0], terminal_state: [1.0], control: [1.0] },
        control_min: [-10.0],
        control_max: [10.0],
        iteration_limit: 20,
        step_tolerance: 1e-8,
    };
    Sqp::with_constraints(Slider, settings, bounds, violation_weight, &[1.0]).unwrap()
}

const OPEN: Bounds = Bounds { wall: -100.0, speed: 100.0, share: 0.0 };

#[test]
fn rows_that_do_not_bind_change_nothing() {
    // x₀ = 5: min x₁² + x₂² + u₀² + u₁² gives x₁ = 2, x₂ = 1.
    let mut sqp = slider(OPEN, 1e3);
    let report = sqp.solve(&[5.0], &[0.0]).unwrap();
    assert_eq!((report.status, report.violation), (SqpStatus::Converged, 0.0));
    assert!((sqp.states()[1][0] - 2.0).abs() < 1e-5 && (sqp.states()[2][0] - 1.0).abs() < 1e-5);
}

#[test]
fn a_hard_row_on_the_next_state_is_kept() {
    // Both states stop at the wall: u₀ = −2, u₁ = 0.
    let mut sqp = slider(Bounds { wall: 3.0, ..OPEN }, 1e3);
    let report = sqp.solve(&[5.0], &[0.0]).unwrap();
    assert_eq!(report.status, SqpStatus::Converged);
    assert!(report.smallest_row > -1e-6, "{report:?}");
    assert!((sqp.controls()[0][0] + 2.0).abs() < 1e-5 && sqp.controls()[1][0].abs() < 1e-5);
}

#[test]
fn a_hard_row_on_state_and_control_is_kept() {
    // u_k ≤ −4.5 + x_k / 5 binds twice: u₀ = −3.5, x₁ = 1.5, u₁ = −4.2.
    let mut sqp = slider(Bounds { speed: -4.5, share: 0.2, ..OPEN }, 1e3);
    let report = sqp.solve(&[5.0], &[0.0]).unwrap();
    assert!(report.smallest_row > -1e-6, "{report:?}");
    assert!((sqp.controls()[0][0] + 3.5).abs() < 1e-5, "{:?}", sqp.controls());
    assert!((sqp.controls()[1][0] + 4.2).abs() < 1e-5, "{:?}", sqp.controls());
}

#[test]
fn a_price_below_the_multiplier_makes_the_row_soft() {
    // Both multipliers at the wall exceed 0.5, so both rows are missed in part:
    // stationary where 2x₂ + 2u₁ = 0.5 and 2x₁ + 2u₀ − 2u₁ = 0.5.
    let mut sqp = slider(Bounds { wall: 3.0, ..OPEN }, 0.5);
    let report = sqp.solve(&[5.0], &[0.0]).unwrap();
    let [x1, x2] = [sqp.states()[1][0], sqp.states()[2][0]];
    let [u0, u1] = [sqp.controls()[0][0], sqp.controls()[1][0]];
    assert!((2.0 * x2 + 2.0 * u1 - 0.5).abs() < 1e-4, "{report:?}");
    assert!((2.0 * x1 + 2.0 * u0 - 2.0 * u1 - 0.5).abs() < 1e-4, "{report:?}");
    assert!((report.violation - (6.0 - x1 - x2)).abs() < 1e-9 && report.violation > 0.1, "{report:?}");
    assert!((report.smallest_row - (x2 - 3.0)).abs() < 1e-9, "{report:?}");
}

#[test]
fn rows_that_cannot_be_met_are_missed_by_as_little_as_possible() {
    // The wall is 20 away, a step at most 10: x₁ = 15 misses it by 10, x₂ reaches it.
    let mut sqp = slider(Bounds { wall: 25.0, ..OPEN }, 1e5);
    let report = sqp.solve(&[5.0], &[0.0]).unwrap();
    // At this price the tolerance of the search is finer than that of the QP.
    assert!(matches!(report.status, SqpStatus::Converged | SqpStatus::NoDescent), "{report:?}");
    assert!((report.violation - 10.0).abs() < 1e-4, "{report:?}");
    assert!((report.smallest_row + 10.0).abs() < 1e-4, "{report:?}");
}

#[test]
fn rows_move_between_solves() {
    let mut sqp = slider(OPEN, 1e3);
    sqp.solve(&[5.0], &[0.0]).unwrap();
    sqp.constraints_mut().wall = 3.0;
    let report = sqp.solve(&[5.0], &[0.0]).unwrap();
    assert!(report.smallest_row > -1e-6 && (sqp.states()[2][0] - 3.0).abs() < 1e-5);
    sqp.constraints_mut().wall = -100.0;
    sqp.solve(&[5.0], &[0.0]).unwrap();
    assert!((sqp.states()[1][0] - 2.0).abs() < 1e-5);
}

/// Keeps a unicycle out of a disc.
struct Disc;

impl StageConstraints<3, 2> for Disc {
    fn rows_per_step(&self) -> usize {
        1
    }

    fn values(&mut self, point: &StepPoint<3, 2>, values: &mut [f64]) {
        values[0] = (point.next[0] + 1.0).hypot(point.next[1] - 0.05) - 0.6;
    }

    fn linearise(&mut self, point: &StepPoint<3, 2>, rows: &mut [ConstraintRow<3, 2>]) {
        let away = [point.next[0] + 1.0, point.next[1] - 0.05];
        let distance = away[0].hypot(away[1]);
        let by_next = [away[0] / distance, away[1] / distance, 0.0];
        rows[0] = ConstraintRow { by_next, ..ConstraintRow::constant(distance - 0.6) };
    }
}

#[test]
fn a_curved_constraint_is_met_by_every_state_of_a_nonlinear_plan() {
    let settings = SqpSettings {
        horizon_steps: 30,
        weights: QuadraticWeights {
            stage_state: [50.0, 50.0, 1.0],
            terminal_state: [50.0, 50.0, 1.0],
            control: [1.0, 1.0],
        },
        control_min: [0.25, -0.8],
        control_max: [1.0, 0.8],
        iteration_limit: 60,
        step_tolerance: 1e-5,
    };
    let dynamics = EulerUnicycle { step_s: 0.1 };
    let mut sqp = Sqp::with_constraints(dynamics, settings, Disc, 1e5, &[-3.0, 1.0, 0.5]).unwrap();
    let report = sqp.solve(&[-2.5, 0.0, 0.0], &[0.0; 3]).unwrap();
    assert_eq!(report.status, SqpStatus::Converged, "{report:?}");
    let clearance = |x: &[f64; 3]| (x[0] + 1.0).hypot(x[1] - 0.05) - 0.6;
    let smallest = sqp.states().iter().map(clearance).fold(f64::INFINITY, f64::min);
    assert!(smallest > -1e-6 && smallest < 1e-3, "{smallest} {report:?}");
    for k in 0..30 {
        assert_eq!(sqp.states()[k + 1], dynamics.next(&sqp.states()[k], &sqp.controls()[k]));
    }
    assert!(sqp.states()[30][0] > -0.6, "past the disc: {:?}", sqp.states()[30]);
}

#[test]
fn a_violation_that_costs_nothing_is_refused() {
    let settings = *slider(OPEN, 1.0).settings();
    for violation_weight in [0.0, -1.0, f64::NAN] {
        let error = Sqp::with_constraints(Slider, settings, OPEN, violation_weight, &[1.0]).err();
        assert!(matches!(error, Some(SqpSetupError::NotPositive { quantity: "violation_weight", .. })));
    }
}
