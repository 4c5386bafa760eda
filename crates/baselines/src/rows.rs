//! The planners' demands: one row for each obstacle and step, with exact gradients. Not here: the planner itself.

mod avoidance;
mod dcbf;
mod rntc;
mod sdf;
#[cfg(test)]
mod tests;
mod velocity_obstacle;

pub(crate) use avoidance::Avoidance;
pub(crate) use dcbf::DcbfRows;
pub(crate) use rntc::RntcRows;
pub(crate) use sdf::SdfRows;
pub(crate) use velocity_obstacle::VoRows;

use optimal_control::{ConstraintRow, StepPoint};

/// A step of a plan of `[x_m, y_m, heading_rad]` by `[speed_mps, yaw_rate_radps]`.
pub(crate) type Point = StepPoint<3, 2>;
/// A demand on such a step.
pub(crate) type Row = ConstraintRow<3, 2>;

/// One obstacle during step `k` of a plan: it keeps its velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Passing {
    /// Centre at `x_k` and at `x_{k+1}`, frame of the plan, m.
    pub(crate) position_m: [f64; 2],
    pub(crate) next_position_m: [f64; 2],
    pub(crate) velocity_mps: [f64; 2],
    pub(crate) heading_rad: f64,
    pub(crate) speed_mps: f64,
    /// `R`, distance of the centres that counts as contact, m.
    pub(crate) contact_m: f64,
}

/// What a method demands of one step.
pub(crate) trait Demand: Send {
    /// Whether the published problem also demands the distance at `x_0`, which nothing can change.
    fn demands_at_start(&self) -> bool;

    /// Which entries of the gradients may differ from zero.
    fn sparsity(&self) -> Row;

    /// Writes one row for each obstacle.
    fn fill(&mut self, point: &Point, obstacles: &[Passing], rows: &mut [Row]);
}
