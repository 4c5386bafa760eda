//! C3BF and HO-CBF against cases worked out by hand and against differences in time; their quadratic program against its
//! optimality conditions.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use barrier::{CbfQp, HalfSpace};
use baselines::{
    CollisionCone, DistanceOrderTwo, Inputs, Method, MethodKind, MethodOutput, MethodParameters, NoControl,
    PairRow, PairState, SoftRowsQp, Verdict,
};
use dynamics::InputBox;
use messages::{NominalCommand, Obstacle};

const CONE: CollisionCone = CollisionCone { k_per_s: 3.0 };
const DISTANCE: DistanceOrderTwo = DistanceOrderTwo { k1_per_s: 3.0, k2_per_s: 2.0 };

fn pair(position_m: [f64; 2], velocity_mps: [f64; 2], acceleration: [f64; 2]) -> PairState {
    PairState { position_m, velocity_mps, obstacle_acceleration_mps2: acceleration, contact_m: 0.6 }
}

fn assert_row(row: HalfSpace<2>, normal: [f64; 2], offset: f64) {
    let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
    let same = near(row.normal[0], normal[0]) && near(row.normal[1], normal[1]) && near(row.offset, offset);
    assert!(same, "{row:?}, expected {normal:?} {offset}");
}

#[test]
fn the_cone_of_somebody_who_comes_straight_on() {
    // p = (1, 0), v = (−1, 0), R = 0.6: s = 0.8, h = −1 + 0.8 = −0.2;
    // ḣ at u = 0: 1 + 0 + 0 + 1·(−1)/0.8 = −0.25; normal −(p + s v/‖v‖) = −(1 − 0.8, 0).
    assert_row(CONE.row(&pair([1.0, 0.0], [-1.0, 0.0], [0.0; 2])), [-0.2, 0.0], -0.25 - 0.6);
}

#[test]
fn the_cone_of_somebody_who_crosses_and_accelerates() {
    // p = (0, 1), v = (2, 0), a_o = (0.5, −1): s = 0.8, h = 1.6, p + s v/‖v‖ = (0.8, 1);
    // ḣ at u = 0: 4 + 0.4 − 1 + 0 = 3.4.
    assert_row(CONE.row(&pair([0.0, 1.0], [2.0, 0.0], [0.5, -1.0])), [-0.8, -1.0], 3.4 + 4.8);
}

#[test]
fn inside_the_disc_the_cone_keeps_a_tenth_of_a_metre() {
    // p = (0.5, 0), v = (−1, 0): s = 0.1 without a derivative; h = −0.5 + 0.1; ḣ = 1.
    assert_row(CONE.row(&pair([0.5, 0.0], [-1.0, 0.0], [0.0; 2])), [-0.4, 0.0], 1.0 - 1.2);
}

#[test]
fn without_relative_motion_the_cone_s_row_is_finite() {
    assert_row(CONE.row(&pair([1.0, 0.0], [0.0; 2], [0.3, 0.0])), [-1.0, 0.0], 0.3);
}

#[test]
fn the_second_order_row_of_somebody_who_comes_straight_on() {
    // h = 0.4, ḣ = −1, ḧ = 0 at u = 0: offset 5·(−1) + 6·0.4 = −2.6.
    assert_row(DISTANCE.row(&pair([1.0, 0.0], [-1.0, 0.0], [0.0; 2])), [-1.0, 0.0], -2.6);
}

#[test]
fn the_second_order_row_of_somebody_who_crosses_and_accelerates() {
    // p = (3, 4), n = (0.6, 0.8), v = (−1, 2): ḣ = 1, ḧ at u = 0: n·a_o + (5 − 1)/5 = −0.2 + 0.8, h = 4.4.
    let row = DISTANCE.row(&pair([3.0, 4.0], [-1.0, 2.0], [1.0, -1.0]));
    assert_row(row, [-0.6, -0.8], 0.6 + 5.0 + 26.4);
}

#[test]
fn the_gains_of_the_second_order_row_may_be_exchanged() {
    let state = pair([1.5, -0.7], [0.3, 1.1], [0.2, -0.4]);
    let exchanged = DistanceOrderTwo { k1_per_s: 2.0, k2_per_s: 3.0 };
    assert_eq!(DISTANCE.row(&state), exchanged.row(&state));
}

/// The pair after `t` s with constant accelerations of both.
fn moved(state: &PairState, u: [f64; 2], t: f64) -> PairState {
    let a: [f64; 2] = std::array::from_fn(|i| state.obstacle_acceleration_mps2[i] - u[i]);
    PairState {
        position_m: std::array::from_fn(|i| {
            state.position_m[i] + t * state.velocity_mps[i] + 0.5 * t * t * a[i]
        }),
        velocity_mps: std::array::from_fn(|i| state.velocity_mps[i] + t * a[i]),
        ..*state
    }
}

fn norm([x, y]: [f64; 2]) -> f64 {
    x.hypot(y)
}

