//! Rough ways of driving to the origin, as guesses for the SQP when the previous plan is missing or poor.

use crate::dynamics::EulerUnicycle;

/// How a guess begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FirstTurn {
    /// To the left until the goal is ahead.
    Left,
    /// To the right until the goal is ahead.
    Right,
}

/// Drives `[x, y, heading]` to the origin: turn in place as far as the input box allows, then straight on.
///
/// Returns `[speed_mps, yaw_rate_radps]`, not yet brought into the input box. A goal exactly behind is a stationary
/// point of the cost, which no derivative leaves: the turns leave it.
pub(crate) fn turn_then_drive(
    dynamics: EulerUnicycle,
    first_turn: FirstTurn,
    &[x, y, heading]: &[f64; 3],
) -> [f64; 2] {
    let distance = x.hypot(y);
    let bearing = wrap(f64::atan2(-y, -x) - heading);
    let turn = match first_turn {
        FirstTurn::Left if bearing < -std::f64::consts::FRAC_PI_2 => bearing + std::f64::consts::TAU,
        FirstTurn::Right if bearing > std::f64::consts::FRAC_PI_2 => bearing - std::f64::consts::TAU,
        FirstTurn::Left | FirstTurn::Right => bearing,
    };
    [distance * bearing.cos() / dynamics.step_s, turn / dynamics.step_s]
}

/// Brings an angle into `[−π, π)`, rad.
pub(crate) fn wrap(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    (angle + PI).rem_euclid(TAU) - PI
}
