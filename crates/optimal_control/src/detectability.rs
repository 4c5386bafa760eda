//! The Popov–Belevitch–Hautus test: can the input reach, and the cost see, every mode that does not die out by itself?

use nalgebra::{Complex, DMatrix};

/// Which modes of `ẋ = A x` or `x⁺ = A x` die out by themselves.
#[derive(Debug, Clone, Copy)]
pub(crate) enum TimeKind {
    /// Modes with a negative real part.
    Continuous,
    /// Modes within the unit circle.
    Discrete,
}

impl TimeKind {
    /// How far `mode` is from dying out; negative for a stable one.
    pub(crate) fn instability(self, mode: Complex<f64>) -> f64 {
        match self {
            Self::Continuous => mode.re,
            Self::Discrete => mode.norm() - 1.0,
        }
    }
}

/// Relative size of a singular value that counts as zero. Multiple eigenvalues are only known to about the square
/// root of machine precision.
const RANK_TOLERANCE: f64 = 1e-9;
/// Modes closer than this to the stability limit count as unstable, relative to the size of `A`.
const MARGIN: f64 = 1e-7;

/// The first mode of `A` that neither dies out nor is reached through `B`: rank `[A − λI, B]` < n.
pub(crate) fn unreachable_mode(a: &DMatrix<f64>, b: &DMatrix<f64>, kind: TimeKind) -> Option<Complex<f64>> {
    let n = a.nrows();
    let scale = a.norm().max(1.0);
    a.complex_eigenvalues().iter().copied().find(|&mode| {
        if kind.instability(mode) < -MARGIN * scale {
            return false;
        }
        let pencil = DMatrix::from_fn(n, n + b.ncols(), |row, column| {
            if column >= n {
                return Complex::new(b[(row, column - n)], 0.0);
            }
            let shift = if row == column { mode } else { Complex::new(0.0, 0.0) };
            Complex::new(a[(row, column)], 0.0) - shift
        });
        let singular_values = pencil.singular_values();
        singular_values.min() <= RANK_TOLERANCE * singular_values.max().max(1.0)
    })
}

/// The first mode of `A` that does not die out and that the state weight `Q` does not see.
pub(crate) fn unseen_mode(a: &DMatrix<f64>, q: &DMatrix<f64>, kind: TimeKind) -> Option<Complex<f64>> {
    unreachable_mode(&a.transpose(), &q.transpose(), kind)
}
