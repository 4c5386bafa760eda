//! How rounding is accounted for. Stable Rust offers no directed rounding, so every bound is widened instead.

/// Relative widening that covers the rounding of any quantity here, 2⁻⁴⁰.
///
/// An expression of `n` roundings to nearest errs by at most `γₙ = n u / (1 − n u)`, `u = 2⁻⁵³`, times the sum of
/// the absolute values of its terms. The longest expression is a row of a layer with 48 inputs and a bias: fewer than
/// 128 roundings, `γ₁₂₈ < 2⁻⁴⁵`. Sines, cosines and softplus are exact to 2⁻⁴² or better (`elementary`). Their sum stays
/// below half of this constant, so a bound widened by it holds in real arithmetic.
pub(crate) const ROUNDING: f64 = 1.0 / (1_u64 << 40) as f64;

/// `1 + ROUNDING`: factor on a radius that was summed from terms of one sign.
pub(crate) const WIDEN: f64 = 1.0 + ROUNDING;
