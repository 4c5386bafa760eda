//! Why a live graph cannot be joined.

/// Why a live ROS 2 graph cannot be joined.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RosError {
    /// A variable of the environment is unusable.
    #[error("environment variable {variable}=`{value}`; use {expected}, or unset it")]
    Environment {
        /// Its name.
        variable: &'static str,
        /// What it holds.
        value: String,
        /// What it may hold.
        expected: &'static str,
    },
    /// DDS could not join the domain.
    #[error("cannot join ROS domain {domain_id} ({cause}); may this user open UDP sockets?")]
    Join {
        /// The domain.
        domain_id: u16,
        /// What DDS says.
        cause: String,
    },
    /// A topic could not be opened.
    #[error("cannot open topic {topic} ({cause}); is its name one that ROS 2 allows?")]
    Topic {
        /// Its full name.
        topic: String,
        /// What DDS says.
        cause: String,
    },
    /// The robot is commanded by acceleration.
    #[error("robot.kind: a live ROS 2 robot is commanded by velocity; use `unicycle`")]
    TakesAccelerations,
    /// The robot's own commands would be heard where the filtered ones leave.
    #[error(
        "source.ros2.nominal_topic and source.ros2.command_topic are both {topic}: the bridge would hear itself; \
         let the robot's controller publish on another topic, such as cmd_vel_smoothed"
    )]
    HearsItself {
        /// The topic's full name.
        topic: String,
    },
    /// The system refused a thread.
    #[error("cannot start a thread ({cause}); does a limit on processes (`ulimit -u`) forbid it?")]
    Thread {
        /// What the system says.
        cause: String,
    },
}
