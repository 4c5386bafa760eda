//! The truth of a model solved anew, from what its file says about its own game.

use std::ops::ControlFlow;

use barrier::{GridRecord, ModelMetadata};
use dynamics::RelativeDynamics;
use reachability::{
    Axis, Grid, ProblemDescription, Progress, SolverSettings, ValueFunction, disc_failure_function, solve,
};

use crate::error::VerificationError;
use crate::game::Game;

/// Why no truth could be solved from a model file.
#[derive(Debug, thiserror::Error)]
pub enum SolvedTruthError {
    /// The file does not say how its value function was solved.
    #[error(
        "the model does not say how its value function was solved ({0}); give a solved value file instead"
    )]
    NoRecord(serde_json::Error),
    /// Its game is none.
    #[error(transparent)]
    Game(#[from] VerificationError),
    /// Its grid is none.
    #[error("the model's grid: {0}")]
    Grid(#[from] reachability::GridError),
    /// The solve failed.
    #[error(transparent)]
    Solve(#[from] reachability::SolveError),
}

/// Solves the true game of a model, with its true boxes, on the grid and with the scheme that its file records.
///
/// What the model was trained on may have been solved for a stricter game; this is the one it is judged by.
///
/// # Errors
/// [`SolvedTruthError`].
pub fn solve_truth(
    metadata: &ModelMetadata,
    progress: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<ValueFunction, SolvedTruthError> {
    let mut record = metadata.solver.clone();
    // What came of the solve stands beside its settings.
    for result in ["horizon_s", "outcome"] {
        record.remove(result);
    }
    let settings =
        serde_json::from_value(record.into_iter().collect()).map_err(SolvedTruthError::NoRecord)?;
    match Game::of(metadata)? {
        Game::Unicycle(pair) => solve_pair(&pair, metadata, &settings, progress),
        Game::DoubleIntegrator(pair) => solve_pair(&pair, metadata, &settings, progress),
        Game::UnicycleStatic(pair) => solve_pair(&pair, metadata, &settings, progress),
    }
}

fn solve_pair<const NU: usize, const ND: usize>(
    pair: &impl RelativeDynamics<4, NU, ND>,
    metadata: &ModelMetadata,
    settings: &SolverSettings,
    progress: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<ValueFunction, SolvedTruthError> {
    let failure_radius_m = metadata.failure_radius_m;
    let GridRecord { min, max, count, periodic } = metadata.grid;
    let axis = |d: usize| Axis { min: min[d], max: max[d], count: count[d], periodic: periodic[d] };
    let grid = Grid::new(std::array::from_fn(axis))?;
    let solution = solve(pair, &disc_failure_function(failure_radius_m), &grid, settings, progress)?;
    let problem = ProblemDescription {
        dynamics: metadata.dynamics.to_string(),
        control: pair.control_box().into(),
        disturbance: pair.disturbance_box().into(),
        failure_radius_m,
    };
    Ok(ValueFunction::new(solution, problem))
}
