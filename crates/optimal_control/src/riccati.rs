//! Algebraic Riccati equations by structure-preserving doubling (Chu, Fan, Lin and Wang, 2004 and 2005).
//!
//! Chosen over an ordered Schur form because nalgebra and faer offer none: doubling needs only linear solves and
//! converges quadratically. Shapes, definiteness and stabilisability are the caller's business.

use nalgebra::DMatrix;

/// Doublings before giving up: 2^60 steps of the finite-horizon recursion.
const DOUBLING_LIMIT: usize = 60;
/// Change of the solution, relative to its size, that counts as none.
const RELATIVE_CHANGE: f64 = 1e-14;

/// Solves `X = Aᵀ X (I + G X)⁻¹ A + H` for its stabilising solution; `G = B R⁻¹ Bᵀ` and `H = Q`, both symmetric.
///
/// `None` where the iteration meets a singular matrix or does not settle.
pub(crate) fn discrete(a: &DMatrix<f64>, g: &DMatrix<f64>, h: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let identity = DMatrix::identity(a.nrows(), a.nrows());
    let (mut a, mut g, mut x) = (a.clone(), g.clone(), h.clone());
    for _ in 0..DOUBLING_LIMIT {
        // Two horizons of equal length joined into one; the doubled length has the same form.
        let joint = (&identity + &g * &x).lu();
        let joint_a = joint.solve(&a)?;
        let joint_g = joint.solve(&g)?;
        let growth = a.transpose() * &x * &joint_a;
        g += &a * joint_g * a.transpose();
        a = &a * joint_a;
        x += &growth;
        symmetrise(&mut g);
        symmetrise(&mut x);
        if !x.iter().all(|value| value.is_finite()) {
            return None;
        }
        if growth.norm() <= RELATIVE_CHANGE * x.norm() {
            return Some(x);
        }
    }
    None
}

/// Solves `Aᵀ X + X A − X G X + H = 0` for its stabilising solution.
///
/// The Cayley transform `s ↦ (s + γ)/(s − γ)` maps the left half-plane into the unit disc and the problem onto
/// [`discrete`].
pub(crate) fn continuous(a: &DMatrix<f64>, g: &DMatrix<f64>, h: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let identity = DMatrix::<f64>::identity(a.nrows(), a.nrows());
    // Beyond every eigenvalue of A, so that A − γI is regular.
    let gamma = 1.0 + 1.1 * a.norm();
    let shifted = a - &identity * gamma;
    let shifted_inverse = shifted.clone().try_inverse()?;
    let coupled = (shifted.transpose() + h * &shifted_inverse * g).try_inverse()?;
    let a_discrete = &identity + coupled.transpose() * (2.0 * gamma);
    let g_discrete = &shifted_inverse * g * &coupled * (2.0 * gamma);
    let h_discrete = &coupled * h * &shifted_inverse * (2.0 * gamma);
    discrete(&a_discrete, &symmetric(&g_discrete), &symmetric(&h_discrete))
}

fn symmetric(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    (matrix + matrix.transpose()) * 0.5
}

fn symmetrise(matrix: &mut DMatrix<f64>) {
    *matrix = symmetric(matrix);
}
