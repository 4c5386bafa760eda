//! The solve itself: `V(z, T) = ℓ(z)`, then backward in time until the zero level settles.

use crate::integrate::Stepper;
use crate::interior::Interior;
use crate::memory::refuse_what_does_not_fit;
use crate::{
    Checkpoint, CheckpointError, Grid, SettingsError, SolverSettings, TubeForm, memory_needed_at_most_bytes,
};
use dynamics::RelativeDynamics;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// What one convergence check found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HistoryEntry {
    /// Horizon reached, s.
    pub time_s: f64,
    /// `max |ΔV|` over the interior since the check before, m.
    pub max_change_m: f64,
    /// Share of all nodes with `V < 0`.
    pub unsafe_share: f64,
}

/// How a solve ended. Data, not an error: each may be what the caller wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The convergence test was met.
    Converged,
    /// The longest horizon was reached first.
    HorizonReached,
    /// The progress callback asked to stop.
    Interrupted,
}

/// State of a running solve, handed to the progress callback after each time step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Horizon reached so far, s.
    pub time_s: f64,
    /// Longest horizon, s.
    pub max_horizon_s: f64,
    /// Time steps done.
    pub steps: u64,
    /// Latest convergence check, if there was one.
    pub latest: Option<HistoryEntry>,
}

/// A solved value function on its grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution<const N: usize> {
    /// The grid.
    pub grid: Grid<N>,
    /// `V` per node, m, last axis fastest.
    pub values: Vec<f32>,
    /// Settings it was solved with.
    pub settings: SolverSettings,
    /// Horizon reached, s.
    pub horizon_s: f64,
    /// Time steps taken.
    pub steps: u64,
    /// Why it ended.
    pub outcome: Outcome,
    /// All convergence checks, oldest first.
    pub history: Vec<HistoryEntry>,
}

/// Why a solve gave no value function.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// A setting is out of range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The grid is too large for this machine.
    #[error(
        "this grid needs up to {needed_bytes} bytes and {available_bytes} are free; give fewer nodes per axis or free memory"
    )]
    Memory {
        /// What the solve may take.
        needed_bytes: u64,
        /// What the machine, or the control group this process is in, has left.
        available_bytes: u64,
    },
    /// The checkpoint cannot be used.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// The dynamics are NaN, infinite or beyond f32 at a node.
    #[error("the dynamics are not finite on the whole grid; shrink the grid or check the input limits")]
    NonFiniteDynamics,
    /// The failure function is NaN, infinite or beyond f32 at a node.
    #[error("the failure function is not finite on the whole grid; check the radius and the grid")]
    NonFiniteFailureFunction,
    /// The value left the range of numbers.
    #[error("the value function diverged before {time_s} s; lower `cfl`")]
    Diverged {
        /// Horizon of the check that noticed it, s.
        time_s: f64,
    },
}

/// State of a running solve between two time steps.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Running {
    pub(crate) values: Vec<f32>,
    pub(crate) at_last_check: Vec<f32>,
    pub(crate) clock: Clock,
}

/// The part of [`Running`] that is not per node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Clock {
    /// Horizon reached, s.
    pub(crate) time_s: f64,
    /// Time steps done.
    pub(crate) steps: u64,
    /// Horizon of the next convergence check, s.
    pub(crate) next_check_s: f64,
    /// Share of nodes with `V < 0` at the last check.
    pub(crate) last_share: f64,
    /// Checks so far, oldest first.
    pub(crate) history: Vec<HistoryEntry>,
}

