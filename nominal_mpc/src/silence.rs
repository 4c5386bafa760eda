//! Why no command is given: at start-up an error, in a cycle a verdict.

use messages::Reason;
use optimal_control::{LqrError, SqpSetupError};

/// Why a cycle gave no command. The filter's ladder acts on the silence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Silence {
    /// Nothing is known of the robot.
    #[error("no robot state has arrived; is `perception_bridge` running?")]
    NoRobotState,
    /// The robot may be elsewhere by now.
    #[error("the robot state is too old; does odometry still arrive?")]
    StaleRobotState,
    /// The robot state claims to come from the future by more than its largest age.
    #[error("the robot state is stamped ahead of the stack clock; check the bridge's clock offset")]
    FutureRobotState,
    /// A NaN or an infinity in the robot state.
    #[error("the robot state holds a value that is not finite")]
    NonFiniteRobotState,
    /// Nobody said where to go. Normal until the first goal.
    #[error("no goal has arrived; send one to drive")]
    NoGoal,
    /// A NaN or an infinity in the goal.
    #[error("the goal holds a value that is not finite")]
    NonFiniteGoal,
    /// The optimisation failed, with no recent plan to go on with.
    #[error("the controller found no plan; is the goal or the robot state far off the map?")]
    SolverFailed,
}

impl Silence {
    /// The code under which health counts this.
    pub const fn reason(self) -> Reason {
        match self {
            Self::NoRobotState => Reason::NoRobotState,
            Self::StaleRobotState => Reason::StaleRobotState,
            Self::FutureRobotState => Reason::FutureStamp,
            Self::NonFiniteRobotState => Reason::NonFiniteRobotState,
            // There is nothing wrong with any input: there is merely no command to give.
            Self::NoGoal => Reason::NoGoal,
            Self::NonFiniteGoal => Reason::MalformedInput,
            Self::SolverFailed => Reason::SolverFailed,
        }
    }
}

/// Why the controller cannot be set up.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NominalSetupError {
    /// The MPC's settings.
    #[error("nominal.mpc cannot be used: {0}")]
    Mpc(#[from] SqpSetupError),
    /// There is nothing to set up.
    #[error(
        "nominal.controller is external: somebody else's program is to take the place; choose mpc, lqr, pure_pursuit or hold to have one of ours"
    )]
    External,
    /// The table of the controller is missing.
    #[error("nominal.controller is pure_pursuit; add [nominal.pure_pursuit] with lookahead_m and speed_mps")]
    NoPurePursuit,
    /// The LQR's weights.
    #[error("nominal.lqr cannot be used: {0}")]
    Lqr(#[from] LqrError),
}
