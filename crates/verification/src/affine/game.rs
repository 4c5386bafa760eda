//! The two players of a pair on a box: which inputs to assume, and the flow that follows.
//!
//! `max_u` is bounded from below by one admissible `u`, the best at the box's centre; `min_d` by both ends of every
//! input that is not already decided. Where robot and obstacle act on the same component and the robot is the
//! stronger, both merge into one.

#![allow(clippy::inline_always)] // see `form`

use barrier::{DynamicsKind, ModelMetadata};
use pulp::Simd;

use super::form::{AXES, Form};

/// A direction whose share in the flow the obstacle chooses between two ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ObstacleChoice {
    /// State component it moves.
    pub(crate) axis: usize,
    /// The two rates, state units per second.
    pub(crate) rates: [f64; 2],
}

/// The boxes of a model's pair.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Game {
    /// Unicycle robot; the obstacle turns.
    Unicycle { control: [[f64; 2]; 2], turn_rate: [f64; 2] },
    /// Accelerations of both; per axis the rate `d − u` for a positive and for a negative costate.
    DoubleIntegrator { rates: [[f64; 2]; 2] },
    /// Unicycle robot; the obstacle stands still.
    UnicycleStatic { control: [[f64; 2]; 2] },
}

/// Velocity of the relative state on boxes.
pub(crate) struct Flow<S: Simd> {
    /// All components.
    pub(crate) rate: [Form<S>; AXES],
    /// The first two without the robot's rotation, which does not change the distance.
    pub(crate) unrotated: [Form<S>; 2],
}

impl Game {
    /// Reads the boxes the filter will assume.
    pub(crate) fn new(metadata: &ModelMetadata) -> Self {
        let (u, d) = (&metadata.control, &metadata.disturbance);
        let control = [[u.min[0], u.max[0]], [u.min[1], u.max[1]]];
        match metadata.dynamics {
            DynamicsKind::UnicyclePair => Self::Unicycle { control, turn_rate: [d.min[0], d.max[0]] },
            DynamicsKind::DoubleIntegratorPair => Self::DoubleIntegrator {
                rates: core::array::from_fn(|k| [d.min[k] - u.min[k], d.max[k] - u.max[k]]),
            },
            DynamicsKind::UnicycleStaticPair => Self::UnicycleStatic { control },
        }
    }

    /// The directions left to the obstacle.
    pub(crate) fn choices(&self) -> Vec<ObstacleChoice> {
        match self {
            Self::Unicycle { turn_rate, .. } => vec![ObstacleChoice { axis: 2, rates: *turn_rate }],
            Self::DoubleIntegrator { rates } => (0..2)
                .filter(|k| rates[*k][0] < rates[*k][1])
                .map(|k| ObstacleChoice { axis: 2 + k, rates: rates[k] })
                .collect(),
            Self::UnicycleStatic { .. } => Vec::new(),
        }
    }

    /// The two inputs assumed on a box with centre `z` and costate `p` there: `[v, ω]`, or the accelerations `d − u`
    /// of the axes on which the robot is the stronger and zero on the others.
    pub(crate) fn inputs(&self, z: &[f64; AXES], p: &[f64; AXES]) -> [f64; 2] {
        match self {
            Self::Unicycle { control, .. } => best_twist(control, -p[0], p[0] * z[1] - p[1] * z[0] - p[2]),
            Self::UnicycleStatic { control } => best_twist(control, -p[0], p[0] * z[1] - p[1] * z[0]),
            Self::DoubleIntegrator { rates } => core::array::from_fn(|k| {
                let [positive, negative] = rates[k];
                match positive < negative {
                    true => 0.0,
                    false if p[2 + k] >= 0.0 => positive,
                    false => negative,
                }
            }),
        }
    }

    /// The flow on boxes `z` under `inputs`, without what [`Game::choices`] lists.
    #[inline(always)]
    pub(crate) fn flow<S: Simd>(&self, simd: S, z: &[Form<S>; AXES], inputs: [S::f64s; 2]) -> Flow<S> {
        let zero = Form::constant(simd, simd.splat_f64s(0.0));
        let constant = |value| Form::constant(simd, value);
        let turned = |unrotated: [Form<S>; 2], yaw_rate: S::f64s| {
            let x = z[1].scaled_plus(simd, yaw_rate, &unrotated[0]);
            let y = z[0].scaled_plus(simd, simd.neg_f64s(yaw_rate), &unrotated[1]);
            [x, y]
        };
        match self {
            Self::Unicycle { .. } => {
                let (sin, cos) = z[2].sin_cos(simd);
                let ahead = z[3].times(simd, &cos).minus(simd, &constant(inputs[0]));
                let unrotated = [ahead, z[3].times(simd, &sin)];
                let [x, y] = turned(unrotated, inputs[1]);
                let heading = constant(simd.neg_f64s(inputs[1]));
                Flow { rate: [x, y, heading, zero], unrotated }
            }
            Self::UnicycleStatic { .. } => {
                let unrotated = [constant(simd.neg_f64s(inputs[0])), zero];
                let [x, y] = turned(unrotated, inputs[1]);
                Flow { rate: [x, y, zero, zero], unrotated }
            }
            Self::DoubleIntegrator { .. } => {
                Flow { rate: [z[2], z[3], constant(inputs[0]), constant(inputs[1])], unrotated: [z[2], z[3]] }
            }
        }
    }
}

/// The twist that maximises `by_speed v + by_yaw_rate ω`.
fn best_twist(control: &[[f64; 2]; 2], by_speed: f64, by_yaw_rate: f64) -> [f64; 2] {
    let best = |bounds: [f64; 2], slope: f64| if slope >= 0.0 { bounds[1] } else { bounds[0] };
    [best(control[0], by_speed), best(control[1], by_yaw_rate)]
}
