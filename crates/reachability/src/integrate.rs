//! Time steps of the whole grid on all cores.
//!
//! Nodes are independent within an evaluation and nothing is summed across them, so the result does
//! not depend on the number of threads nor on the vector width.

use crate::coefficients::Coefficients;
use crate::operator::{Operator, Scratch};
use crate::{Grid, SolveError, SolverSettings, TimeIntegrator};
use dynamics::RelativeDynamics;
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

/// Weights of one evaluation: `out = keep · start + blend · (current + Δt Ĥ(current))`.
#[derive(Clone, Copy)]
struct Stage {
    keep: f32,
    blend: f32,
}

/// Steps a value backward in time on all cores: the inner part of [`solve`](crate::solve), for loops of one's own.
///
/// Everything is allocated when it is made, but for what the thread pool hands to its workers.
pub struct Stepper<const N: usize, const NU: usize, const ND: usize> {
    operator: Operator<N, NU, ND>,
    integrator: TimeIntegrator,
    longest_step_s: f64,
    arch: Arch,
    first: Vec<f32>,
    second: Vec<f32>,
}

impl<const N: usize, const NU: usize, const ND: usize> Stepper<N, NU, ND> {
    /// Tabulates `dynamics` on `grid`.
    ///
    /// # Errors
    /// * [`SolveError::Settings`] for a setting out of range.
    /// * [`SolveError::NonFiniteDynamics`] where the dynamics are NaN, infinite or beyond f32.
    pub fn new(
        dynamics: &impl RelativeDynamics<N, NU, ND>,
        grid: &Grid<N>,
        settings: &SolverSettings,
    ) -> Result<Self, SolveError> {
        settings.validate()?;
        let coefficients = Coefficients::new(dynamics, grid, settings.dissipation)?;
        let longest_step_s = settings.cfl / coefficients.largest_rate_per_s;
        let (integrator, nodes) = (settings.integrator, grid.node_count());
        let second = match integrator {
            TimeIntegrator::Euler => Vec::new(),
            TimeIntegrator::TvdRk2 | TimeIntegrator::TvdRk3 => vec![0.0; nodes],
        };
        Ok(Self {
            operator: Operator::new(coefficients, grid, settings.upwind, settings.tube),
            integrator,
            longest_step_s,
            arch: Arch::new(),
            first: vec![0.0; nodes],
            second,
        })
    }

    /// Returns the longest step the settings allow, s; infinite where nothing moves.
    pub fn longest_step_s(&self) -> f64 {
        self.longest_step_s
    }

    /// Returns the dynamics as tabulated.
    pub(crate) fn coefficients(&self) -> &Coefficients<N, NU, ND> {
        self.operator.coefficients()
    }

    /// Advances `values`, m per node, by `step_s` further into the past, then applies `V ← min(V, ceiling)`.
    ///
    /// # Panics
    /// If `values` or `ceiling` do not hold one number per node.
    pub fn step(&mut self, values: &mut Vec<f32>, step_s: f64, ceiling: Option<&[f32]>) {
        assert!(
            values.len() == self.first.len()
                && ceiling.is_none_or(|ceiling| ceiling.len() == self.first.len()),
            "one value per node"
        );
        let step = step_s as f32;
        let whole = Stage { keep: 0.0, blend: 1.0 };
        let mut first = std::mem::take(&mut self.first);
        match self.integrator {
            TimeIntegrator::Euler => self.evaluate(values, values, step, whole, ceiling, &mut first),
            TimeIntegrator::TvdRk2 => {
                let mut second = std::mem::take(&mut self.second);
                let half = Stage { keep: 0.5, blend: 0.5 };
                self.evaluate(values, values, step, whole, None, &mut first);
                self.evaluate(values, &first, step, half, ceiling, &mut second);
                std::mem::swap(&mut first, &mut second);
                self.second = second;
            }
            TimeIntegrator::TvdRk3 => {
                let mut second = std::mem::take(&mut self.second);
                let quarter = Stage { keep: 0.75, blend: 0.25 };
                let two_thirds = Stage { keep: 1.0 / 3.0, blend: 2.0 / 3.0 };
                self.evaluate(values, values, step, whole, None, &mut first);
                self.evaluate(values, &first, step, quarter, None, &mut second);
                self.evaluate(values, &second, step, two_thirds, ceiling, &mut first);
                self.second = second;
            }
        }
        std::mem::swap(values, &mut first);
        self.first = first;
    }

