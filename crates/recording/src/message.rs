//! From a recorded message's bytes to what it says.

use std::sync::Arc;

use crate::cdr;
use crate::refusal::RefusalReason;
use crate::ros2::{
    AccelStamped, Detection3DArray, Float64, MarkerArray, Odometry, PoseArray, PoseStamped, Ros2Message,
    TFMessage, TrackedObjects, TwistStamped, wire_signature,
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
            /// The codec of a ROS 2 type, with the definition it reads.
            fn of_ros2(type_name: &str) -> Option<(Self, String)> {
                $(if type_name == <$ty>::type_name() || type_name == <$ty>::NAME {
                    return Some((Self::$variant, <$ty>::definition()));
                })+
                None
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
    /// A pose, usually a goal.
    Pose(PoseStamped),
    /// A velocity command.
    Twist(TwistStamped),
    /// An acceleration command.
    Accel(AccelStamped),
    /// Transforms between frames.
    Transforms(TFMessage),
    /// A number.
    Number(Float64),
    /// Shapes for a viewer.
    Markers(MarkerArray),
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
    let (codec, ours) = Codec::of_ros2(type_name).ok_or(RefusalReason::UnknownSchema)?;
    if message_encoding != "cdr" {
        return Err(RefusalReason::UnsupportedEncoding);
    }
    // Other definition languages are not compared; a mismatch then shows when messages do not decode.
    if schema_encoding == "ros2msg" && !schema.is_empty() {
        let theirs = std::str::from_utf8(schema).ok().and_then(|text| wire_signature(type_name, text));
        if theirs != wire_signature(type_name, &ours) {
            return Err(RefusalReason::ForeignDefinition);
        }
    }
    Ok(codec)
}
