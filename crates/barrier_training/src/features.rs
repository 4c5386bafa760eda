//! What the network reads of a relative state, and how its derivatives carry over.

use crate::network::MOST_INPUTS;
use settings::Encoding;

/// Inputs of the network at `state`; what an encoding leaves free is 0.
pub(crate) fn encode(encoding: Encoding, state: &[f32; 4]) -> [f32; MOST_INPUTS] {
    let [x, y, heading, speed] = *state;
    match encoding {
        Encoding::Raw => [x, y, heading, speed, 0.0],
        Encoding::HeadingCosSin => [x, y, libm::cosf(heading), libm::sinf(heading), speed],
        Encoding::Position => [x, y, 0.0, 0.0, 0.0],
    }
}

/// `∂/∂z` from the derivatives by the `inputs` that [`encode`] gave.
pub(crate) fn state_gradient(
    encoding: Encoding,
    inputs: &[f32; MOST_INPUTS],
    by_input: &[f32; MOST_INPUTS],
) -> [f32; 4] {
    let g = by_input;
    match encoding {
        Encoding::Raw => [g[0], g[1], g[2], g[3]],
        Encoding::HeadingCosSin => [g[0], g[1], inputs[2] * g[3] - inputs[3] * g[2], g[4]],
        Encoding::Position => [g[0], g[1], 0.0, 0.0],
    }
}

/// Rate of the inputs where the state moves at `flow`.
pub(crate) fn input_rate(
    encoding: Encoding,
    inputs: &[f32; MOST_INPUTS],
    flow: &[f32; 4],
) -> [f32; MOST_INPUTS] {
    let [x, y, heading, speed] = *flow;
    match encoding {
        Encoding::Raw => [x, y, heading, speed, 0.0],
        Encoding::HeadingCosSin => [x, y, -inputs[3] * heading, inputs[2] * heading, speed],
        Encoding::Position => [x, y, 0.0, 0.0, 0.0],
    }
}
