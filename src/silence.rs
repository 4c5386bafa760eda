//! What a live run that heard nothing of its robot has to tell instead of figures.

use std::path::Path;

use messages::{Detections, Goal, Message, RobotState};
use settings::{Ros2Settings, Settings};

use crate::outcome::messages_of;

/// Why a run in a ROS 2 graph cannot be judged: `error`, unless `recording` holds not a single robot state. Then the topics that
/// said nothing usable are named, and where to look for the reason: `folder` has the run's logs.
pub(crate) fn unheard(
    error: anyhow::Error,
    recording: &Path,
    settings: &Settings,
    folder: &Path,
) -> anyhow::Error {
    if holds::<RobotState>(recording) {
        return error;
    }
    let ros2 = settings.source.ros2.clone().unwrap_or_else(Ros2Settings::customary);
    let name = |set: &str, customary: &str| ros2.absolute(if set.is_empty() { customary } else { set });
    let source = &settings.source;
    let mut silent = vec![name(&source.odometry_topic, "odom")];
    if !holds::<Detections>(recording) {
        silent.push(name(&source.detections_topic, "detections"));
    }
    if !holds::<Goal>(recording) && ros2.nominal_topic.is_none() {
        silent.push(name(&source.goal_topic, "goal_pose"));
    }
    anyhow::anyhow!(
        "nothing usable was heard on {}, so there is nothing to judge; `cncbf doctor` lists who is in the graph and which topics \
         fit, {} says what was refused and why",
        silent.join(", "),
        folder.join("bridge.log").display()
    )
}

fn holds<T: Message>(recording: &Path) -> bool {
    messages_of::<T>(recording).is_ok_and(|messages| !messages.is_empty())
}
