//! From a recorded message's bytes to what it says.

use std::sync::Arc;

use crate::cdr;
use crate::refusal::RefusalReason;
use crate::ros2::{
    AccelStamped, Agents, Clock, Detection3DArray, DiagnosticArray, Float64, MarkerArray, ObjectArray,
    ObstacleArray, Odometry, Path, People, PoseArray, PoseStamped, Ros2Message, TFMessage, TrackedObjects,
    Twist, TwistStamped, hunav1, wire_signature,
};
use crate::wire::WireMessage;

/// A message of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedMessage {
    /// Topic it was recorded on.
    pub topic: Arc<str>,
    /// When the recorder received it, on the recorder's clock, ns.
    pub log_time_ns: u64,
    /// Sequence number that the recorder gave it.
    pub sequence: u32,
    /// What it says.
    pub kind: RecordedKind,
}

macro_rules! recorded_kinds {
    ($($(#[$doc:meta])* $variant:ident($ty:ty)),+ $(,)?) => {
        /// What a recorded message says.
        #[derive(Debug, Clone, PartialEq)]
        pub enum RecordedKind {
            $($(#[$doc])* $variant(Box<$ty>),)+
            /// A raw message of this stack.
            Wire(Box<WireMessage>),
        }

        /// How the messages of a channel are read.
        #[derive(Debug, Clone, PartialEq, Eq)]
        pub(crate) enum Codec { $($variant,)+ Wire(String) }

        impl Codec {
            /// The codecs of a ROS 2 type, each with the definition it reads: packages change their messages without renaming
            /// them, and some are known in several versions.
            fn of_ros2(type_name: &str) -> Vec<(Self, String)> {
                let mut codecs = Vec::new();
                $(if type_name == <$ty>::type_name() || type_name == <$ty>::NAME {
                    codecs.push((Self::$variant, <$ty>::definition()));
                })+
                codecs
            }

            /// Decodes a message.
            pub(crate) fn decode(&self, bytes: &[u8]) -> Result<RecordedKind, RefusalReason> {
                match self {
                    $(Self::$variant => match cdr::decode::<$ty>(bytes) {
                        Ok(message) => Ok(RecordedKind::$variant(Box::new(message))),
                        Err(_) => Err(RefusalReason::Undecodable),
                    },)+
                    Self::Wire(type_name) => {
                        WireMessage::parse(type_name, bytes).map(|message| RecordedKind::Wire(Box::new(message)))
                    }
                }
            }
        }
    };
}

recorded_kinds! {
    /// Where the robot was.
    Odometry(Odometry),
    /// Who was seen, with identities and extents.
    Detections(Detection3DArray),
    /// Who was seen, positions only.
    Poses(PoseArray),
    /// Who was followed, with identities, shapes and velocities.
    Tracked(TrackedObjects),
    /// Who was followed, with names and velocities.
    People(People),
    /// What a vehicle saw, with shapes and velocities.
    Objects(ObjectArray),
    /// Simulated people of HuNavSim 2.
    Agents(Agents),
    /// Simulated people of HuNavSim 1.
    AgentsOfHunav1(hunav1::Agents),
    /// What Nav2 followed, with extents and velocities.
    DynamicObstacles(ObstacleArray),
    /// A pose, usually a goal.
    Pose(PoseStamped),
    /// Poses to follow.
    Path(Path),
    /// A velocity command.
    Twist(TwistStamped),
    /// A velocity command that bears no stamp.
    UnstampedTwist(Twist),
    /// An acceleration command.
    Accel(AccelStamped),
    /// Transforms between frames.
    Transforms(TFMessage),
    /// A number.
    Number(Float64),
    /// Shapes for a viewer.
    Markers(MarkerArray),
    /// How parts of the robot were.
    Diagnostics(DiagnosticArray),
    /// Simulated time.
    Clock(Clock),
}

/// How the messages of a wire type are read, or why they are refused.
pub(crate) fn wire_codec(type_name: &str) -> Result<Codec, RefusalReason> {
    if WireMessage::knows(type_name) {
        Ok(Codec::Wire(type_name.to_owned()))
    } else {
        Err(RefusalReason::WireVersion)
    }
}

/// How the messages of a ROS 2 type are read, or why they are refused.
pub(crate) fn ros2_codec(
    message_encoding: &str,
    type_name: &str,
    schema_encoding: &str,
    schema: &[u8],
) -> Result<Codec, RefusalReason> {
    let mut codecs = Codec::of_ros2(type_name);
    if codecs.is_empty() {
        return Err(RefusalReason::UnknownSchema);
    }
    if message_encoding != "cdr" {
        return Err(RefusalReason::UnsupportedEncoding);
    }
    // Other definition languages are not compared; a mismatch then shows when messages do not decode.
    if schema_encoding == "ros2msg" && !schema.is_empty() {
        let theirs = std::str::from_utf8(schema).ok().and_then(|text| wire_signature(type_name, text));
        codecs.retain(|(_, ours)| theirs == wire_signature(type_name, ours));
    }
    codecs.into_iter().next().map(|(codec, _)| codec).ok_or(RefusalReason::ForeignDefinition)
}
