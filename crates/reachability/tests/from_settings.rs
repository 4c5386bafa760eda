//! The settings file reaches the solver unchanged.

#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not recognise as such

use reachability::{
    Grid, Outcome, Progress, SettingsSolveError, SolveError, TimeIntegrator, TubeForm, UpwindScheme,
    memory_needed_at_most_bytes, memory_of_settings_bytes, solve_settings, solve_settings_resumable,
};
use settings::{Accuracy, ObstacleMotion, RobotKind, Settings, SlackSettings};
use std::ops::ControlFlow;
use std::path::Path;

/// The shipped settings on a grid small enough for a test.
fn small() -> Settings {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/ground_robot_paper.toml");
    let mut settings = Settings::load(&path).unwrap();
    let offline = settings.offline.as_mut().unwrap();
    offline.grid.count = [13, 13, 8, 4];
    offline.solver.max_horizon_s = 0.5;
    offline.solver.unsafe_share_tolerance = 0.0;
    settings
}

#[test]
fn shipped_settings_describe_the_papers_game() {
    let value = solve_settings(&small(), &mut |_| ControlFlow::Continue(())).unwrap();
    let metadata = value.metadata();
    assert_eq!(metadata.problem.dynamics, "unicycle_pair");
    assert_eq!(metadata.problem.control.min, [0.25, -0.8]);
    assert_eq!(metadata.problem.control.max, [1.0, 0.8]);
    assert_eq!(metadata.problem.disturbance.max, [0.35]);
    assert_eq!(metadata.problem.failure_radius_m, 0.7);
    assert_eq!(metadata.solver.upwind, UpwindScheme::Weno3);
    assert_eq!(metadata.solver.tube, TubeForm::Variational);
    assert_eq!((metadata.outcome, metadata.horizon_s), (Outcome::HorizonReached, 0.5));
    assert_eq!(value.grid().shape(), [13, 13, 8, 4]);
    assert!(value.grid().axes()[2].periodic && !value.grid().axes()[3].periodic);
}

#[test]
fn the_robots_kind_chooses_the_dynamics() {
    let mut settings = small();
    settings.robot.kind = RobotKind::DoubleIntegrator;
    let error = solve_settings(&settings, &mut |_| ControlFlow::Continue(())).unwrap_err();
    assert!(matches!(error, SettingsSolveError::Disturbance(_)), "one turn rate is no pair of accelerations");
    settings.robot.control_min = [-2.0; 2];
    settings.robot.control_max = [2.0; 2];
    settings.obstacle.disturbance_min = vec![-1.0; 2];
    settings.obstacle.disturbance_max = vec![1.0; 2];
    let value = solve_settings(&settings, &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(value.metadata().problem.dynamics, "double_integrator_pair");
}

#[test]
fn what_the_file_lacks_is_named() {
    let mut settings = small();
    settings.offline = None;
    let error = solve_settings(&settings, &mut |_| ControlFlow::Continue(())).unwrap_err();
    assert!(error.to_string().contains("`offline`"), "{error}");
}

#[test]
fn standing_obstacles_have_a_pair_of_their_own() {
    let mut settings = small();
    settings.obstacle.motion = ObstacleMotion::Static;
    let error = solve_settings(&settings, &mut |_| ControlFlow::Continue(())).unwrap_err();
    assert!(matches!(error, SettingsSolveError::Disturbance(_)), "a turn rate of something that stands");
    settings.obstacle.disturbance_min.clear();
    settings.obstacle.disturbance_max.clear();
    let value = solve_settings(&settings, &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(value.metadata().problem.dynamics, "unicycle_static_pair");
    assert!(value.metadata().problem.disturbance.min.is_empty());
    let at = |heading, speed| value.interpolate(&[1.5, 0.2, heading, speed]).unwrap();
    assert_eq!(at(0.0, 0.0), at(1.0, 1.5), "heading and speed do not matter");
    settings.robot.kind = RobotKind::DoubleIntegrator;
    let error = solve_settings(&settings, &mut |_| ControlFlow::Continue(())).unwrap_err();
    assert_eq!(error, SettingsSolveError::StaticForDoubleIntegrator);
}

#[test]
fn slack_solves_a_stricter_game_and_says_so() {
    let mut settings = small();
    let plain = solve_settings(&settings, &mut |_| ControlFlow::Continue(())).unwrap();
    let slack = SlackSettings { control_scale: 0.8, disturbance_scale: 1.5 };
    settings.offline.as_mut().unwrap().slack = Some(slack);
    let strict = solve_settings(&settings, &mut |_| ControlFlow::Continue(())).unwrap();
    let game = settings.training_game();
    assert_eq!(strict.metadata().problem.control.min, game.control_min);
    assert_eq!(strict.metadata().problem.disturbance.max, game.disturbance_max);
    let lower =
        plain.values().iter().zip(strict.values()).filter(|(plain, strict)| **strict < **plain - 1e-3);
    assert!(lower.count() > 100, "a weaker robot is safe in fewer states");
}

#[test]
fn accuracies_are_hj_reachabilitys() {
    use {TimeIntegrator as Time, UpwindScheme as Space};
    let mut solver = small().offline.unwrap().solver;
    for (accuracy, upwind, integrator) in [
        (Accuracy::Low, Space::FirstOrder, Time::Euler),
        (Accuracy::Medium, Space::Eno2, Time::TvdRk2),
        (Accuracy::High, Space::Weno3, Time::TvdRk3),
        (Accuracy::VeryHigh, Space::Weno5, Time::TvdRk3),
    ] {
        solver.accuracy = accuracy;
        let settings = reachability::SolverSettings::from(&solver);
        assert_eq!((settings.upwind, settings.integrator), (upwind, integrator));
    }
}

#[test]
fn a_solve_of_settings_resumes_and_refuses_other_settings() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ground_robot.checkpoint");
    let mut settings = small();
    let whole = solve_settings(&settings, &mut |_| ControlFlow::Continue(())).unwrap();
    let stop_at_three = &mut |progress: &Progress| {
        if progress.steps == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let stopped = solve_settings_resumable(&settings, Some(&path), stop_at_three).unwrap();
    assert_eq!((stopped.metadata().outcome, stopped.metadata().steps), (Outcome::Interrupted, 3));
    let resumed =
        solve_settings_resumable(&settings, Some(&path), &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(resumed, whole);
    settings.obstacle.radius_m += 0.1;
    let error =
        solve_settings_resumable(&settings, Some(&path), &mut |_| ControlFlow::Continue(())).unwrap_err();
    assert!(matches!(error, SettingsSolveError::Solve(SolveError::Checkpoint(_))), "{error}");
}

#[test]
fn the_memory_of_settings_is_that_of_their_grid() {
    let mut settings = small();
    let bytes = memory_of_settings_bytes(&settings).unwrap();
    assert_eq!(
        bytes,
        memory_needed_at_most_bytes(
            &Grid::<4>::try_from(&settings.offline.as_ref().unwrap().grid).unwrap(),
            3
        )
    );
    settings.offline.as_mut().unwrap().grid.count = [2_000; 4];
    let error = solve_settings(&settings, &mut |_| ControlFlow::Continue(())).unwrap_err();
    assert!(matches!(error, SettingsSolveError::Solve(SolveError::Memory { .. })), "{error}");
}
