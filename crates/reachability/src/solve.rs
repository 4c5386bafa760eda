//! The solve itself: `V(z, T) = ℓ(z)`, then backward in time until the zero level settles.

use crate::coefficients::Coefficients;
use crate::integrate::Stepper;
use crate::operator::Operator;
use crate::{Grid, SettingsError, SolverSettings, TubeForm};
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
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// A setting is out of range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
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

/// Returns a bound on the heap a solve takes, bytes, for `inputs` control and disturbance components together.
///
/// Five values per node (value, failure function, value at the last check, two stages of the time step), one
/// while the dynamics are tabulated, and the table itself, counted as if no coefficient could be compressed.
pub fn memory_needed_at_most_bytes<const N: usize>(grid: &Grid<N>, inputs: usize) -> u64 {
    let table = N * (2 + inputs);
    grid.node_count() as u64 * (5 + 1 + table) as u64 * size_of::<f32>() as u64
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
    settings.validate()?;
    let nodes = grid.node_count();
    let failure: Vec<f32> =
        (0..nodes).into_par_iter().map(|node| failure_function(&grid.state(node)) as f32).collect();
    if !failure.iter().all(|l| l.is_finite()) {
        return Err(SolveError::NonFiniteFailureFunction);
    }
    let coefficients = Coefficients::new(dynamics, grid, settings.dissipation)?;
    let longest_step_s = settings.cfl / coefficients.largest_rate_per_s;
    let interior = Interior::new(grid, &coefficients, settings.convergence.boundary_layer);
    let operator = Operator::new(coefficients, grid, settings.upwind, settings.tube);
    let mut stepper = Stepper::new(operator, settings.integrator, nodes);
    let ceiling = match settings.tube {
        TubeForm::Variational => Some(failure.as_slice()),
        TubeForm::Freezing => None,
    };

    let mut values = failure.clone();
    let mut at_last_check = failure.clone();
    let mut history: Vec<HistoryEntry> = Vec::new();
    let (mut time_s, mut steps) = (0.0, 0);
    let mut last_share = unsafe_share(&values);
    let outcome = 'solve: loop {
        let check_s = (time_s + settings.convergence.check_interval_s).min(settings.max_horizon_s);
        while time_s < check_s {
            let last = check_s - time_s <= longest_step_s;
            let step_s = if last { check_s - time_s } else { longest_step_s };
            stepper.step(&mut values, step_s, ceiling);
            time_s = if last { check_s } else { time_s + step_s };
            steps += 1;
            let latest = history.last().copied();
            let state = Progress { time_s, max_horizon_s: settings.max_horizon_s, steps, latest };
            if progress(&state).is_break() {
                break 'solve Outcome::Interrupted;
            }
        }
        if !values.iter().all(|v| v.is_finite()) {
            return Err(SolveError::Diverged { time_s });
        }
        let entry = HistoryEntry {
            time_s,
            max_change_m: interior.max_change(&values, &at_last_check),
            unsafe_share: unsafe_share(&values),
        };
        history.push(entry);
        at_last_check.copy_from_slice(&values);
        let c = &settings.convergence;
        let level_settled = (entry.unsafe_share - last_share).abs() < c.unsafe_share_tolerance;
        if level_settled && c.value_tolerance_m.is_none_or(|tolerance| entry.max_change_m < tolerance) {
            break Outcome::Converged;
        }
        if time_s >= settings.max_horizon_s {
            break Outcome::HorizonReached;
        }
        last_share = entry.unsafe_share;
    };
    if !values.iter().all(|v| v.is_finite()) {
        return Err(SolveError::Diverged { time_s });
    }
    Ok(Solution { grid: *grid, values, settings: *settings, horizon_s: time_s, steps, outcome, history })
}

fn unsafe_share(values: &[f32]) -> f64 {
    values.iter().filter(|v| **v < 0.0).count() as f64 / values.len() as f64
}

/// The nodes away from extrapolated ends.
struct Interior<const N: usize> {
    grid: Grid<N>,
    /// First and last interior index per axis.
    range: [(usize, usize); N],
}

impl<const N: usize> Interior<N> {
    fn new<const NU: usize, const ND: usize>(
        grid: &Grid<N>,
        coefficients: &Coefficients<N, NU, ND>,
        boundary_layer: f64,
    ) -> Self {
        let range = std::array::from_fn(|d| {
            let axis = grid.axes()[d];
            // Nothing is extrapolated along an axis that closes on itself or never moves.
            let exact = axis.periodic || coefficients.dissipation[d].is_zero();
            let layer = if exact { 0 } else { (boundary_layer * axis.count as f64).floor() as usize };
            (layer, axis.count - 1 - layer)
        });
        Self { grid: *grid, range }
    }

    fn max_change(&self, values: &[f32], before: &[f32]) -> f64 {
        let largest = (0..values.len())
            .into_par_iter()
            .filter(|&node| {
                let index = self.grid.index(node);
                (0..N).all(|d| (self.range[d].0..=self.range[d].1).contains(&index[d]))
            })
            .map(|node| (values[node] - before[node]).abs())
            .reduce(|| 0.0, f32::max);
        f64::from(largest)
    }
}
