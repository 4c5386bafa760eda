//! Every topic that is heard, with the messages that the settings name.

use recording::ros2::{Clock, Odometry, Path, PoseStamped, Ros2Message, TFMessage, Twist, TwistStamped};
use ros2_client::dds::rustdds::mio1::Registry;
use settings::{CommandMessage, ObstacleMessage, Reliability, Ros2Settings, SourceSettings};

use super::arrival::Arrival;
use super::error::RosError;
use super::graph::{Graph, Profile};
use super::input::Input;
use super::intake::Intake;
use crate::obstacle_frames::{ObstacleFrame, for_each_obstacle_message};
use crate::source::BridgeEvent;

/// What takes events over.
type Put<'a> = dyn FnMut(BridgeEvent) + 'a;

/// Every topic that is heard.
pub(super) struct Inputs {
    clock: Option<Input<Clock>>,
    static_transforms: Input<TFMessage>,
    transforms: Input<TFMessage>,
    odometry: Input<Odometry>,
    obstacles: Box<dyn Obstacles>,
    aim: Aim,
}

/// What says where the robot shall go.
#[expect(clippy::large_enum_variant, reason = "there is one")]
enum Aim {
    /// Goals, and perhaps paths.
    Places { goals: Input<PoseStamped>, paths: Option<Input<Path>> },
    /// The robot's own controller, which needs neither.
    Upstream(Input<Twist>),
    /// The same, with stamps.
    StampedUpstream(Input<TwistStamped>),
}

/// The topic with obstacles, whatever its type.
trait Obstacles: Send {
    fn take(&mut self, intake: &mut Intake, put: &mut Put<'_>) -> u64;
    fn tell(&mut self, now_ns: u64);
}

impl<M: ObstacleFrame + Ros2Message + Send + 'static> Obstacles for Input<M> {
    fn take(&mut self, intake: &mut Intake, put: &mut Put<'_>) -> u64 {
        self.drain(|message, at| intake.obstacles(message, at).map(&mut *put))
    }

    fn tell(&mut self, now_ns: u64) {
        Self::tell(self, now_ns);
    }
}

/// Opens topics, all in the same way.
struct Opener<'a> {
    graph: &'a mut Graph,
    registry: &'a Registry,
    now_ns: u64,
}

impl Opener<'_> {
    fn open<M: Ros2Message + 'static>(
        &mut self,
        topic: String,
        profile: Profile,
    ) -> Result<Input<M>, RosError> {
        Input::open(self.graph, topic, profile, self.registry, self.now_ns)
    }
}

macro_rules! obstacles_of {
    ($($name:ident, $message:ty, $variant:ident);+) => {
        /// Opens the topic with obstacles.
        fn open_obstacles(
            opener: &mut Opener<'_>,
            kind: ObstacleMessage,
            topic: String,
            profile: Profile,
        ) -> Result<Box<dyn Obstacles>, RosError> {
            Ok(match kind {
                $(ObstacleMessage::$name => Box::new(opener.open::<$message>(topic, profile)?),)+
            })
        }
    };
}
for_each_obstacle_message!(obstacles_of);

impl Inputs {
    /// Opens the topics of the settings; arrivals show at `registry`.
    pub(super) fn open(
        graph: &mut Graph,
        source: &SourceSettings,
        ros2: &Ros2Settings,
        registry: &Registry,
    ) -> Result<Self, RosError> {
        let opener = &mut Opener { graph, registry, now_ns: Arrival::now().stack_ns };
        let name = |set: &str, customary: &str| ros2.absolute(if set.is_empty() { customary } else { set });
        let stream = Profile::Stream(ros2.reliability);
        let reliable = Profile::Stream(Reliability::Reliable);
        let best_effort = Profile::Stream(Reliability::BestEffort);
        let upstream = ros2.nominal_topic.as_deref().map(|topic| ros2.absolute(topic));
        let aim = match upstream.zip(Some(ros2.nominal.unwrap_or(CommandMessage::Twist))) {
            None => Aim::Places {
                goals: opener.open(name(&source.goal_topic, "goal_pose"), reliable)?,
                paths: ros2
                    .path_topic
                    .as_deref()
                    .map(|topic| opener.open(ros2.absolute(topic), reliable))
                    .transpose()?,
            },
            Some((topic, CommandMessage::Twist)) => Aim::Upstream(opener.open(topic, stream)?),
            Some((topic, CommandMessage::TwistStamped)) => Aim::StampedUpstream(opener.open(topic, stream)?),
        };
        let clock =
            ros2.uses_sim_time().then(|| opener.open("/clock".to_owned(), best_effort)).transpose()?;
        let obstacles = name(&source.detections_topic, "detections");
        Ok(Self {
            clock,
            static_transforms: opener.open("/tf_static".to_owned(), Profile::Latched)?,
            transforms: opener.open("/tf".to_owned(), reliable)?,
            odometry: opener.open(name(&source.odometry_topic, "odom"), stream)?,
            obstacles: open_obstacles(opener, ros2.obstacles, obstacles, stream)?,
            aim,
        })
    }

    /// Takes what has arrived. The clock and transforms first: what arrives together with them may need them. Returns how many
    /// messages were refused.
    pub(super) fn take(&mut self, intake: &mut Intake, put: &mut Put<'_>) -> u64 {
        let mut refused = self.clock.as_mut().map_or(0, |clock| clock.drain(|m, at| intake.clock(m, at)));
        refused += self.static_transforms.drain(|message, at| intake.transforms(message, true, at));
        refused += self.transforms.drain(|message, at| intake.transforms(message, false, at));
        refused += self.odometry.drain(|message, at| {
            put(intake.odometry(message, at)?);
            intake.next_waypoint(at).into_iter().for_each(&mut *put);
            Ok(())
        });
        refused += self.obstacles.take(intake, put);
        refused + self.aim.take(intake, put)
    }

    /// Tells the log what has changed. Goals may be rare and transforms absent; the others may be neither.
    pub(super) fn tell(&mut self, now_ns: u64) {
        if let Some(clock) = &mut self.clock {
            clock.tell(now_ns);
        }
        self.odometry.tell(now_ns);
        self.obstacles.tell(now_ns);
        self.aim.tell(now_ns);
        self.transforms.tell_refusals();
        self.static_transforms.tell_refusals();
    }
}

impl Aim {
    fn take(&mut self, intake: &mut Intake, put: &mut Put<'_>) -> u64 {
        match self {
            Self::Places { goals, paths } => {
                let refused = paths.as_mut().map_or(0, |paths| {
                    paths.drain(|message, at| {
                        intake.path(message, at)?.into_iter().for_each(&mut *put);
                        Ok(())
                    })
                });
                refused + goals.drain(|message, at| intake.goal(message, at).map(&mut *put))
            }
            Self::Upstream(input) => {
                input.drain(|message, at| intake.upstream(message, None, at).map(&mut *put))
            }
            Self::StampedUpstream(input) => input.drain(|message, at| {
                intake.upstream(&message.twist, Some(&message.header), at).map(&mut *put)
            }),
        }
    }

    fn tell(&mut self, now_ns: u64) {
        match self {
            Self::Places { goals, paths } => {
                goals.tell_refusals();
                if let Some(paths) = paths {
                    paths.tell_refusals();
                }
            }
            Self::Upstream(input) => input.tell(now_ns),
            Self::StampedUpstream(input) => input.tell(now_ns),
        }
    }
}
