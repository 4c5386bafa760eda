//! The safety ladder: which rung each reason leads to. The one place where that is decided.

use messages::{Reason, SafetyStatus};

/// The rung a reason leads to. [`SafetyStatus::Stopped`] is reached from `Braking` once the robot stands.
///
/// There is no wildcard: a new reason does not compile before someone chose what the robot does about it.
pub const fn rung(reason: Reason) -> SafetyStatus {
    match reason {
        Reason::None => SafetyStatus::Filtered,
        Reason::SlackNeeded | Reason::JointEscape => SafetyStatus::Relaxed,
        Reason::StopRequested
        | Reason::NoRobotState
        | Reason::StaleRobotState
        | Reason::NonFiniteRobotState
        | Reason::NoObstacles
        | Reason::SilentEstimator
        | Reason::StaleDetections
        | Reason::UnsoundObstacle
        | Reason::NoNominalCommand
        | Reason::StaleNominalCommand
        | Reason::NonFiniteNominalCommand
        | Reason::WrongControlKind
        | Reason::NoGoal
        | Reason::FutureStamp
        | Reason::BackwardStamp
        | Reason::ForeignClock
        | Reason::ClockJump
        | Reason::NonFiniteBarrier
        | Reason::SolverFailed
        | Reason::SilentFilter
        | Reason::MalformedInput
        | Reason::NoTransform
        | Reason::Duplicate
        | Reason::Teleport
        | Reason::CapacityExceeded
        | Reason::PortFailed => SafetyStatus::Braking,
    }
}