/// Thirty states outside the disc, with accelerations of both.
fn states() -> impl Iterator<Item = (PairState, [f64; 2])> {
    (0..30).map(|i| {
        let at = |k: f64| f64::from(i) * k;
        let away = 0.8 + 0.1 * f64::from(i);
        let position = [away * at(2.4).cos(), away * at(2.4).sin()];
        let state = pair(position, [1.5 * at(1.3).sin(), at(0.7).cos()], [at(3.1).sin(), at(1.9).cos()]);
        (state, [2.0 * at(0.9).sin(), 2.0 * at(2.2).cos()])
    })
}

#[test]
fn rows_are_the_derivatives_in_time_that_differences_show() {
    let step = 1e-4;
    for (state, u) in states() {
        let along = |row: HalfSpace<2>| row.normal[0] * u[0] + row.normal[1] * u[1] + row.offset;
        let cone = |t: f64| {
            let PairState { position_m: p, velocity_mps: v, contact_m, .. } = moved(&state, u, t);
            p[0] * v[0] + p[1] * v[1] + norm(v) * (norm(p).powi(2) - contact_m.powi(2)).sqrt()
        };
        let expected = (cone(step) - cone(-step)) / (2.0 * step) + 3.0 * cone(0.0);
        assert!((along(CONE.row(&state)) - expected).abs() < 1e-5, "{state:?} {expected}");

        let distance = |t: f64| norm(moved(&state, u, t).position_m) - state.contact_m;
        let (ahead, now, behind) = (distance(step), distance(0.0), distance(-step));
        let second = (ahead - 2.0 * now + behind) / (step * step);
        let expected = second + 5.0 * (ahead - behind) / (2.0 * step) + 6.0 * now;
        assert!((along(DISTANCE.row(&state)) - expected).abs() < 1e-5, "{state:?} {expected}");
    }
}

fn quadrotor_box() -> InputBox<2> {
    InputBox::new([-2.0, -2.0], [2.0, 2.0]).unwrap()
}

fn random_rows(seed: usize, count: usize) -> Vec<HalfSpace<2>> {
    let wave = |k: usize, factor: f64| ((seed * 64 + k) as f64 * factor).sin();
    (0..count)
        .map(|k| HalfSpace {
            normal: [2.0 * wave(k, 12.9898), 2.0 * wave(k, 78.233)],
            offset: 3.0 * wave(k, 37.719),
        })
        .collect()
}

/// The cost is strictly convex: a control from which no admissible direction descends is its one minimum.
#[test]
fn no_admissible_direction_descends_from_the_solution() {
    let weight = 1e6;
    let control = quadrotor_box();
    let qp = SoftRowsQp::new(control, weight);
    for seed in 0..400 {
        let rows = random_rows(seed, seed % 13);
        let u_nom = [3.0 * (seed as f64 * 0.7).sin(), 3.0 * (seed as f64 * 1.1).cos()];
        let solution = qp.solve(&u_nom, &rows);
        let u = solution.control;
        assert!(solution.solved && control.contains(&u), "{seed}: {solution:?}");
        let missed = |row: &HalfSpace<2>| (row.normal[0] * u[0] + row.normal[1] * u[1] + row.offset).min(0.0);
        for k in 0..2 {
            let terms = rows.iter().map(|row| weight * missed(row) * row.normal[k]);
            let slope = u[k] - u_nom[k] + terms.clone().sum::<f64>();
            let rounding = 1e-9 * (1.0 + terms.map(f64::abs).sum::<f64>()) + weight * 1e-13;
            let held_below = u[k] <= control.min[k] + 1e-12 && slope >= -rounding;
            let held_above = u[k] >= control.max[k] - 1e-12 && slope <= rounding;
            assert!(slope.abs() <= rounding || held_below || held_above, "{seed}: {solution:?} {slope:e}");
        }
    }
}

#[test]
fn one_row_is_solved_as_the_cbf_qp_solves_it() {
    let qp = SoftRowsQp::new(quadrotor_box(), 1e6);
    let judge = CbfQp::new(quadrotor_box(), 1e6).unwrap();
    for seed in 0..200 {
        let rows = random_rows(seed, 1);
        let u_nom = [2.5 * (seed as f64 * 0.3).cos(), 2.5 * (seed as f64 * 0.9).sin()];
        let (ours, theirs) = (qp.solve(&u_nom, &rows), judge.solve(&u_nom, Some(&rows[0])).unwrap());
        assert!((0..2).all(|k| (ours.control[k] - theirs.u[k]).abs() < 1e-8), "{ours:?} {theirs:?}");
        assert!((ours.largest_slack - theirs.slack).abs() < 1e-8, "{ours:?} {theirs:?}");
    }
}

#[test]
fn rows_that_are_not_finite_are_not_called_solved() {
    let rows = [HalfSpace { normal: [f64::NAN, 0.0], offset: 0.0 }];
    let solution = SoftRowsQp::new(quadrotor_box(), 1e6).solve(&[0.5, 0.0], &rows);
    assert!(!solution.solved && solution.control == [0.5, 0.0]);
}

