//! How the perception bridge reads recordings and live topics.

use serde::{Deserialize, Serialize};

use crate::Ros2Settings;
use crate::error::{Checked, non_negative, positive, positive_ms, require};

/// Topics, frames and refusals of the perception bridge.
///
/// A topic of `""` means: in a recording of this stack the raw wire messages, otherwise the first topic whose type fits; in a
/// live graph the customary name (`odom`, `detections`, `goal_pose`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SourceSettings {
    /// nav_msgs/Odometry topic.
    pub odometry_topic: String,
    /// Topic with obstacles, of one of the types of [`crate::ObstacleMessage`].
    pub detections_topic: String,
    /// geometry_msgs/PoseStamped topic with goals; `""` takes only one with `goal` in its name.
    pub goal_topic: String,
    /// The frame control happens in; everything is brought into it.
    pub odom_frame: String,
    /// Whether detections whose frame has no transform to `odom_frame` are taken as if they were in it. Recordings made
    /// without /tf need this; a robot must not, and live topics are never taken so.
    pub assume_odom_frame: bool,
    /// Longest age of a transform that may still be used, ms.
    pub max_transform_age_ms: u64,
    /// Where to drive if a recording holds no goal, in `odom` ahead of the robot's first position: `[forward, left]`, m.
    pub default_goal_in_base_m: [f64; 2],
    /// Smallest and largest plausible radius of a detection's box, m; below it the default radius is taken, above
    /// it the largest.
    pub radius_range_m: [f64; 2],
    /// How the bridge joins a live ROS 2 graph; as [`Ros2Settings::customary`] if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ros2: Option<Ros2Settings>,
}

impl SourceSettings {
    pub(crate) fn validate(&self) -> Checked {
        require(!self.odom_frame.is_empty(), "source.odom_frame", &self.odom_frame, "the name of a frame")?;
        positive_ms("source.max_transform_age_ms", self.max_transform_age_ms)?;
        let finite = self.default_goal_in_base_m.iter().all(|value| value.is_finite());
        require(finite, "source.default_goal_in_base_m", self.default_goal_in_base_m, "finite")?;
        let [smallest, largest] = self.radius_range_m;
        non_negative("source.radius_range_m", smallest)?;
        positive("source.radius_range_m", largest)?;
        require(smallest <= largest, "source.radius_range_m", self.radius_range_m, "in ascending order")?;
        self.ros2.as_ref().map_or(Ok(()), Ros2Settings::validate)
    }
}
