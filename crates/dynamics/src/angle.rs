//! The one place where an angle is brought into its principal interval.

use std::f64::consts::{PI, TAU};

/// Returns `rad` shifted by whole turns into `[-π, π)`.
///
/// A non-finite argument gives NaN.
pub fn wrap_angle(rad: f64) -> f64 {
    let wrapped = (rad + PI).rem_euclid(TAU) - PI;
    // `rem_euclid` may round up to a full turn for tiny negative arguments.
    if wrapped >= PI { -PI } else { wrapped }
}