    fn evaluate(
        &self,
        start: &[f32],
        current: &[f32],
        step: f32,
        stage: Stage,
        ceiling: Option<&[f32]>,
        out: &mut [f32],
    ) {
        let len = self.operator.plane_len();
        // Several tasks per thread even out their ends.
        let planes_per_task = (out.len() / len).div_ceil(8 * rayon::current_num_threads());
        out.par_chunks_mut(len * planes_per_task).enumerate().for_each_init(
            || self.operator.scratch(),
            |scratch, (task, out)| {
                let first_plane = task * planes_per_task;
                let operator = &self.operator;
                self.arch.dispatch(Task {
                    operator,
                    start,
                    current,
                    step,
                    stage,
                    ceiling,
                    first_plane,
                    scratch,
                    out,
                });
            },
        );
    }
}

/// The planes that one worker evaluates in one go.
///
/// A type of its own rather than a closure: only what is always inlined is compiled for the vector width found at run
/// time, and a closure of this size is not.
struct Task<'a, const N: usize, const NU: usize, const ND: usize> {
    operator: &'a Operator<N, NU, ND>,
    start: &'a [f32],
    current: &'a [f32],
    step: f32,
    stage: Stage,
    ceiling: Option<&'a [f32]>,
    first_plane: usize,
    scratch: &'a mut Scratch<N>,
    out: &'a mut [f32],
}

impl<const N: usize, const NU: usize, const ND: usize> NullaryFnOnce for Task<'_, N, NU, ND> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let len = self.operator.plane_len();
        for (k, out) in self.out.chunks_exact_mut(len).enumerate() {
            let plane = self.first_plane + k;
            let nodes = plane * len..(plane + 1) * len;
            self.operator.rate(self.current, plane, self.scratch, out);
            blend(out, &self.start[nodes.clone()], &self.current[nodes.clone()], self.step, self.stage);
            if let Some(ceiling) = self.ceiling {
                lower_to(out, &ceiling[nodes]);
            }
        }
    }
}

/// Turns the rates in `out` into values.
#[inline(always)]
fn blend(out: &mut [f32], start: &[f32], current: &[f32], step: f32, Stage { keep, blend }: Stage) {
    for ((out, &start), &current) in out.iter_mut().zip(start).zip(current) {
        *out = keep * start + blend * (current + step * *out);
    }
}

/// `values ← min(values, ceiling)`; unlike `f32::min` a NaN stays, so that it is noticed.
#[inline(always)]
fn lower_to(values: &mut [f32], ceiling: &[f32]) {
    for (value, &ceiling) in values.iter_mut().zip(ceiling) {
        *value = if ceiling < *value { ceiling } else { *value };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Axis, Convergence, Dissipation, TubeForm, UpwindScheme};
    use dynamics::{InputBox, UnicyclePair};

    #[test]
    fn vector_width_does_not_matter() {
        let pair = UnicyclePair {
            control: InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap(),
            disturbance: InputBox::new([-0.35], [0.35]).unwrap(),
        };
        let grid = Grid::new([
            Axis::bounded(-3.0, 3.0, 11),
            Axis::bounded(-3.0, 3.0, 12),
            Axis::periodic(-3.0, 3.0, 7),
            Axis::bounded(0.0, 1.5, 5),
        ])
        .unwrap();
        let values = |arch: Arch| {
            let settings = SolverSettings {
                upwind: UpwindScheme::Weno5,
                integrator: TimeIntegrator::TvdRk3,
                dissipation: Dissipation::OptimalPlay,
                tube: TubeForm::Variational,
                cfl: 0.75,
                max_horizon_s: 1.0,
                convergence: Convergence {
                    check_interval_s: 1.0,
                    unsafe_share_tolerance: 0.0,
                    value_tolerance_m: None,
                    boundary_layer: 0.0,
                },
            };
            let mut stepper = Stepper::new(&pair, &grid, &settings).unwrap();
            stepper.arch = arch;
            let mut values: Vec<f32> = (0..grid.node_count())
                .map(|node| {
                    let z = grid.state(node);
                    (z[0].hypot(z[1]) - 0.7) as f32
                })
                .collect();
            for _ in 0..20 {
                stepper.step(&mut values, 0.02, None);
            }
            values
        };
        assert_eq!(values(Arch::new()), values(Arch::Scalar));
    }
}
