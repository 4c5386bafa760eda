//! Names for the `u32` codes on the wire.
//!
//! A code that this version does not know comes from a newer or a foreign sender: `TryFrom<u32>` refuses it, and the
//! reader decides what that means.

/// A code that names nothing in this version.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "{kind} code {code} is unknown to this version; is the sender newer, or is this another kind of message?"
)]
pub struct UnknownCode {
    /// Which enumeration was asked.
    pub kind: &'static str,
    /// The offending code.
    pub code: u32,
}

/// Declares an enumeration together with its wire codes and its names in logs, reports and JSON.
macro_rules! wire_codes {
    ($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident = $code:literal => $label:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[repr(u32)]
        pub enum $name { $($(#[$vdoc])* $variant = $code),+ }

        impl $name {
            /// Every variant, in the order of its code.
            pub const ALL: &'static [Self] = &[$(Self::$variant),+];

            /// The code on the wire.
            pub const fn code(self) -> u32 { self as u32 }

            /// The name in logs, reports and JSON.
            pub const fn label(self) -> &'static str {
                match self { $(Self::$variant => $label),+ }
            }
        }

        impl TryFrom<u32> for $name {
            type Error = UnknownCode;
            fn try_from(code: u32) -> Result<Self, UnknownCode> {
                match code {
                    $($code => Ok(Self::$variant),)+
                    _ => Err(UnknownCode { kind: stringify!($name), code }),
                }
            }
        }

        impl core::fmt::Display for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result { f.pad(self.label()) }
        }
    };
}

wire_codes! {
    /// What the two numbers of a control vector mean.
    ControlKind {
        /// `[speed m/s, yaw rate rad/s]` of a unicycle.
        Unicycle = 1 => "unicycle",
        /// `[ax, ay]` m/s² in `odom` of a double integrator.
        DoubleIntegrator = 2 => "double_integrator",
    }
}

wire_codes! {
    /// What a nominal controller wants.
    Intent {
        /// Apply the control.
        Drive = 1 => "drive",
        /// Come to a halt and stay.
        Stop = 2 => "stop",
    }
}

wire_codes! {
    /// Who made a nominal command.
    Controller {
        /// Keeps still.
        Hold = 1 => "hold",
        /// Model-predictive controller of the unicycle.
        Mpc = 2 => "mpc",
        /// Linear-quadratic regulator of the double integrator.
        Lqr = 3 => "lqr",
        /// Pure pursuit of the goal by the unicycle.
        PurePursuit = 4 => "pure_pursuit",
        /// The robot's own: what it would be commanded without this stack, taken from a topic by the bridge.
        Upstream = 5 => "upstream",
    }
}

wire_codes! {
    /// Rung of the safety ladder, from best to worst.
    SafetyStatus {
        /// The nominal command passed the filter; the CBF condition holds.
        Filtered = 1 => "filtered",
        /// No admissible control satisfies the condition; the least violating one was chosen.
        Relaxed = 2 => "relaxed",
        /// Inputs cannot be trusted; the robot slows down to a halt.
        Braking = 3 => "braking",
        /// The robot stands and is kept standing.
        Stopped = 4 => "stopped",
    }
}

wire_codes! {
    /// Why a rung was chosen, or what went wrong last.
    Reason {
        /// Nothing is wrong.
        None = 0 => "none",
        /// The CBF-QP needed slack beyond its tolerance.
        SlackNeeded = 1 => "slack_needed",
        /// The nominal controller asked for a halt.
        StopRequested = 2 => "stop_requested",
        /// The filter took a manoeuvre that keeps clear of everybody at once, as far as one does, not the CBF-QP's control.
        JointEscape = 3 => "joint_escape",
        /// No robot state has arrived yet.
        NoRobotState = 10 => "no_robot_state",
        /// The newest robot state is too old.
        StaleRobotState = 11 => "stale_robot_state",
        /// The newest robot state holds a NaN or an infinity.
        NonFiniteRobotState = 12 => "non_finite_robot_state",
        /// No obstacles message has arrived yet.
        NoObstacles = 20 => "no_obstacles",
        /// The estimator has fallen silent.
        SilentEstimator = 21 => "silent_estimator",
        /// The estimator lives but perception has been silent for too long.
        StaleDetections = 22 => "stale_detections",
        /// An obstacle holds a NaN, an infinity or a radius that is not positive.
        UnsoundObstacle = 23 => "unsound_obstacle",
        /// No nominal command has arrived yet.
        NoNominalCommand = 30 => "no_nominal_command",
        /// The nominal controller has fallen silent.
        StaleNominalCommand = 31 => "stale_nominal_command",
        /// The nominal command holds a NaN or an infinity.
        NonFiniteNominalCommand = 32 => "non_finite_nominal_command",
        /// The nominal command is for another kind of robot, or its codes are unknown.
        WrongControlKind = 33 => "wrong_control_kind",
        /// The nominal controller has no goal to drive to.
        NoGoal = 34 => "no_goal",
        /// A stamp lies in the future by more than the tolerance.
        FutureStamp = 40 => "future_stamp",
        /// A stamp runs backwards.
        BackwardStamp = 41 => "backward_stamp",
        /// A stamp is of another clock than the one that was agreed on: simulated time, or the time since a machine began.
        ForeignClock = 42 => "foreign_clock",
        /// The sender's clock has jumped.
        ClockJump = 43 => "clock_jump",
        /// The evaluation produced a NaN or an infinity.
        NonFiniteBarrier = 50 => "non_finite_barrier",
        /// An optimisation did not converge.
        SolverFailed = 51 => "solver_failed",
        /// The command sink has heard nothing from the filter for five periods.
        SilentFilter = 60 => "silent_filter",
        /// An input could not be decoded or made no sense.
        MalformedInput = 70 => "malformed_input",
        /// A coordinate frame is unknown or its transform too old.
        NoTransform = 71 => "no_transform",
        /// Something appeared twice.
        Duplicate = 72 => "duplicate",
        /// An obstacle jumped farther than anything can move.
        Teleport = 73 => "teleport",
        /// There was no room for more.
        CapacityExceeded = 74 => "capacity_exceeded",
        /// A port refused to send or to receive.
        PortFailed = 80 => "port_failed",
    }
}

wire_codes! {
    /// What an obstacle is.
    ObstacleClass {
        /// Perception did not say.
        Unknown = 0 => "unknown",
        /// A person on foot.
        Pedestrian = 1 => "pedestrian",
        /// A person on a bicycle or scooter.
        Cyclist = 2 => "cyclist",
        /// Something that does not move.
        Static = 3 => "static",
        /// Another robot or vehicle.
        Vehicle = 4 => "vehicle",
    }
}

wire_codes! {
    /// How far an obstacle's estimate can be trusted.
    ObstacleQuality {
        /// Position measured, velocity not known yet and reported as zero.
        PositionOnly = 1 => "position_only",
        /// Position and velocity known, their rate not yet.
        Velocity = 2 => "velocity",
        /// Position, velocity and rate known.
        Full = 3 => "full",
        /// Not measured lately; predicted.
        Coasting = 4 => "coasting",
    }
}

wire_codes! {
    /// A process of the stack.
    ProcessId {
        /// `perception_bridge`.
        Bridge = 1 => "bridge",
        /// `obstacle_estimator`.
        Estimator = 2 => "estimator",
        /// `nominal_mpc`.
        Nominal = 3 => "nominal",
        /// `cbf_filter`.
        Filter = 4 => "filter",
        /// The recorder.
        Recorder = 5 => "recorder",
        /// The launcher.
        Launcher = 6 => "launcher",
    }
}

wire_codes! {
    /// Where the bridge takes the world from.
    SourceKind {
        /// The simulated crowd.
        Simulation = 1 => "simulation",
        /// A recording, played back.
        Mcap = 2 => "mcap",
        /// A live ROS 2 graph.
        Ros2 = 3 => "ros2",
    }
}

wire_codes! {
    /// What began a cycle.
    Trigger {
        /// Its due time.
        Timer = 0 => "timer",
        /// Something arrived for the process.
        Event = 1 => "event",
    }
}

/// Bits of [`crate::Health::realtime_asked`] and [`crate::Health::realtime_granted`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RealtimeFlags;

impl RealtimeFlags {
    /// Scheduling class SCHED_FIFO.
    pub const FIFO: u32 = 1;
    /// Runs on chosen processors only.
    pub const PROCESSORS: u32 = 2;
    /// All memory locked.
    pub const MEMORY_LOCK: u32 = 4;
    /// Heap and stack touched before the loop.
    pub const PREFAULT: u32 = 8;
    /// Timer slack.
    pub const TIMER_SLACK: u32 = 16;
    /// `/dev/cpu_dma_latency` held.
    pub const CPU_DMA_LATENCY: u32 = 32;
}

/// Bits of [`crate::Detection::flags`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DetectionFlags;

impl DetectionFlags {
    /// `velocity_in_odom_mps` was measured.
    pub const HAS_VELOCITY: u32 = 1;
    /// `position_covariance_m2` was given.
    pub const HAS_COVARIANCE: u32 = 2;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_survives_the_wire_and_unknown_ones_are_refused() {
        for &reason in Reason::ALL {
            assert_eq!(Reason::try_from(reason.code()), Ok(reason));
        }
        let mut labels: Vec<_> = Reason::ALL.iter().map(|reason| reason.label()).collect();
        labels.sort_unstable();
        labels.dedup();
        assert_eq!(labels.len(), Reason::ALL.len());
        assert_eq!(SafetyStatus::try_from(0), Err(UnknownCode { kind: "SafetyStatus", code: 0 }));
    }
}
