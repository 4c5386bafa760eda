//! Statuses, reasons and codes in words that tell an operator what happened.

use messages::{ControlKind, ObstacleClass, ObstacleQuality, Reason};

use crate::Rung;

/// What the robot does on a rung.
pub(crate) const fn rung(rung: Rung) -> &'static str {
    match rung {
        Rung::Filtered => "the nominal command passed the filter and the CBF condition holds",
        Rung::Relaxed => {
            "no admissible control satisfied the CBF condition, so the least violating one was chosen"
        }
        Rung::Braking => "the robot slows down to a halt",
        Rung::Stopped => "the robot stands and is kept standing",
        Rung::Silent => "the filter's status is unknown to this version",
    }
}

/// Why a rung was chosen.
pub(crate) const fn reason(reason: Reason) -> &'static str {
    match reason {
        Reason::None => "nothing is wrong",
        Reason::SlackNeeded => "the CBF-QP needed slack beyond its tolerance",
        Reason::JointEscape => "a manoeuvre clear of everybody took the place of the CBF-QP's control",
        Reason::StopRequested => "the nominal controller asked for a halt",
        Reason::NoRobotState => "no robot state has arrived yet",
        Reason::StaleRobotState => "the newest robot state is too old",
        Reason::NonFiniteRobotState => "the newest robot state holds a NaN or an infinity",
        Reason::NoObstacles => "no obstacles message has arrived yet",
        Reason::SilentEstimator => "the estimator has fallen silent",
        Reason::StaleDetections => "perception has been silent for too long",
        Reason::UnsoundObstacle => "an obstacle holds a NaN, an infinity or a radius that is not positive",
        Reason::NoNominalCommand => "no nominal command has arrived yet",
        Reason::NoGoal => "the nominal controller has no goal",
        Reason::StaleNominalCommand => "the nominal controller has fallen silent",
        Reason::NonFiniteNominalCommand => "the nominal command holds a NaN or an infinity",
        Reason::WrongControlKind => "the nominal command is for another kind of robot",
        Reason::FutureStamp => "a stamp lies in the future",
        Reason::BackwardStamp => "a stamp ran backwards",
        Reason::ForeignClock => "a stamp is of another clock",
        Reason::ClockJump => "the sender's clock jumped",
        Reason::NonFiniteBarrier => "the evaluation of the barrier produced a NaN or an infinity",
        Reason::SolverFailed => "an optimisation did not converge",
        Reason::SilentFilter => "the command sink heard nothing from the filter",
        Reason::MalformedInput => "an input could not be decoded or made no sense",
        Reason::NoTransform => "a coordinate frame is unknown or its transform too old",
        Reason::Duplicate => "something appeared twice",
        Reason::Teleport => "an obstacle jumped farther than anything can move",
        Reason::CapacityExceeded => "there was no room for more",
        Reason::PortFailed => "a port refused to send or to receive",
    }
}

/// Name of a reason code, known or not.
pub(crate) fn reason_label(code: u32) -> String {
    Reason::try_from(code).map_or_else(|_| format!("code {code}"), |reason| reason.label().to_owned())
}

/// Names and units of the two control components, by the wire code of the kind.
pub(crate) fn control_components(code: u32) -> [(&'static str, &'static str); 2] {
    match ControlKind::try_from(code) {
        Ok(ControlKind::Unicycle) => [("speed", "m/s"), ("yaw rate", "rad/s")],
        Ok(ControlKind::DoubleIntegrator) => [("ax", "m/s²"), ("ay", "m/s²")],
        Err(_) => [("first control", "?"), ("second control", "?")],
    }
}

/// Name of an obstacle class code, known or not.
pub(crate) fn class_label(code: u32) -> &'static str {
    ObstacleClass::try_from(code).map_or("obstacle of unknown class", ObstacleClass::label)
}

/// Name of an obstacle quality code, known or not.
pub(crate) fn quality_label(code: u32) -> &'static str {
    ObstacleQuality::try_from(code).map_or("unknown", ObstacleQuality::label)
}

/// Where a point `[forward, left]`, m, in `base` lies, seen from the robot.
pub(crate) fn direction(position_in_base_m: [f64; 2]) -> &'static str {
    let [forward, left] = position_in_base_m;
    let sector = (left.atan2(forward) / core::f64::consts::FRAC_PI_4).round() as i32;
    match sector {
        0 => "ahead",
        1 => "ahead on the left",
        2 => "on the left",
        3 => "behind on the left",
        -1 => "ahead on the right",
        -2 => "on the right",
        -3 => "behind on the right",
        _ => "behind",
    }
}