/// Solves `min{∂V/∂t + H(z, ∇V), ℓ − V} = 0`, `V(z, T) = ℓ(z)` backward from `T` on all cores.
///
/// Source: paper, equation `hjb_vi`, with `H` of [`RelativeDynamics::hamiltonian`]. The zero-sublevel set of
/// the result is the backward reachable tube of `{ℓ ≤ 0}`: states from which the obstacle can force a
/// collision within the horizon reached. `∇V` is in m per state unit.
///
/// Numbers are f32 throughout, except the tabulation of the dynamics, the step size and the time (f64). The
/// result is the same for every number of threads and every vector width.
///
/// `progress` runs after every time step and may stop the solve.
///
/// # Errors
/// See [`SolveError`]; reaching the horizon without convergence is an [`Outcome`], not an error.
pub fn solve<const N: usize, const NU: usize, const ND: usize>(
    dynamics: &impl RelativeDynamics<N, NU, ND>,
    failure_function: &(dyn Fn(&[f64; N]) -> f64 + Sync),
    grid: &Grid<N>,
    settings: &SolverSettings,
    progress: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Solution<N>, SolveError> {
    solve_resumable(dynamics, failure_function, grid, settings, None, progress)
}

/// As [`solve`], and continues from `checkpoint` if the file is there, to the same bits as an uninterrupted solve.
///
/// The file is written every [`Checkpoint::every_steps`] time steps and when `progress` stops the solve. It stays when the
/// solve ends: remove it once the result is safe.
///
/// # Errors
/// As [`solve`], and [`SolveError::Checkpoint`] if the file cannot be written, is damaged, or belongs to other dynamics,
/// another grid or other settings.
pub fn solve_resumable<const N: usize, const NU: usize, const ND: usize>(
    dynamics: &impl RelativeDynamics<N, NU, ND>,
    failure_function: &(dyn Fn(&[f64; N]) -> f64 + Sync),
    grid: &Grid<N>,
    settings: &SolverSettings,
    checkpoint: Option<Checkpoint<'_>>,
    progress: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Solution<N>, SolveError> {
    settings.validate()?;
    refuse_what_does_not_fit(memory_needed_at_most_bytes(grid, NU + ND))?;
    let nodes = grid.node_count();
    let failure: Vec<f32> =
        (0..nodes).into_par_iter().map(|node| failure_function(&grid.state(node)) as f32).collect();
    if !failure.iter().all(|l| l.is_finite()) {
        return Err(SolveError::NonFiniteFailureFunction);
    }
    let mut stepper = Stepper::new(dynamics, grid, settings)?;
    let longest_step_s = stepper.longest_step_s();
    let interior = Interior::new(grid, stepper.coefficients(), settings.convergence.boundary_layer);
    let checkpoint = checkpoint.map(|c| c.identify(grid, settings, &failure, stepper.coefficients()));
    let ceiling = match settings.tube {
        TubeForm::Variational => Some(failure.as_slice()),
        TubeForm::Freezing => None,
    };

    let next_check_s =
        |time_s: f64| (time_s + settings.convergence.check_interval_s).min(settings.max_horizon_s);
    let resumed = checkpoint.as_ref().map_or(Ok(None), |c| c.read(nodes))?;
    let mut running = resumed.unwrap_or_else(|| Running {
        values: failure.clone(),
        at_last_check: failure.clone(),
        clock: Clock {
            time_s: 0.0,
            steps: 0,
            next_check_s: next_check_s(0.0),
            last_share: unsafe_share(&failure),
            history: Vec::new(),
        },
    });
    let outcome = 'solve: loop {
        let Running { clock: Clock { next_check_s: check_s, .. }, .. } = running;
        while running.clock.time_s < check_s {
            let time_s = running.clock.time_s;
            let last = check_s - time_s <= longest_step_s;
            let step_s = if last { check_s - time_s } else { longest_step_s };
            stepper.step(&mut running.values, step_s, ceiling);
            let clock = &mut running.clock;
            clock.time_s = if last { check_s } else { time_s + step_s };
            clock.steps += 1;
            let Clock { time_s, steps, .. } = *clock;
            let latest = clock.history.last().copied();
            let stop = progress(&Progress { time_s, max_horizon_s: settings.max_horizon_s, steps, latest })
                .is_break();
            if let Some(checkpoint) = &checkpoint
                && (stop || checkpoint.is_due(steps))
            {
                checkpoint.write(&running)?;
            }
            if stop {
                break 'solve Outcome::Interrupted;
            }
        }
        let Running { values, at_last_check, clock } = &mut running;
        if !values.iter().all(|v| v.is_finite()) {
            return Err(SolveError::Diverged { time_s: clock.time_s });
        }
        let entry = HistoryEntry {
            time_s: clock.time_s,
            max_change_m: interior.max_change(values, at_last_check),
            unsafe_share: unsafe_share(values),
        };
        clock.history.push(entry);
        at_last_check.copy_from_slice(values);
        let c = &settings.convergence;
        let level_settled = (entry.unsafe_share - clock.last_share).abs() < c.unsafe_share_tolerance;
        if level_settled && c.value_tolerance_m.is_none_or(|tolerance| entry.max_change_m < tolerance) {
            break Outcome::Converged;
        }
        if clock.time_s >= settings.max_horizon_s {
            break Outcome::HorizonReached;
        }
        clock.last_share = entry.unsafe_share;
        clock.next_check_s = next_check_s(clock.time_s);
    };
    let Running { values, clock: Clock { time_s, steps, history, .. }, .. } = running;
    if !values.iter().all(|v| v.is_finite()) {
        return Err(SolveError::Diverged { time_s });
    }
    Ok(Solution { grid: *grid, values, settings: *settings, horizon_s: time_s, steps, outcome, history })
}

fn unsafe_share(values: &[f32]) -> f64 {
    values.iter().filter(|v| **v < 0.0).count() as f64 / values.len() as f64
}
