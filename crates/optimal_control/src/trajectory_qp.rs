//! The quadratic program of one SQP iteration, in Clarabel's sparse form.
//!
//! Variables are the changes `[δu₀, δx₁, δu₁, …, δx_N]`, then one slack for each inequality; rows are the linearised
//! dynamics (equalities), then the upper and the lower ends of the input box, the linearised inequalities softened by
//! their slacks, and the slacks' own sign. The pattern is built once: later calls overwrite values only.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, ZeroConeT};

use crate::constraints::ConstraintRow;
use crate::dynamics::Linearisation;
use crate::sqp_settings::SqpSetupError;

/// Relative gap and infeasibility at which a QP counts as solved: its step is judged by the cost anyway, and changes of
/// the controls below 1e-4 end the search.
const QP_TOLERANCE: f64 = 1e-6;
/// Interior-point steps after which a QP counts as failed; ten to twenty are usual.
const QP_ITERATION_LIMIT: u32 = 60;

/// What one iteration hands to the QP, stage by stage; `[k]` for `u_k` and `x_k → x_{k+1}`.
#[derive(Debug, Clone)]
pub(crate) struct Stage<const NX: usize, const NU: usize> {
    pub(crate) jacobians: Linearisation<NX, NU>,
    /// Half the gradient of the cost by `u_k` and by `x_{k+1}`.
    pub(crate) gradient: ([f64; NU], [f64; NX]),
    /// Diagonal of half the Hessian by `u_k` and by `x_{k+1}`.
    pub(crate) hessian: ([f64; NU], [f64; NX]),
    /// `δu_k` is within `[−to_lower, to_upper]`.
    pub(crate) to_upper: [f64; NU],
    pub(crate) to_lower: [f64; NU],
}

/// Which entries of the Jacobians and of an inequality's gradient are stored.
pub(crate) type Sparsity<const NX: usize, const NU: usize> = (Linearisation<NX, NU>, ConstraintRow<NX, NU>);

/// A Clarabel solver with the buffers through which its data are overwritten.
pub(crate) struct TrajectoryQp<const NX: usize, const NU: usize> {
    solver: DefaultSolver<f64>,
    sparsity: Sparsity<NX, NU>,
    /// Half the price of a slack, as all costs here are halved.
    slack_price: f64,
    hessian: Vec<f64>,
    gradient: Vec<f64>,
    constraints: Vec<f64>,
    bounds: Vec<f64>,
}

/// What a QP gave.
pub(crate) struct QpAnswer<'a> {
    /// The changes in the order of the variables; `None` unless Clarabel vouches for a finite solution.
    pub(crate) change: Option<&'a [f64]>,
    /// Interior-point steps taken.
    pub(crate) iterations: u32,
}

impl<const NX: usize, const NU: usize> TrajectoryQp<NX, NU> {
    /// Builds the pattern. Clarabel derives its scaling from the values of `stages` and `rows`, so these should be typical.
    ///
    /// `violation_weight` is the cost of one unit of a violated row.
    pub(crate) fn new(
        stages: &[Stage<NX, NU>],
        inequalities: &[ConstraintRow<NX, NU>],
        violation_weight: f64,
        sparsity: Sparsity<NX, NU>,
    ) -> Result<Self, SqpSetupError> {
        let steps = stages.len();
        let slack_price = 0.5 * violation_weight;
        let (variables, equalities) = (steps * (NX + NU) + inequalities.len(), steps * NX);
        let signed = 2 * steps * NU + 2 * inequalities.len();
        let rows = equalities + signed;
        let mut entries = Vec::new();
        for_each_entry(stages, inequalities, &sparsity, |column, row, value| {
            entries.push((column, row, value));
        });
        let mut column_starts = vec![0; variables + 1];
        for &(column, _, _) in &entries {
            column_starts[column + 1] += 1;
        }
        for column in 0..variables {
            column_starts[column + 1] += column_starts[column];
        }
        let row_indices = entries.iter().map(|entry| entry.1).collect();
        let constraints: Vec<f64> = entries.iter().map(|entry| entry.2).collect();
        let mut hessian = Vec::with_capacity(variables);
        let mut gradient = Vec::with_capacity(variables);
        let mut bounds = Vec::with_capacity(rows);
        fill_vectors(stages, inequalities, slack_price, &mut hessian, &mut gradient, &mut bounds);

        let p = CscMatrix::new(
            variables,
            variables,
            (0..=variables).collect(),
            (0..variables).collect(),
            hessian.clone(),
        );
        let a = CscMatrix::new(rows, variables, column_starts, row_indices, constraints.clone());
        let cones = [ZeroConeT(equalities), NonnegativeConeT(signed)];
        let settings = DefaultSettings {
            verbose: false,
            max_iter: QP_ITERATION_LIMIT,
            tol_gap_abs: QP_TOLERANCE,
            tol_gap_rel: QP_TOLERANCE,
            tol_feas: QP_TOLERANCE,
            // Two fifths of the time, for digits below the tolerance; residuals are checked at the end all the same.
            iterative_refinement_enable: false,
            // Both would change the pattern and thereby forbid data updates.
            presolve_enable: false,
            input_sparse_dropzeros: false,
            ..DefaultSettings::default()
        };
        let solver = DefaultSolver::new(&p, &gradient, &a, &bounds, &cones, settings)
            .map_err(|error| SqpSetupError::Qp { reason: error.to_string() })?;
        Ok(Self { solver, sparsity, slack_price, hessian, gradient, constraints, bounds })
    }

