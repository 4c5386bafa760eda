//! Linear-quadratic regulators in continuous and discrete time: argument checks, gain, and the proof of stability.
//! The Riccati equations themselves are in `riccati`.

use nalgebra::{Complex, DMatrix};

use crate::detectability::{TimeKind, unreachable_mode, unseen_mode};
use crate::riccati;

/// An optimal linear state feedback `u = −K x`.
#[derive(Debug, Clone, PartialEq)]
pub struct Lqr {
    /// `K`, `[nu × nx]`; units of the input per unit of the state.
    pub gain: DMatrix<f64>,
    /// `P`, `[nx × nx]`, symmetric: the cost to go from `x` is `xᵀ P x`.
    pub riccati_solution: DMatrix<f64>,
}

/// Why there is no regulator for these matrices.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LqrError {
    /// A matrix does not fit the others.
    #[error("{matrix} is {rows}x{columns}, expected {expected_rows}x{expected_columns}")]
    Shape {
        /// Its name in the equations.
        matrix: &'static str,
        /// Rows it has.
        rows: usize,
        /// Columns it has.
        columns: usize,
        /// Rows it needs.
        expected_rows: usize,
        /// Columns it needs.
        expected_columns: usize,
    },
    /// There is no state or no input.
    #[error("A and B must have at least one row and one column")]
    Empty,
    /// A NaN or an infinity.
    #[error("{matrix} holds a value that is not finite")]
    NonFinite {
        /// Its name in the equations.
        matrix: &'static str,
    },
    /// A weight differs from its transpose.
    #[error("{matrix} is not symmetric; use ({matrix} + {matrix}')/2")]
    Asymmetric {
        /// Its name in the equations.
        matrix: &'static str,
    },
    /// `R` lets some input cost nothing or less.
    #[error("R is not positive definite; give every input a positive weight")]
    IndefiniteControlWeight,
    /// `Q` rewards being away from the origin.
    #[error("Q is not positive semidefinite: its smallest eigenvalue is {smallest_eigenvalue}")]
    IndefiniteStateWeight {
        /// How negative.
        smallest_eigenvalue: f64,
    },
    /// No feedback can stabilise `(A, B)`.
    #[error("the mode {mode} does not die out and no input reaches it; remove that state or add an input")]
    NotStabilisable {
        /// An eigenvalue of `A`.
        mode: Complex<f64>,
    },
    /// The cost ignores a mode that does not die out, so the cheapest feedback leaves it alone.
    #[error("the mode {mode} does not die out and Q does not weigh it; weigh that state")]
    NotDetectable {
        /// An eigenvalue of `A`.
        mode: Complex<f64>,
    },
    /// The iteration failed, or its result does not solve the equation or does not stabilise the system.
    #[error("no stabilising Riccati solution found; rescale states and inputs so that entries are near one")]
    IllConditioned,
}

/// Gain that minimises `∫ xᵀQx + uᵀRu dt` for `ẋ = A x + B u`.
///
/// Solves `AᵀP + PA − P B R⁻¹ Bᵀ P + Q = 0`, `K = R⁻¹ Bᵀ P`.
///
/// # Shapes
/// `A` `[nx × nx]`, `B` `[nx × nu]`, `Q` `[nx × nx]` positive semidefinite, `R` `[nu × nu]` positive definite.
///
/// # Errors
/// One variant of [`LqrError`] per broken assumption. What is returned was checked: it solves the equation and
/// `A − B K` is stable.
pub fn continuous_lqr(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
) -> Result<Lqr, LqrError> {
    check(a, b, q, r, TimeKind::Continuous)?;
    let r_factor = r.clone().cholesky().ok_or(LqrError::IndefiniteControlWeight)?;
    let g = b * r_factor.solve(&b.transpose());
    let p = riccati::continuous(a, &g, q).ok_or(LqrError::IllConditioned)?;
    let residual = a.transpose() * &p + &p * a - &p * &g * &p + q;
    let scale = (a.transpose() * &p).norm() + (&p * &g * &p).norm() + q.norm();
    let gain = r_factor.solve(&(b.transpose() * &p));
    accept(a, b, Lqr { gain, riccati_solution: p }, residual.norm() / scale, TimeKind::Continuous)
}

