//! Which topics of a recording the source listens to.

use recording::ros2::{self, Ros2Message};
use recording::{ChannelSummary, McapReader, wire_topic};
use settings::SourceSettings;

use super::error::SourceError;
use crate::obstacle_frames::recorded_types;

const ODOMETRY: &[&str] = &["nav_msgs/msg/Odometry", "nav_msgs/Odometry"];
const GOALS: &[&str] = &["geometry_msgs/msg/PoseStamped", "geometry_msgs/PoseStamped"];
const TRANSFORMS: &[&str] = &["tf2_msgs/msg/TFMessage", "tf2_msgs/TFMessage"];

/// The topics chosen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Topics {
    pub(super) odometry: String,
    pub(super) detections: String,
    pub(super) goal: Option<String>,
    pub(super) transforms: Vec<String>,
}

impl Topics {
    /// Chooses by the settings; where these leave it open, raw messages of this stack before ROS messages, which lose
    /// velocities and classes, and what knows velocities before what knows identities before mere poses. Shapes for a viewer
    /// are taken for obstacles only where the settings name their topic.
    pub(super) fn choose(reader: &McapReader, settings: &SourceSettings) -> Result<Self, SourceError> {
        let choice = Choice { reader };
        let obstacles = recorded_types();
        let obstacles: Vec<[&str; 2]> =
            obstacles.iter().map(|names| names.each_ref().map(String::as_str)).collect();
        let named: Vec<&[&str]> = obstacles.iter().map(|names| &names[..]).collect();
        let unasked = || obstacles.iter().filter(|names| !names.contains(&ros2::MarkerArray::NAME));
        let odometry =
            choice.named("source.odometry_topic", &settings.odometry_topic, "odometry", &[ODOMETRY])?;
        let detections =
            choice.named("source.detections_topic", &settings.detections_topic, "detections", &named)?;
        let goal = choice.named("source.goal_topic", &settings.goal_topic, "goals", &[GOALS])?;
        Ok(Self {
            odometry: odometry
                .or_else(|| choice.wire("robot_state"))
                .or_else(|| choice.first(ODOMETRY))
                .ok_or_else(|| choice.missing("odometry (nav_msgs/Odometry)"))?,
            detections: detections
                .or_else(|| choice.wire("detections"))
                .or_else(|| unasked().find_map(|names| choice.first(names)))
                .ok_or_else(|| {
                    choice.missing("detections (Detection3DArray, TrackedObjects, People or the like)")
                })?,
            goal: goal.or_else(|| choice.wire("goal")).or_else(|| choice.first_goal()),
            transforms: choice.of_types(TRANSFORMS).map(|channel| channel.topic.clone()).collect(),
        })
    }
}

struct Choice<'a> {
    reader: &'a McapReader,
}

impl Choice<'_> {
    fn channels(&self) -> impl Iterator<Item = &ChannelSummary> {
        self.reader.summary().channels.iter().filter(|channel| channel.is_readable && channel.messages > 0)
    }

    fn of_types<'b>(&'b self, types: &'b [&str]) -> impl Iterator<Item = &'b ChannelSummary> {
        self.channels().filter(|channel| types.contains(&channel.type_name.as_str()))
    }

    fn first(&self, types: &[&str]) -> Option<String> {
        self.of_types(types).next().map(|channel| channel.topic.clone())
    }

    /// A pose may be anything; only one that calls itself a goal is taken for one unasked.
    fn first_goal(&self) -> Option<String> {
        self.of_types(GOALS)
            .find(|channel| channel.topic.contains("goal"))
            .map(|channel| channel.topic.clone())
    }

    fn wire(&self, service: &str) -> Option<String> {
        let topic = wire_topic(service);
        self.channels().any(|channel| channel.topic == topic).then_some(topic)
    }

    /// The topic that the settings name; `None` if they leave it open.
    fn named(
        &self,
        key: &'static str,
        topic: &str,
        what: &'static str,
        types: &[&[&str]],
    ) -> Result<Option<String>, SourceError> {
        if topic.is_empty() {
            return Ok(None);
        }
        let fits = types.iter().any(|types| self.of_types(types).any(|channel| channel.topic == topic));
        if fits {
            return Ok(Some(topic.to_owned()));
        }
        Err(SourceError::NoSuchTopic {
            path: self.reader.path().to_owned(),
            key,
            topic: topic.to_owned(),
            what,
            available: self.available(),
        })
    }

    fn missing(&self, what: &'static str) -> SourceError {
        SourceError::Missing { path: self.reader.path().to_owned(), what, available: self.available() }
    }

    fn available(&self) -> String {
        let channels: Vec<_> = self
            .reader
            .summary()
            .channels
            .iter()
            .map(|channel| {
                format!("{} ({}, {} messages)", channel.topic, channel.type_name, channel.messages)
            })
            .collect();
        if channels.is_empty() { "no topics at all".to_owned() } else { channels.join(", ") }
    }
}
