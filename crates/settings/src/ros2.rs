//! How the bridge joins a live ROS 2 graph: names, message types, quality of service.

use serde::{Deserialize, Serialize};

use crate::ControllerKind;
use crate::error::{Checked, positive, positive_ms, require};

/// Longest time between two commands, ms: drivers stop their robot where none comes for half a second.
const LONGEST_COMMAND_PERIOD_MS: u64 = 250;

/// How far ahead on a path the goal lies where nobody says otherwise, m.
const LOOKAHEAD_M: f64 = 1.5;

/// The bridge as a node of a ROS 2 graph. Which domain, and whether other machines are heard, the environment says
/// (`ROS_DOMAIN_ID`, `ROS_LOCALHOST_ONLY`), as for every ROS 2 program.
///
/// A topic without a leading slash lies in the node's namespace; `/tf` and `/tf_static` never do. A key that is left out is as
/// [`Ros2Settings::customary`] has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default = "Ros2Settings::customary")]
pub struct Ros2Settings {
    /// Name of the node.
    pub node_name: String,
    /// Its namespace, absolute.
    pub namespace: String,
    /// What arrives on the topic with obstacles.
    pub obstacles: ObstacleMessage,
    /// What is asked of the publishers of odometry and obstacles.
    pub reliability: Reliability,
    /// Topic of the velocity commands.
    pub command_topic: String,
    /// What is published there.
    pub command: CommandMessage,
    /// Time between two commands, ms.
    pub command_period_ms: u64,
    /// Topic of the robot's own velocity commands, which become the nominal ones: the place of Nav2's collision monitor, with
    /// `cmd_vel_smoothed` here and `cmd_vel` as `command_topic`. Needs `nominal.controller = "external"`. Absent: nobody's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nominal_topic: Option<String>,
    /// What arrives there; absent: Twist.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nominal: Option<CommandMessage>,
    /// Topic of a nav_msgs/Path to follow, such as Nav2's `plan`; its next point becomes the goal. Absent: none is heard.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path_topic: Option<String>,
    /// How far ahead on the path the goal lies, m; absent: 1.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path_lookahead_m: Option<f64>,
    /// Whether stamps are of `/clock` (rosgraph_msgs/Clock), as in a simulation; absent: of the date.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub use_sim_time: Option<bool>,
    /// Whether shapes for a viewer are published; absent: they are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub markers: Option<bool>,
}

/// Messages that say where obstacles are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ObstacleMessage {
    /// Boxes with identities, without velocities.
    #[serde(rename = "vision_msgs/Detection3DArray")]
    Detection3DArray,
    /// Positions only.
    #[serde(rename = "geometry_msgs/PoseArray")]
    PoseArray,
    /// Tracks with identities, shapes and velocities.
    #[serde(rename = "autoware_perception_msgs/TrackedObjects")]
    TrackedObjects,
    /// People with names and velocities, without extents.
    #[serde(rename = "people_msgs/People")]
    People,
    /// Detected and tracked objects of vehicles, with shapes and velocities.
    #[serde(rename = "derived_object_msgs/ObjectArray")]
    DerivedObjects,
    /// Simulated people of HuNavSim 2 (with `AgentBehavior` and behaviour trees), with radii and velocities.
    #[serde(rename = "hunav_msgs/Agents")]
    Agents,
    /// The same of HuNavSim 1 (Foxy, Humble), whose message bears the same name.
    #[serde(rename = "hunav_msgs/Agents of HuNavSim 1")]
    AgentsOfHunav1,
    /// Nav2's tracked obstacles, with extents and velocities.
    #[serde(rename = "nav2_dynamic_msgs/ObstacleArray")]
    DynamicObstacles,
    /// Cylinders, spheres and cubes drawn for a viewer, with identities, without velocities.
    #[serde(rename = "visualization_msgs/MarkerArray")]
    MarkerArray,
}

/// Messages that command a velocity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum CommandMessage {
    /// What drivers up to ROS 2 Jazzy take by default.
    #[serde(rename = "geometry_msgs/Twist")]
    Twist,
    /// What drivers from ROS 2 Kilted on take by default.
    #[serde(rename = "geometry_msgs/TwistStamped")]
    TwistStamped,
}

/// What is asked of a publisher. A best-effort subscription hears every publisher, a reliable one only reliable ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reliability {
    /// What is lost is lost: the sensor profile.
    BestEffort,
    /// What is lost is sent again: the default profile.
    Reliable,
}

impl Ros2Settings {
    /// What ROS 2 robots have where nobody says otherwise: `/cmd_vel` as Twist, 100 times a second.
    pub fn customary() -> Self {
        Self {
            node_name: "cncbf".to_owned(),
            namespace: "/".to_owned(),
            obstacles: ObstacleMessage::Detection3DArray,
            reliability: Reliability::BestEffort,
            command_topic: "cmd_vel".to_owned(),
            command: CommandMessage::Twist,
            command_period_ms: 10,
            nominal_topic: None,
            nominal: None,
            path_topic: None,
            path_lookahead_m: None,
            use_sim_time: None,
            markers: None,
        }
    }

    /// The full name of a topic: one without a leading slash lies in the namespace.
    pub fn absolute(&self, topic: &str) -> String {
        if topic.starts_with('/') {
            topic.to_owned()
        } else {
            format!("{}/{topic}", self.namespace.trim_end_matches('/'))
        }
    }

    /// Whether stamps are of `/clock`.
    pub fn uses_sim_time(&self) -> bool {
        self.use_sim_time.unwrap_or(false)
    }

    /// How far ahead on a path the goal lies, m.
    pub fn lookahead_m(&self) -> f64 {
        self.path_lookahead_m.unwrap_or(LOOKAHEAD_M)
    }

