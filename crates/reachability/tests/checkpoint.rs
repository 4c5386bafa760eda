//! An interrupted solve goes on as if nothing had happened; a checkpoint of something else is refused.

#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not recognise as such

use dynamics::{InputBox, UnicyclePair};
use reachability::{
    Axis, Checkpoint, CheckpointError, Convergence, Dissipation, Grid, Outcome, Solution, SolveError,
    SolverSettings, TimeIntegrator, TubeForm, UpwindScheme, disc_failure_function, solve_resumable,
};
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::path::Path;

fn pair(turn_rate_radps: f64) -> UnicyclePair {
    UnicyclePair {
        control: InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap(),
        disturbance: InputBox::new([-turn_rate_radps], [turn_rate_radps]).unwrap(),
    }
}

fn settings() -> SolverSettings {
    SolverSettings {
        upwind: UpwindScheme::Weno3,
        integrator: TimeIntegrator::TvdRk3,
        dissipation: Dissipation::OptimalPlay,
        tube: TubeForm::Variational,
        cfl: 0.75,
        max_horizon_s: 1.3,
        convergence: Convergence {
            check_interval_s: 0.5,
            unsafe_share_tolerance: 0.0,
            value_tolerance_m: None,
            boundary_layer: 0.0,
        },
    }
}

/// Solves, and stops after `stop_after` steps in all if given.
fn attempt(
    turn_rate_radps: f64,
    radius_m: f64,
    settings: &SolverSettings,
    checkpoint: Option<Checkpoint<'_>>,
    stop_after: Option<u64>,
) -> Result<Solution<4>, SolveError> {
    let grid = Grid::new([
        Axis::bounded(-4.0, 4.0, 17),
        Axis::bounded(-4.0, 4.0, 17),
        Axis::periodic(-PI, PI, 12),
        Axis::bounded(0.0, 1.5, 4),
    ])
    .unwrap();
    let failure = disc_failure_function(radius_m);
    solve_resumable(&pair(turn_rate_radps), &failure, &grid, settings, checkpoint, &mut |progress| {
        if Some(progress.steps) == stop_after { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })
}

#[test]
fn an_interrupted_solve_resumes_to_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("solve.checkpoint");
    let whole = attempt(0.35, 0.7, &settings(), None, None).unwrap();
    assert!(whole.steps > 20, "{} steps leave no room for interruptions", whole.steps);
    // Before, at and after a convergence check.
    for stop in [3, whole.steps / 2, whole.steps - 1] {
        let checkpoint = Some(Checkpoint { path: &path, every_steps: 0 });
        let stopped = attempt(0.35, 0.7, &settings(), checkpoint, Some(stop)).unwrap();
        assert_eq!((stopped.outcome, stopped.steps), (Outcome::Interrupted, stop));
    }
    let resumed = attempt(0.35, 0.7, &settings(), Some(Checkpoint::at(&path)), None).unwrap();
    assert_eq!(resumed, whole);
}

#[test]
fn a_killed_solve_loses_only_the_steps_since_the_last_write() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("solve.checkpoint");
    let checkpoint = Some(Checkpoint { path: &path, every_steps: 7 });
    let whole = attempt(0.35, 0.7, &settings(), checkpoint, None).unwrap();
    // What a kill leaves behind is the file of the last multiple of seven; a write in progress is another file.
    std::fs::write(folder.path().join("solve.checkpoint.unfinished"), "half").unwrap();
    let mut first_step = 0;
    let grid = whole.grid;
    let failure = disc_failure_function(0.7);
    let resumed = solve_resumable(&pair(0.35), &failure, &grid, &settings(), checkpoint, &mut |progress| {
        if first_step == 0 {
            first_step = progress.steps;
        }
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(first_step, whole.steps / 7 * 7 + 1);
    assert_eq!(resumed, whole);
}

#[test]
fn checkpoints_of_other_problems_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("solve.checkpoint");
    let checkpoint = Some(Checkpoint::at(&path));
    attempt(0.35, 0.7, &settings(), checkpoint, Some(5)).unwrap();
    let faster = SolverSettings { cfl: 0.7, ..settings() };
    for (turn_rate, radius_m, settings) in
        [(0.36, 0.7, settings()), (0.35, 0.71, settings()), (0.35, 0.7, faster)]
    {
        let error = attempt(turn_rate, radius_m, &settings, checkpoint, None).unwrap_err();
        assert_eq!(error, SolveError::Checkpoint(CheckpointError::OtherProblem { path: path.clone() }));
        assert!(error.to_string().contains("remove the file"), "{error}");
    }
    assert!(
        attempt(0.35, 0.7, &settings(), checkpoint, None).is_ok(),
        "the refusals left the file as it was"
    );
}

#[test]
fn damaged_and_foreign_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("solve.checkpoint");
    let checkpoint = Some(Checkpoint::at(&path));
    attempt(0.35, 0.7, &settings(), checkpoint, Some(5)).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let refused = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        let error = attempt(0.35, 0.7, &settings(), checkpoint, None).unwrap_err();
        assert!(matches!(error, SolveError::Checkpoint(CheckpointError::Damaged { .. })), "{error}");
    };
    refused(&bytes[..bytes.len() - 1]);
    refused(b"a shopping list");
    let mut flipped = bytes.clone();
    *flipped.last_mut().unwrap() ^= 1;
    refused(&flipped);
    let nowhere = Checkpoint::at(Path::new("/nonexistent/solve.checkpoint"));
    let error = attempt(0.35, 0.7, &settings(), Some(nowhere), Some(1)).unwrap_err();
    assert!(matches!(error, SolveError::Checkpoint(CheckpointError::Io { action: "write", .. })), "{error}");
}