    /// Solves the QP of `stages` and `inequalities`, which number as at construction.
    ///
    /// Where it succeeds, `multipliers` take those of the inequalities, of the halved cost.
    pub(crate) fn solve(
        &mut self,
        stages: &[Stage<NX, NU>],
        inequalities: &[ConstraintRow<NX, NU>],
        multipliers: &mut [f64],
    ) -> QpAnswer<'_> {
        self.constraints.clear();
        let constraints = &mut self.constraints;
        for_each_entry(stages, inequalities, &self.sparsity, |_, _, value| constraints.push(value));
        let (hessian, gradient) = (&mut self.hessian, &mut self.gradient);
        fill_vectors(stages, inequalities, self.slack_price, hessian, gradient, &mut self.bounds);
        let updated = self.solver.update_data(&self.hessian, &self.gradient, &self.constraints, &self.bounds);
        if updated.is_err() {
            return QpAnswer { change: None, iterations: 0 };
        }
        self.solver.solve();
        let solution = &self.solver.solution;
        let vouched = match solution.status {
            // The caller tests the direction by the cost it leads to, so reduced accuracy will do.
            SolverStatus::Solved | SolverStatus::AlmostSolved => {
                solution.x.iter().all(|value| value.is_finite())
            }
            SolverStatus::Unsolved
            | SolverStatus::PrimalInfeasible
            | SolverStatus::DualInfeasible
            | SolverStatus::AlmostPrimalInfeasible
            | SolverStatus::AlmostDualInfeasible
            | SolverStatus::MaxIterations
            | SolverStatus::MaxTime
            | SolverStatus::NumericalError
            | SolverStatus::InsufficientProgress
            | SolverStatus::CallbackTerminated => false,
        };
        if vouched {
            let first = stages.len() * (NX + 2 * NU);
            multipliers.copy_from_slice(&solution.z[first..first + inequalities.len()]);
        }
        QpAnswer { change: vouched.then_some(solution.x.as_slice()), iterations: solution.iterations }
    }
}

/// Visits the entries of the constraint matrix column by column, rows ascending: Clarabel's order.
fn for_each_entry<const NX: usize, const NU: usize>(
    stages: &[Stage<NX, NU>],
    inequalities: &[ConstraintRow<NX, NU>],
    (jacobians, gradients): &Sparsity<NX, NU>,
    mut visit: impl FnMut(usize, usize, f64),
) {
    let steps = stages.len();
    let per_step = inequalities.len() / steps;
    let upper = steps * NX;
    let lower = upper + steps * NU;
    let softened = lower + steps * NU;
    let mut column = 0;
    for (k, stage) in stages.iter().enumerate() {
        let own = k * per_step..(k + 1) * per_step;
        for j in 0..NU {
            for i in (0..NX).filter(|&i| jacobians.by_control[i][j] != 0.0) {
                visit(column, k * NX + i, -stage.jacobians.by_control[i][j]);
            }
            visit(column, upper + k * NU + j, 1.0);
            visit(column, lower + k * NU + j, -1.0);
            if gradients.by_control[j] != 0.0 {
                own.clone().for_each(|m| visit(column, softened + m, -inequalities[m].by_control[j]));
            }
            column += 1;
        }
        for j in 0..NX {
            visit(column, k * NX + j, 1.0);
            let next = stages.get(k + 1);
            if let Some(next) = next {
                for i in (0..NX).filter(|&i| jacobians.by_state[i][j] != 0.0) {
                    visit(column, (k + 1) * NX + i, -next.jacobians.by_state[i][j]);
                }
            }
            if gradients.by_next[j] != 0.0 {
                own.clone().for_each(|m| visit(column, softened + m, -inequalities[m].by_next[j]));
            }
            if gradients.by_state[j] != 0.0 && next.is_some() {
                let following = own.end..own.end + per_step;
                following.for_each(|m| visit(column, softened + m, -inequalities[m].by_state[j]));
            }
            column += 1;
        }
    }
    for m in 0..inequalities.len() {
        visit(column, softened + m, -1.0);
        visit(column, softened + inequalities.len() + m, -1.0);
        column += 1;
    }
}

/// Rewrites the vectors of the QP within their capacity.
fn fill_vectors<const NX: usize, const NU: usize>(
    stages: &[Stage<NX, NU>],
    inequalities: &[ConstraintRow<NX, NU>],
    slack_price: f64,
    hessian: &mut Vec<f64>,
    gradient: &mut Vec<f64>,
    bounds: &mut Vec<f64>,
) {
    hessian.clear();
    gradient.clear();
    bounds.clear();
    for stage in stages {
        hessian.extend_from_slice(&stage.hessian.0);
        hessian.extend_from_slice(&stage.hessian.1);
        gradient.extend_from_slice(&stage.gradient.0);
        gradient.extend_from_slice(&stage.gradient.1);
    }
    hessian.resize(hessian.len() + inequalities.len(), 0.0);
    gradient.resize(hessian.len(), slack_price);
    // The linearisation is taken at a trajectory that obeys the dynamics: no gaps to close.
    bounds.resize(stages.len() * NX, 0.0);
    for stage in stages {
        bounds.extend_from_slice(&stage.to_upper);
    }
    for stage in stages {
        bounds.extend_from_slice(&stage.to_lower);
    }
    bounds.extend(inequalities.iter().map(|row| row.value));
    bounds.resize(bounds.len() + inequalities.len(), 0.0);
}