    /// A goal that is reached as soon as it is said would stop the robot on its way.
    pub(crate) fn validate_lookahead(&self, goal_tolerance_m: f64) -> Checked {
        require(
            self.path_topic.is_none() || self.lookahead_m() >= 2.0 * goal_tolerance_m,
            "source.ros2.path_lookahead_m",
            self.lookahead_m(),
            "at least twice nominal.goal_tolerance_m, or the robot stops at every point of its path",
        )
    }

    /// The robot's own commands take the nominal controller's place, so that nobody else may have it.
    pub(crate) fn validate_controller(&self, controller: ControllerKind) -> Checked {
        require(
            self.nominal_topic.is_none() || controller == ControllerKind::External,
            "nominal.controller",
            controller.label(),
            "`external` where source.ros2.nominal_topic names whose commands are filtered",
        )
    }

    pub(crate) fn validate(&self) -> Checked {
        require(
            is_token(&self.node_name),
            "source.ros2.node_name",
            &self.node_name,
            "a name of letters, digits and _",
        )?;
        let namespace = self.namespace.as_str();
        let is_namespace = namespace == "/" || (namespace.starts_with('/') && is_name(namespace));
        require(is_namespace, "source.ros2.namespace", namespace, "an absolute name such as / or /robot1")?;
        let topics = [
            ("source.ros2.command_topic", Some(&self.command_topic)),
            ("source.ros2.nominal_topic", self.nominal_topic.as_ref()),
            ("source.ros2.path_topic", self.path_topic.as_ref()),
        ];
        for (key, topic) in topics.into_iter().filter_map(|(key, topic)| Some((key, topic?))) {
            require(is_name(topic), key, topic, "the name of a topic such as cmd_vel")?;
        }
        if let Some(lookahead_m) = self.path_lookahead_m {
            positive("source.ros2.path_lookahead_m", lookahead_m)?;
        }
        require(
            self.nominal_topic.is_none() || self.path_topic.is_none(),
            "source.ros2.path_topic",
            self.path_topic.as_deref().unwrap_or_default(),
            "absent where nominal_topic is given: the robot's own controller follows its own path",
        )?;
        positive_ms("source.ros2.command_period_ms", self.command_period_ms)?;
        require(
            self.command_period_ms <= LONGEST_COMMAND_PERIOD_MS,
            "source.ros2.command_period_ms",
            self.command_period_ms,
            "at most 250: drivers stop their robot where no command comes for half a second",
        )
    }
}

/// Whether `name` is tokens with slashes between them, perhaps one before the first.
fn is_name(name: &str) -> bool {
    name.strip_prefix('/').unwrap_or(name).split('/').all(is_token)
}

/// Whether ROS 2 takes this as a part of a name.
fn is_token(token: &str) -> bool {
    token.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_')
        && token.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
        && !token.contains("__")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_that_is_left_out_is_as_customary() {
        let read = toml::from_str::<Ros2Settings>("nominal_topic = \"cmd_vel_smoothed\"").expect("enough");
        assert_eq!(
            read,
            Ros2Settings { nominal_topic: Some("cmd_vel_smoothed".to_owned()), ..Ros2Settings::customary() }
        );
        assert!(toml::from_str::<Ros2Settings>("command_topc = \"cmd_vel\"").is_err(), "an unknown key");
    }

    #[test]
    fn the_customary_names_are_fine_and_unusable_ones_are_refused_by_name() {
        assert!(Ros2Settings::customary().validate().is_ok());
        let refused = |change: fn(&mut Ros2Settings)| {
            let mut settings = Ros2Settings::customary();
            change(&mut settings);
            settings.validate().expect_err("unusable").to_string()
        };
        assert!(refused(|s| s.node_name = "my node".to_owned()).contains("source.ros2.node_name"));
        assert!(refused(|s| s.namespace = "robot1".to_owned()).contains("source.ros2.namespace"));
        assert!(refused(|s| s.namespace = "/robot1/".to_owned()).contains("source.ros2.namespace"));
        assert!(refused(|s| s.command_topic = "cmd__vel".to_owned()).contains("source.ros2.command_topic"));
        assert!(refused(|s| s.nominal_topic = Some("a b".to_owned())).contains("source.ros2.nominal_topic"));
        assert!(refused(|s| s.path_topic = Some("my plan".to_owned())).contains("source.ros2.path_topic"));
        assert!(refused(|s| s.path_lookahead_m = Some(0.0)).contains("source.ros2.path_lookahead_m"));
        assert!(refused(|s| s.command_period_ms = 500).contains("source.ros2.command_period_ms"));
    }

    #[test]
    fn the_goal_on_a_path_lies_well_beyond_its_tolerance() {
        let mut settings = Ros2Settings::customary();
        settings.path_lookahead_m = Some(0.5);
        assert!(settings.validate_lookahead(0.3).is_ok(), "no path is followed");
        settings.path_topic = Some("plan".to_owned());
        let refusal = settings.validate_lookahead(0.3).expect_err("too short").to_string();
        assert!(refusal.contains("source.ros2.path_lookahead_m"), "{refusal}");
        settings.path_lookahead_m = None;
        assert!(settings.validate_lookahead(0.3).is_ok());
    }

    #[test]
    fn relative_topics_lie_in_the_namespace() {
        let mut settings = Ros2Settings::customary();
        assert_eq!(settings.absolute("odom"), "/odom");
        settings.namespace = "/robot1".to_owned();
        assert_eq!(settings.absolute("odom"), "/robot1/odom");
        assert_eq!(settings.absolute("/goal_pose"), "/goal_pose");
    }
}
