//! What a method is given, and what it refuses. Not here: which obstacles it looks at (`surroundings`).

use messages::{ControlKind, Goal, Intent, NominalCommand, Obstacles, RobotState};

/// The newest message of each kind; `None` where none has arrived yet.
#[derive(Debug, Clone, Copy, Default)]
pub struct Inputs<'a> {
    /// Where the robot is.
    pub robot_state: Option<&'a RobotState>,
    /// What is around it.
    pub obstacles: Option<&'a Obstacles>,
    /// Where it shall go. Planners need it.
    pub goal: Option<&'a Goal>,
    /// What a controller blind to obstacles would do. Filters need it: the paper's, an LQR.
    pub nominal: Option<&'a NominalCommand>,
}

/// Why there is no control. What the robot does then is the caller's choice; on board it brakes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NoControl {
    /// An input has never arrived.
    #[error("no {input} has arrived; is its sender running?")]
    Missing {
        /// Its service.
        input: &'static str,
    },
    /// An input holds a NaN, an infinity, or a radius that is none.
    #[error("{input} is not finite; check its sender")]
    NonFinite {
        /// Its service.
        input: &'static str,
    },
    /// The nominal command is for another robot.
    #[error("the nominal command is no acceleration; run the nominal controller with the same settings")]
    OtherRobot,
    /// The nominal controller asks for a stop, which no row of a barrier turns into anything.
    #[error("the nominal controller asks for a stop")]
    Stop,
}

impl<'a> Inputs<'a> {
    pub(crate) fn sound_robot_state(&self) -> Result<&'a RobotState, NoControl> {
        const INPUT: &str = "robot_state";
        let state = self.robot_state.ok_or(NoControl::Missing { input: INPUT })?;
        if state.is_finite() { Ok(state) } else { Err(NoControl::NonFinite { input: INPUT }) }
    }

    pub(crate) fn sound_obstacles(&self) -> Result<&'a Obstacles, NoControl> {
        const INPUT: &str = "obstacles";
        let obstacles = self.obstacles.ok_or(NoControl::Missing { input: INPUT })?;
        if obstacles.as_slice().iter().all(messages::Obstacle::is_sound) {
            Ok(obstacles)
        } else {
            Err(NoControl::NonFinite { input: INPUT })
        }
    }

    pub(crate) fn sound_goal(&self) -> Result<&'a Goal, NoControl> {
        const INPUT: &str = "goal";
        let goal = self.goal.ok_or(NoControl::Missing { input: INPUT })?;
        if goal.is_finite() { Ok(goal) } else { Err(NoControl::NonFinite { input: INPUT }) }
    }

    /// The acceleration that is asked for, m/s².
    pub(crate) fn sound_acceleration(&self) -> Result<[f64; 2], NoControl> {
        const INPUT: &str = "nominal_command";
        let nominal = self.nominal.ok_or(NoControl::Missing { input: INPUT })?;
        if nominal.control_kind != ControlKind::DoubleIntegrator.code() {
            return Err(NoControl::OtherRobot);
        }
        if nominal.intent != Intent::Drive.code() {
            return Err(NoControl::Stop);
        }
        if nominal.control.iter().all(|value| value.is_finite()) {
            Ok(nominal.control)
        } else {
            Err(NoControl::NonFinite { input: INPUT })
        }
    }
}
