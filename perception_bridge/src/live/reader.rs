//! The thread that hears the graph: takes messages as they arrive, has them checked, hands them to the bridge's loop.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use recording::ros2::{Detection3DArray, Odometry, PoseArray, PoseStamped, TFMessage, TrackedObjects};
use ros2_client::dds::rustdds::mio1::{Events, Poll, Registry};
use settings::{ObstacleMessage, Reliability, Ros2Settings, SourceSettings};

use super::arrival::Arrival;
use super::error::RosError;
use super::graph::{Graph, Profile};
use super::hand_over::HandOver;
use super::input::Input;
use super::intake::Intake;
use crate::source::BridgeEvent;

/// Longest sleep, so that the wish to end is heard.
const LONGEST_WAIT: Duration = Duration::from_millis(100);
/// How often the log is told what has changed, ns.
const TELL_PERIOD_NS: u64 = 250_000_000;
/// Topics that one look can tell of.
const EVENTS: usize = 16;

/// The running thread; ends when dropped.
pub(super) struct Reader {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Reader {
    /// Opens the topics of the settings and starts the thread.
    pub(super) fn start(
        graph: &mut Graph,
        source: &SourceSettings,
        ros2: &Ros2Settings,
        intake: Intake,
        hand_over: HandOver,
    ) -> Result<Self, RosError> {
        let failed = |error: io::Error| RosError::Thread { cause: error.to_string() };
        let poll = Poll::new().map_err(failed)?;
        let inputs = Inputs::open(graph, source, ros2, poll.registry())?;
        let listening = Listening { poll, inputs, intake, hand_over };
        let stop = Arc::new(AtomicBool::new(false));
        let (stopped, span) = (Arc::clone(&stop), tracing::Span::current());
        let thread = std::thread::Builder::new()
            .name("cncbf-ros2-in".to_owned())
            .spawn(move || span.in_scope(|| listening.run(&stopped)))
            .map_err(failed)?;
        Ok(Self { stop, thread: Some(thread) })
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Every topic that is heard.
struct Inputs {
    odometry: Input<Odometry>,
    obstacles: Obstacles,
    goals: Input<PoseStamped>,
    transforms: Input<TFMessage>,
    static_transforms: Input<TFMessage>,
}

/// The topic with obstacles, with the type that the settings name.
enum Obstacles {
    Boxes(Input<Detection3DArray>),
    Poses(Input<PoseArray>),
    Tracks(Input<TrackedObjects>),
}

impl Inputs {
    fn open(
        graph: &mut Graph,
        source: &SourceSettings,
        ros2: &Ros2Settings,
        registry: &Registry,
    ) -> Result<Self, RosError> {
        let now_ns = Arrival::now().stack_ns;
        let name = |set: &str, customary: &str| ros2.absolute(if set.is_empty() { customary } else { set });
        let stream = Profile::Stream(ros2.reliability);
        let reliable = Profile::Stream(Reliability::Reliable);
        let topic = name(&source.detections_topic, "detections");
        let obstacles = match ros2.obstacles {
            ObstacleMessage::Detection3DArray => {
                Obstacles::Boxes(Input::open(graph, topic, stream, registry, now_ns)?)
            }
            ObstacleMessage::PoseArray => {
                Obstacles::Poses(Input::open(graph, topic, stream, registry, now_ns)?)
            }
            ObstacleMessage::TrackedObjects => {
                Obstacles::Tracks(Input::open(graph, topic, stream, registry, now_ns)?)
            }
        };
        let mut open = |topic: &str, profile| Input::open(graph, topic.to_owned(), profile, registry, now_ns);
        let (transforms, static_transforms) = (open("/tf", reliable)?, open("/tf_static", Profile::Latched)?);
        let odometry = name(&source.odometry_topic, "odom");
        let goal = name(&source.goal_topic, "goal_pose");
        Ok(Self {
            odometry: Input::open(graph, odometry, stream, registry, now_ns)?,
            obstacles,
            goals: Input::open(graph, goal, reliable, registry, now_ns)?,
            transforms,
            static_transforms,
        })
    }

    /// Goals may be rare and transforms absent; odometry and obstacles may be neither.
    fn tell(&mut self, now_ns: u64) {
        self.odometry.tell(now_ns);
        match &mut self.obstacles {
            Obstacles::Boxes(input) => input.tell(now_ns),
            Obstacles::Poses(input) => input.tell(now_ns),
            Obstacles::Tracks(input) => input.tell(now_ns),
        }
        self.goals.tell_refusals();
        self.transforms.tell_refusals();
        self.static_transforms.tell_refusals();
    }
}

/// What the thread owns.
struct Listening {
    poll: Poll,
    inputs: Inputs,
    intake: Intake,
    hand_over: HandOver,
}

impl Listening {
    fn run(mut self, stop: &AtomicBool) {
        let mut events = Events::with_capacity(EVENTS);
        let mut told_ns = Arrival::now().stack_ns;
        while !stop.load(Ordering::Acquire) {
            // A poll that fails leaves a look at every topic ten times a second.
            if self.poll.poll(&mut events, Some(LONGEST_WAIT)).is_err() {
                std::thread::sleep(LONGEST_WAIT);
            }
            self.take();
            let now_ns = Arrival::now().stack_ns;
            if now_ns.saturating_sub(told_ns) >= TELL_PERIOD_NS {
                told_ns = now_ns;
                self.inputs.tell(now_ns);
                self.intake.forget(now_ns);
            }
        }
        self.inputs.tell(Arrival::now().stack_ns);
        let refused = self.intake.refused_detections();
        if refused > 0 {
            tracing::warn!(refused, "single detections refused within frames that were used");
        }
    }

    /// Transforms first: what arrives together with them may need them.
    fn take(&mut self) {
        let Self { inputs, intake, hand_over, .. } = self;
        let mut refused = inputs.static_transforms.drain(|message, at| intake.transforms(message, true, at));
        refused += inputs.transforms.drain(|message, at| intake.transforms(message, false, at));
        let put = |event: BridgeEvent| hand_over.put(event);
        refused += inputs.odometry.drain(|message, at| intake.odometry(message, at).map(put));
        refused += match &mut inputs.obstacles {
            Obstacles::Boxes(input) => input.drain(|message, at| intake.boxes(message, at).map(put)),
            Obstacles::Poses(input) => input.drain(|message, at| intake.poses(message, at).map(put)),
            Obstacles::Tracks(input) => input.drain(|message, at| intake.tracks(message, at).map(put)),
        };
        refused += inputs.goals.drain(|message, at| intake.goal(message, at).map(put));
        let counters = hand_over.counters();
        (0..refused).for_each(|_| counters.count_refused());
    }
}