/// Gain that minimises `Σ xᵀQx + uᵀRu` for `x⁺ = A x + B u`.
///
/// Solves `P = AᵀPA − AᵀPB (R + BᵀPB)⁻¹ BᵀPA + Q`, `K = (R + BᵀPB)⁻¹ BᵀPA`.
///
/// # Shapes
/// As for [`continuous_lqr`].
///
/// # Errors
/// As for [`continuous_lqr`].
pub fn discrete_lqr(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
) -> Result<Lqr, LqrError> {
    check(a, b, q, r, TimeKind::Discrete)?;
    let r_factor = r.clone().cholesky().ok_or(LqrError::IndefiniteControlWeight)?;
    let g = b * r_factor.solve(&b.transpose());
    let p = riccati::discrete(a, &g, q).ok_or(LqrError::IllConditioned)?;
    let gain =
        (r + b.transpose() * &p * b).lu().solve(&(b.transpose() * &p * a)).ok_or(LqrError::IllConditioned)?;
    let propagated = a.transpose() * &p * a;
    let residual = &propagated - a.transpose() * &p * b * &gain + q - &p;
    let scale = propagated.norm() + p.norm() + q.norm();
    accept(a, b, Lqr { gain, riccati_solution: p }, residual.norm() / scale, TimeKind::Discrete)
}

/// Residual of the Riccati equation, relative to its largest terms, above which the solution is not trusted.
const RESIDUAL_LIMIT: f64 = 1e-9;
/// Asymmetry and negative eigenvalues, relative to the matrix, that count as rounding.
const ROUNDING: f64 = 1e-12;

fn accept(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    lqr: Lqr,
    relative_residual: f64,
    kind: TimeKind,
) -> Result<Lqr, LqrError> {
    let closed_loop = a - b * &lqr.gain;
    let stable = closed_loop.complex_eigenvalues().iter().all(|&mode| kind.instability(mode) < 0.0);
    if relative_residual <= RESIDUAL_LIMIT && stable { Ok(lqr) } else { Err(LqrError::IllConditioned) }
}

fn check(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
    kind: TimeKind,
) -> Result<(), LqrError> {
    let (nx, nu) = (a.nrows(), b.ncols());
    if nx == 0 || nu == 0 {
        return Err(LqrError::Empty);
    }
    for (name, matrix, rows, columns) in
        [("A", a, nx, nx), ("B", b, nx, nu), ("Q", q, nx, nx), ("R", r, nu, nu)]
    {
        if matrix.shape() != (rows, columns) {
            return Err(LqrError::Shape {
                matrix: name,
                rows: matrix.nrows(),
                columns: matrix.ncols(),
                expected_rows: rows,
                expected_columns: columns,
            });
        }
        if !matrix.iter().all(|value| value.is_finite()) {
            return Err(LqrError::NonFinite { matrix: name });
        }
    }
    for (name, matrix) in [("Q", q), ("R", r)] {
        if (matrix - matrix.transpose()).norm() > ROUNDING * matrix.norm() {
            return Err(LqrError::Asymmetric { matrix: name });
        }
    }
    let smallest_eigenvalue = q.symmetric_eigenvalues().min();
    if smallest_eigenvalue < -ROUNDING * q.norm() {
        return Err(LqrError::IndefiniteStateWeight { smallest_eigenvalue });
    }
    if let Some(mode) = unreachable_mode(a, b, kind) {
        return Err(LqrError::NotStabilisable { mode });
    }
    if let Some(mode) = unseen_mode(a, q, kind) {
        return Err(LqrError::NotDetectable { mode });
    }
    Ok(())
}
