//! What a live run that heard nothing of its robot has to tell instead of figures.

use std::path::Path;

use report::RunRecord;
use settings::{Ros2Settings, Settings};

/// Refuses to judge a run in a ROS 2 graph without a single robot state: names the topics that said nothing usable, and where to
/// look for the reason. `folder` has the run's logs.
///
/// # Errors
/// If there was none.
pub(crate) fn refuse_unheard(record: &RunRecord, settings: &Settings, folder: &Path) -> anyhow::Result<()> {
    if !record.robot_states.is_empty() {
        return Ok(());
    }
    let ros2 = settings.source.ros2.clone().unwrap_or_else(Ros2Settings::customary);
    let name = |set: &str, customary: &str| ros2.absolute(if set.is_empty() { customary } else { set });
    let source = &settings.source;
    let mut silent = vec![name(&source.odometry_topic, "odom")];
    if record.obstacles.is_empty() {
        silent.push(name(&source.detections_topic, "detections"));
    }
    if record.goals.is_empty() && ros2.nominal_topic.is_none() {
        silent.push(name(&source.goal_topic, "goal_pose"));
    }
    anyhow::bail!(
        "nothing usable was heard on {}, so there is nothing to judge; `cncbf doctor` lists who is in the graph and which topics \
         fit, {} says what was refused and why",
        silent.join(", "),
        folder.join("bridge.log").display()
    )
}
