//! Look-up between nodes, the value file, and what both refuse.

#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not recognise as such

use dynamics::{InputBox, UnicyclePair};
use reachability::{
    Axis, Convergence, Dissipation, Grid, GridError, ProblemDescription, SolverSettings, TimeIntegrator,
    TubeForm, UpwindScheme, ValueFileError, ValueFunction, solve,
};
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::path::PathBuf;

/// A "solution" that is the given failure function itself: the solve is interrupted before it leaves it, since
/// nothing moves.
fn tabulated(failure: &(dyn Fn(&[f64; 4]) -> f64 + Sync)) -> ValueFunction {
    let still = UnicyclePair {
        control: InputBox::new([0.0; 2], [0.0; 2]).unwrap(),
        disturbance: InputBox::new([0.0], [0.0]).unwrap(),
    };
    let grid = Grid::new([
        Axis::bounded(-2.0, 2.0, 9),
        Axis::bounded(-1.0, 2.0, 7),
        Axis::periodic(-PI, PI, 16),
        // Speeds this small move nothing by a whole f32 step.
        Axis::bounded(0.0, 1e-30, 5),
    ])
    .unwrap();
    let settings = SolverSettings {
        upwind: UpwindScheme::FirstOrder,
        integrator: TimeIntegrator::Euler,
        dissipation: Dissipation::ReachableSpeed,
        tube: TubeForm::Variational,
        cfl: 0.5,
        max_horizon_s: 1.0,
        convergence: Convergence {
            check_interval_s: 1.0,
            unsafe_share_tolerance: 1e-3,
            value_tolerance_m: None,
            boundary_layer: 0.0,
        },
    };
    let solution = solve(&still, failure, &grid, &settings, &mut |_| ControlFlow::Continue(())).unwrap();
    let problem = ProblemDescription {
        dynamics: "unicycle_pair".to_owned(),
        control: (&still.control).into(),
        disturbance: (&still.disturbance).into(),
        failure_radius_m: 0.7,
    };
    ValueFunction::new(solution, problem)
}

/// A path of this test's own, removed at the end.
struct OwnFile(PathBuf);

impl OwnFile {
    fn new(name: &str) -> Self {
        Self(std::env::temp_dir().join(format!("reachability-{}-{name}.safetensors", std::process::id())))
    }
}

impl Drop for OwnFile {
    fn drop(&mut self) {
        // Absent where the test expected so.
        let _ = std::fs::remove_file(&self.0);
    }
}

#[test]
fn multilinear_functions_are_met_exactly_between_nodes() {
    let linear = |z: &[f64; 4]| 1.0 + 2.0 * z[0] - 3.0 * z[1] + 0.5 * z[0] * z[1];
    let value = tabulated(&linear);
    for z in [[0.3, 0.4, 1.0, 0.0], [-2.0, 2.0, -PI, 1e-30], [1.99, -0.99, 3.1, 5e-31]] {
        assert!((value.interpolate(&z).unwrap() - linear(&z)).abs() < 1e-5);
        let gradient = value.gradient(&z).unwrap();
        assert!((gradient[0] - (2.0 + 0.5 * z[1])).abs() < 1e-4, "{gradient:?}");
        assert!((gradient[1] - (-3.0 + 0.5 * z[0])).abs() < 1e-4, "{gradient:?}");
        assert!(gradient[2].abs() < 1e-4);
    }
}

#[test]
fn periodic_axes_join_without_a_seam() {
    let value = tabulated(&|z| z[2].cos() + 3.0);
    let at = |theta: f64| value.interpolate(&[0.0, 0.0, theta, 0.0]).unwrap();
    assert!((at(PI - 1e-9) - at(-PI + 1e-9)).abs() < 1e-6);
    assert!((at(PI) - 2.0).abs() < 1e-6 && (at(3.0 * PI) - 2.0).abs() < 1e-6);
    // Halfway between the last node and the first.
    let spacing = 2.0 * PI / 16.0;
    assert!((at(PI - 0.5 * spacing) - (3.0 - 0.5 * (1.0 + spacing.cos()))).abs() < 1e-6);
    let slope = |theta: f64| value.gradient(&[0.0, 0.0, theta, 0.0]).unwrap()[2];
    assert!((slope(PI - 1e-9) - slope(-PI + 1e-9)).abs() < 1e-6 && slope(PI).abs() < 1e-6);
}

