//! The failure function of the paper's pairs. Not here: other shapes; any closure serves the solver.

/// Returns `ℓ(z) = |p| − R`, m, where the position `p` is the first two components of `z`.
///
/// Source: paper, section on the ground robot, with `R = radius_m = R_r + R_o`. It is negative exactly
/// where robot and obstacle overlap.
pub fn disc_failure_function<const N: usize>(radius_m: f64) -> impl Fn(&[f64; N]) -> f64 + Send + Sync {
    const { assert!(N >= 2, "a position needs two components") };
    move |z| z[0].hypot(z[1]) - radius_m
}