fn filter(kind: MethodKind) -> Box<dyn Method> {
    MethodParameters::published(kind).build(&common::quadrotor(), None).unwrap()
}

fn step(
    kind: MethodKind,
    robot: [f64; 4],
    u_nom: [f64; 2],
    people: &[Obstacle],
) -> Result<MethodOutput, NoControl> {
    let (state, nominal, obstacles) =
        (common::flying_robot(robot), common::accelerate(u_nom), common::crowd(people));
    let inputs = Inputs {
        robot_state: Some(&state),
        obstacles: Some(&obstacles),
        goal: None,
        nominal: Some(&nominal),
    };
    filter(kind).step(&inputs, common::NOW_NS)
}

const FILTERS: [MethodKind; 2] = [MethodKind::C3bf, MethodKind::HoCbf];

#[test]
fn with_nobody_in_sight_the_nominal_acceleration_is_clipped() {
    let far = common::person([30.0, 0.0], [-1.0, 0.0]);
    for kind in FILTERS {
        let output = step(kind, [0.0; 4], [3.0, -1.0], &[far]).unwrap();
        assert_eq!((output.control, output.verdict), ([2.0, -1.0], Verdict::Feasible));
        assert_eq!((output.hard_feasibility_margin, output.obstacle_count), (f64::INFINITY, 0));
    }
}

#[test]
fn somebody_ahead_slows_the_robot_down() {
    let ahead = common::person([1.5, 0.1], [0.0, 0.0]);
    for (kind, speed_mps) in [(MethodKind::C3bf, 0.3), (MethodKind::HoCbf, 0.9)] {
        let output = step(kind, [0.0, 0.0, speed_mps, 0.0], [2.0, 0.0], &[ahead]).unwrap();
        assert_eq!(output.verdict, Verdict::Feasible, "{kind}: {output:?}");
        assert!(output.control[0] < 1.9 && output.slack < 1e-3, "{kind}: {output:?}");
    }
}

#[test]
fn a_crash_that_nothing_can_stop_is_told_and_braked_for_with_all_there_is() {
    let ahead = common::person([1.5, 0.0], [-1.5, 0.0]);
    let output = step(MethodKind::HoCbf, [0.0, 0.0, 2.0, 0.0], [2.0, 0.0], &[ahead]).unwrap();
    assert_eq!((output.verdict, output.control[0]), (Verdict::Infeasible, -2.0), "{output:?}");
    assert!(output.hard_feasibility_margin < 0.0, "{output:?}");
    assert!((output.slack + output.hard_feasibility_margin).abs() < 1e-6, "{output:?}");
}

#[test]
fn people_who_mirror_each_other_leave_the_robot_on_its_line() {
    let people = [[1.6, 0.8], [1.6, -0.8]].map(|position| common::person(position, [-0.8, 0.0]));
    for kind in FILTERS {
        let output = step(kind, [0.0, 0.0, 0.5, 0.0], [1.0, 0.0], &people).unwrap();
        assert!(output.control[1].abs() < 1e-9, "{kind}: {output:?}");
    }
}

#[test]
fn the_five_nearest_count() {
    let people: Vec<_> =
        (0..8).map(|i| common::person([1.2 + 0.3 * f64::from(i), 1.0], [0.0, 0.1])).collect();
    let mut reversed = people.clone();
    reversed.reverse();
    for kind in FILTERS {
        let output = step(kind, [0.0; 4], [1.0, 1.0], &people).unwrap();
        assert_eq!(output.obstacle_count, 5);
        assert_eq!(output, step(kind, [0.0; 4], [1.0, 1.0], &reversed).unwrap());
        assert_eq!(output.control, step(kind, [0.0; 4], [1.0, 1.0], &people[..5]).unwrap().control);
    }
}

#[test]
fn nominal_commands_that_make_no_control_are_refused() {
    let (state, obstacles) = (common::flying_robot([0.0; 4]), common::crowd(&[]));
    let inputs = Inputs { robot_state: Some(&state), obstacles: Some(&obstacles), ..Inputs::default() };
    let mut method = filter(MethodKind::C3bf);
    let missing = method.step(&inputs, common::NOW_NS);
    assert_eq!(missing, Err(NoControl::Missing { input: "nominal_command" }));
    let good = common::accelerate([1.0, 0.0]);
    let unicycle = messages::ControlKind::Unicycle.code();
    let stop = messages::Intent::Stop.code();
    for (nominal, expected) in [
        (NominalCommand { control_kind: unicycle, ..good }, NoControl::OtherRobot),
        (common::accelerate([f64::NAN, 0.0]), NoControl::NonFinite { input: "nominal_command" }),
        (NominalCommand { intent: stop, ..good }, NoControl::Stop),
    ] {
        let inputs = Inputs { nominal: Some(&nominal), ..inputs };
        assert_eq!(method.step(&inputs, common::NOW_NS), Err(expected));
    }
}