#[test]
fn nothing_is_returned_outside() {
    let value = tabulated(&|z| z[0] + 5.0);
    for z in [[2.1, 0.0, 0.0, 0.0], [0.0, -1.1, 0.0, 0.0], [0.0, 0.0, 0.0, -0.1], [f64::NAN, 0.0, 0.0, 0.0]] {
        assert_eq!(value.interpolate(&z), None);
        assert_eq!(value.gradient(&z), None);
    }
    assert_eq!(value.interpolate(&[0.0, 0.0, f64::INFINITY, 0.0]), None);
}

#[test]
fn files_survive_a_round_trip_and_are_the_same_bytes_each_time() {
    let value = tabulated(&|z| z[0].hypot(z[1]) - 0.7);
    let (first, second) = (OwnFile::new("first"), OwnFile::new("second"));
    value.save(&first.0).unwrap();
    let read: ValueFunction = ValueFunction::load(&first.0).unwrap();
    assert_eq!(read, value);
    read.save(&second.0).unwrap();
    assert_eq!(std::fs::read(&first.0).unwrap(), std::fs::read(&second.0).unwrap());
}

#[test]
fn damaged_and_foreign_files_are_told_apart() {
    let file = OwnFile::new("defects");
    tabulated(&|z| z[0].hypot(z[1]) - 0.7).save(&file.0).unwrap();
    let whole = std::fs::read(&file.0).unwrap();
    let load = |bytes: &[u8]| {
        std::fs::write(&file.0, bytes).unwrap();
        ValueFunction::<4>::load(&file.0).unwrap_err()
    };
    for length in [0, 7, 100, whole.len() / 2, whole.len() - 1] {
        assert!(matches!(load(&whole[..length]), ValueFileError::Damaged { .. }), "cut to {length} bytes");
    }
    let mut flipped = whole.clone();
    // The values are the last tensor, the axes come first.
    let last = flipped.len() - 2;
    flipped[last] ^= 1;
    let message = load(&flipped).to_string();
    assert!(message.contains("hashed") && message.contains("solve again"), "{message}");
    let foreign =
        safetensors::serialize(Vec::<(String, safetensors::tensor::TensorView<'_>)>::new(), None).unwrap();
    assert!(matches!(load(&foreign), ValueFileError::Foreign { .. }));
    std::fs::write(&file.0, &whole).unwrap();
    assert!(
        matches!(ValueFunction::<3>::load(&file.0), Err(ValueFileError::Foreign { .. })),
        "other dimension"
    );
    assert!(matches!(
        ValueFunction::<4>::load(&file.0.join("absent")),
        Err(ValueFileError::Io { action: "read", .. })
    ));
}

#[test]
fn bad_grids_are_refused_by_axis() {
    let good = Axis::bounded(-1.0, 1.0, 5);
    assert_eq!(Grid::new([good]), Err(GridError::Axes { axes: 1 }));
    assert_eq!(
        Grid::new([good, Axis::bounded(1.0, 1.0, 5)]),
        Err(GridError::Range { axis: 1, min: 1.0, max: 1.0 })
    );
    assert!(matches!(
        Grid::new([Axis::bounded(f64::NAN, 1.0, 5), good]),
        Err(GridError::Range { axis: 0, .. })
    ));
    assert_eq!(
        Grid::new([good, good, Axis::periodic(0.0, 1.0, 3)]),
        Err(GridError::TooFewNodes { axis: 2, count: 3 })
    );
    let huge = Axis::bounded(-1.0, 1.0, usize::MAX / 2);
    assert_eq!(Grid::new([huge, huge]), Err(GridError::TooManyNodes));
}

#[test]
fn axes_place_their_nodes() {
    let bounded = Axis::bounded(-6.0, 6.0, 80);
    assert_eq!(bounded.coordinate(0), -6.0);
    assert!((bounded.coordinate(79) - 6.0).abs() < 1e-12);
    let angle = Axis::periodic(-PI, PI, 20);
    assert!((angle.spacing() - PI / 10.0).abs() < 1e-15);
    assert!(angle.coordinate(19) < PI - 0.3, "the end is the first node again");
}
