//! The rows against differences and against cases worked out by hand.

use dynamics::{InputBox, UnicyclePair};
use optimal_control::ConstraintRow;

use super::velocity_obstacle::vo_row;
use super::{DcbfRows, Demand, Passing, Point, RntcRows, Row, SdfRows, VoRows};

const LAST_STEP: usize = 19;

fn rntc(terminal_margin_m: f64) -> RntcRows {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
    let model = barrier::Model::load(&folder.join("ground_robot_paper.safetensors")).unwrap();
    let control = InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap();
    let pair = UnicyclePair { control, disturbance: InputBox::new([0.0], [0.0]).unwrap() };
    RntcRows::new(&model, barrier::Kernel::Portable, pair, LAST_STEP, terminal_margin_m).unwrap()
}

fn row(demand: &mut dyn Demand, point: &Point, obstacle: &Passing) -> Row {
    let mut rows = [ConstraintRow::constant(0.0)];
    demand.fill(point, &[*obstacle], &mut rows);
    rows[0]
}

/// Twenty-five points with somebody near, at step `step`.
fn points(step: usize) -> impl Iterator<Item = (Point, Passing)> {
    (1..26).map(move |i| {
        let wave = |factor: f64| (f64::from(i) * factor).sin();
        let state = [wave(1.1), wave(2.3), 3.0 * wave(0.7)];
        let next = [state[0] + 0.1 * wave(5.1), state[1] + 0.1 * wave(4.1), state[2] + 0.08 * wave(3.3)];
        let control = [0.6 + 0.3 * wave(1.9), 0.7 * wave(2.9)];
        let position_m = [state[0] + 1.5 + wave(3.7), state[1] + 1.2 * wave(0.9)];
        let velocity_mps = [-0.9 * wave(1.3), 0.8 * wave(6.1)];
        let obstacle = Passing {
            position_m,
            next_position_m: std::array::from_fn(|k| position_m[k] + 0.1 * velocity_mps[k]),
            velocity_mps,
            heading_rad: velocity_mps[1].atan2(velocity_mps[0]),
            speed_mps: velocity_mps[0].hypot(velocity_mps[1]),
            contact_m: 0.3,
        };
        (Point { step, state, control, next }, obstacle)
    })
}

/// Compares every gradient with central differences, entries outside the sparsity included.
fn compare(demand: &mut dyn Demand, step: usize, difference: f64, tolerance: f64) {
    let sparsity = demand.sparsity();
    for (point, obstacle) in points(step) {
        let exact = row(demand, &point, &obstacle);
        let mut check = |name: &str, slope: f64, stored: f64, shift: &dyn Fn(&mut Point, f64)| {
            let mut at = |by: f64| {
                let mut moved = point;
                shift(&mut moved, by);
                row(demand, &moved, &obstacle).value
            };
            let expected = (at(difference) - at(-difference)) / (2.0 * difference);
            assert!(
                (slope - expected).abs() < tolerance,
                "{name}: {slope} {expected} at {point:?} {obstacle:?}"
            );
            assert!(stored != 0.0 || slope == 0.0, "{name} is {slope} but not stored");
        };
        for k in 0..3 {
            check("by_state", exact.by_state[k], sparsity.by_state[k], &|p, by| p.state[k] += by);
            check("by_next", exact.by_next[k], sparsity.by_next[k], &|p, by| p.next[k] += by);
        }
        for k in 0..2 {
            check("by_control", exact.by_control[k], sparsity.by_control[k], &|p, by| p.control[k] += by);
        }
    }
}

#[test]
fn gradients_agree_with_differences() {
    compare(&mut SdfRows, 3, 1e-6, 1e-7);
    compare(&mut DcbfRows { gamma: 0.3 }, 3, 1e-6, 1e-7);
    compare(&mut VoRows, 3, 1e-7, 1e-5);
    compare(&mut rntc(0.0), 3, 1e-6, 1e-7);
}

/// The network computes in single precision, which is what differences show.
#[test]
fn gradients_of_the_terminal_set_agree_with_differences() {
    compare(&mut rntc(0.0), LAST_STEP, 5e-3, 5e-3);
}

fn still(position_m: [f64; 2], contact_m: f64) -> Passing {
    Passing {
        position_m,
        next_position_m: position_m,
        velocity_mps: [0.0; 2],
        heading_rad: 0.0,
        speed_mps: 0.0,
        contact_m,
    }
}

fn point(state: [f64; 3], control: [f64; 2], next: [f64; 3]) -> Point {
    Point { step: 0, state, control, next }
}

#[test]
fn the_signed_distance_is_that_of_the_next_state() {
    let point = point([9.0, 9.0, 0.0], [1.0, 0.0], [1.0, 1.0, 0.0]);
    let row = row(&mut SdfRows, &point, &still([4.0, 5.0], 0.7));
    assert!((row.value - 4.3).abs() < 1e-12 && (row.by_next[0] + 0.6).abs() < 1e-12, "{row:?}");
}

#[test]
fn the_discrete_barrier_lets_the_distance_shrink_by_its_share() {
    // From 2 m to 1.4 m with γ = 0.3: just allowed.
    let point = point([0.0; 3], [1.0, 0.0], [0.6, 0.0, 0.0]);
    let row = row(&mut DcbfRows { gamma: 0.3 }, &point, &still([2.7, 0.0], 0.7));
    assert!(row.value.abs() < 1e-12, "{row:?}");
}

#[test]
fn a_velocity_along_the_cone_s_edge_is_just_allowed() {
    // A disc of radius 1 two metres ahead fills 30° to either side.
    let angle = std::f64::consts::FRAC_PI_6;
    let value =
        |heading| vo_row(&point([0.0, 0.0, heading], [0.5, 0.0], [0.0; 3]), &still([2.0, 0.0], 1.0)).value;
    assert!(value(angle).abs() < 1e-12 && value(-angle).abs() < 1e-12);
    assert!(value(0.9 * angle) < 0.0 && value(1.1 * angle) > 0.0);
}

#[test]
fn a_velocity_obstacle_moves_with_the_obstacle() {
    // Somebody ahead who walks away faster than the robot drives is no obstacle, whatever the distance.
    let away = Passing { velocity_mps: [0.9, 0.0], ..still([1.0, 0.0], 0.7) };
    let row = vo_row(&point([0.0; 3], [0.5, 0.0], [0.0; 3]), &away);
    assert!(row.value > 1.5, "{row:?}");
}

#[test]
fn straight_ahead_the_published_cut_leaves_no_slope_by_direction() {
    let row = vo_row(&point([0.0; 3], [0.5, 0.0], [0.0; 3]), &still([2.0, 0.0], 0.7));
    assert_eq!((row.by_state[2], row.by_control), (0.0, [0.0; 2]));
    assert!(row.value < 0.0);
}

#[test]
fn the_terminal_set_is_asked_for_at_the_last_state_only() {
    let ahead = Passing {
        velocity_mps: [-1.0, 0.0],
        heading_rad: std::f64::consts::PI,
        speed_mps: 1.0,
        ..still([1.5, 0.0], 0.7)
    };
    let at = |margin: f64, step: usize| {
        let point = Point { step, ..point([0.0; 3], [1.0, 0.0], [0.0; 3]) };
        row(&mut rntc(margin), &point, &ahead).value
    };
    let (on_the_way, at_the_end) = (at(0.0, LAST_STEP - 1), at(0.0, LAST_STEP));
    // Clear by 0.8 m, yet nothing the robot can do keeps it clear.
    assert!((on_the_way - 0.8).abs() < 1e-12 && at_the_end < 0.0, "{on_the_way} {at_the_end}");
    assert!((at(0.25, LAST_STEP) - at_the_end + 0.25).abs() < 1e-12);
    assert_eq!(at(0.25, LAST_STEP - 1), on_the_way);
}
