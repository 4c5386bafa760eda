//! A live ROS 2 graph as a source: topics in, velocity commands out.
//!
//! Everything that allocates, locks or waits is left to two threads: one receives, decodes and hands over finished events
//! ([`reader`]), one publishes commands ([`commander`]). The bridge's loop only takes from and puts into bounded queues, whose
//! places exist before it begins; what finds no place is dropped and counted.
//!
//! Not here: any transform that this stack would publish.

mod arrival;
mod board;
mod commander;
mod diagnostics;
mod environment;
mod error;
mod filter_state;
mod graph;
mod hand_over;
mod input;
mod inputs;
mod intake;
mod outbox;
mod outlet;
mod painter;
mod path;
mod reader;
mod speaker;
mod survey;
mod timebase;
mod watch;

use std::sync::Arc;

use messages::{Goal, RobotState, SafeCommand, SourceKind, SourceStatus};
use node_runtime::Waker;
use settings::{RobotKind, Ros2Settings, Settings};

pub use error::RosError;
pub use painter::ZeroLevelOf;
pub use survey::{GraphSurvey, SurveyedTopic, survey};

use crate::command_sink::{CommandSink, SinkState};
use crate::source::{BridgeEvent, Source};
use board::SinkBoard;
use commander::Commander;
use environment::Environment;
use graph::Graph;
use hand_over::{Counters, HandOver, WakerSlot};
use intake::Intake;
use reader::Reader;
use speaker::{Shared, Speaker};
use std::sync::mpsc::Receiver;
use timebase::RosTime;

const NS_PER_MS: u64 = 1_000_000;

/// The topics of a ROS 2 graph, heard and driven live.
///
/// Commands leave at a fixed rate, whether or not the filter speaks: the [`CommandSink`] brakes by itself. They slow down from
/// the speed commanded last, so that they come to a halt even where odometry has died.
pub struct RosSource {
    events: Receiver<BridgeEvent>,
    counters: Arc<Counters>,
    waker: WakerSlot,
    /// None where the robot is left alone.
    commander: Option<Commander>,
    /// None until the source is told whom it serves.
    speaker: Option<Speaker>,
    /// Last but the graph: it takes up to a tenth of a second to end.
    reader: Reader,
    graph: Graph,
    /// As the graph needs them.
    settings: Settings,
    /// What messages are stamped with.
    time: RosTime,
    sink: CommandSink,
    sink_board: Arc<SinkBoard>,
    period_ns: u64,
    next_command_ns: u64,
    /// When a command was last given, ns, and which: `[m/s, rad/s]`.
    commanded: (u64, [f64; 2]),
    /// Whether the robot's own controller commands what the filter filters.
    heeds_upstream: bool,
    /// Age at which the filter would brake for want of its commands, ns.
    upstream_silence_ns: u64,
    goal_tolerance_m: f64,
    goal: Option<Goal>,
    goal_reached: bool,
    robot_m: Option<[f64; 2]>,
    path_length_m: f64,
    accepted: u64,
    began_ns: Option<u64>,
}

impl RosSource {
    /// Joins the graph that the environment names and begins to listen. Commands leave once it is polled; with `shadow` none ever
    /// does, and the topic for them is not even opened.
    ///
    /// # Errors
    /// [`RosError`] if the environment or the robot's kind is unusable, or DDS refuses.
    pub fn open(settings: &Settings, shadow: bool) -> Result<Self, RosError> {
        Self::open_in(Environment::read()?, settings, shadow)
    }

    /// Whether environment and settings name a place in a graph that can be taken, without joining it.
    ///
    /// # Errors
    /// As [`Self::open`], but for what DDS may refuse.
    pub fn check(settings: &Settings, shadow: bool) -> Result<(), RosError> {
        Environment::read()?;
        Self::place(settings, shadow).map(|_| ())
    }

    /// The settings of the robot's place in the graph.
    fn place(settings: &Settings, shadow: bool) -> Result<Ros2Settings, RosError> {
        match settings.robot.kind {
            RobotKind::Unicycle => {}
            RobotKind::DoubleIntegrator => return Err(RosError::TakesAccelerations),
        }
        let ros2 = settings.source.ros2.clone().unwrap_or_else(Ros2Settings::customary);
        if let Some(topic) = ros2.nominal_topic.as_deref().map(|topic| ros2.absolute(topic))
            && !shadow
            && topic == ros2.absolute(&ros2.command_topic)
        {
            return Err(RosError::HearsItself { topic });
        }
        Ok(ros2)
    }

    fn open_in(environment: Environment, settings: &Settings, shadow: bool) -> Result<Self, RosError> {
        let ros2 = Self::place(settings, shadow)?;
        let mut graph = Graph::join(&ros2, environment)?;
        let intake = Intake::new(settings);
        let time = intake.ros_time();
        let commander = if shadow { None } else { Some(Commander::start(&mut graph, &ros2, time.clone())?) };
        let (hand_over, events) = HandOver::new();
        let (counters, waker) = (hand_over.counters(), hand_over.waker());
        let reader = Reader::start(&mut graph, &settings.source, &ros2, intake, hand_over)?;
        Ok(Self {
            events,
            counters,
            waker,
            commander,
            reader,
            graph,
            speaker: None,
            settings: settings.clone(),
            sink_board: Arc::new(SinkBoard::new()),
            time,
            sink: CommandSink::new(settings),
            period_ns: ros2.command_period_ms * NS_PER_MS,
            next_command_ns: 0,
            commanded: (0, [0.0; 2]),
            heeds_upstream: ros2.nominal_topic.is_some(),
            upstream_silence_ns: settings.filter.nominal_max_silence_ms * NS_PER_MS,
            goal_tolerance_m: settings.nominal.goal_tolerance_m,
            goal: None,
            goal_reached: false,
            robot_m: None,
            path_length_m: 0.0,
            accepted: 0,
            began_ns: None,
        })
    }

    /// Gives the command that holds at `now_ns`. Periods that passed unused are left out, not made up for.
    fn drive(&mut self, now_ns: u64) {
        let (last_ns, [speed_mps, _]) = self.commanded;
        let dt_ns = now_ns.saturating_sub(last_ns).min(2 * self.period_ns);
        let control = self.sink.control(now_ns, dt_ns, [speed_mps, 0.0]);
        self.commanded = (now_ns, control);
        self.sink_board.post(self.sink.state());
        if self.commander.as_ref().is_some_and(|commander| !commander.give(control)) {
            self.counters.count_replaced_command();
        }
        let late_ns = now_ns.saturating_sub(self.next_command_ns);
        self.next_command_ns = now_ns + self.period_ns - late_ns % self.period_ns;
    }

    fn note(&mut self, event: &BridgeEvent) {
        self.accepted += 1;
        match event {
            BridgeEvent::RobotState(state) => self.note_robot(state),
            BridgeEvent::Detections(_) | BridgeEvent::NominalCommand(_) => {}
            BridgeEvent::Goal(goal) => {
                // Said again, it is still the goal that was reached.
                let aim = |goal: &Goal| (goal.position_in_odom_m, goal.heading_rad);
                self.goal_reached &= self.goal.as_ref().is_some_and(|old| aim(old) == aim(goal));
                self.goal = Some(*goal);
            }
        }
    }

    fn note_robot(&mut self, state: &RobotState) {
        let [x, y] = state.position_in_odom_m;
        if let Some([old_x, old_y]) = self.robot_m {
            self.path_length_m += (x - old_x).hypot(y - old_y);
        }
        self.robot_m = Some([x, y]);
        self.goal_reached |= self.goal_distance_m() <= self.goal_tolerance_m;
    }

    fn goal_distance_m(&self) -> f64 {
        let places = self.goal.zip(self.robot_m);
        places.map_or(f64::INFINITY, |(goal, [x, y])| {
            (goal.position_in_odom_m[0] - x).hypot(goal.position_in_odom_m[1] - y)
        })
    }
}

impl Source for RosSource {
    fn wake_with(&mut self, waker: Waker) {
        self.waker.fill(waker);
    }

    fn serve(&mut self, instance: &str, zero_level: Option<ZeroLevelOf>) {
        let shared = Shared {
            sink: self.commander.is_some().then(|| Arc::clone(&self.sink_board)),
            counters: Arc::clone(&self.counters),
            time: self.time.clone(),
        };
        let speaker = Speaker::start(&mut self.graph, &self.settings, instance, shared, zero_level);
        // The robot is safe without: what is not told is in the log and in the recording.
        self.speaker =
            speaker.inspect_err(|error| tracing::warn!(%error, "ROS 2 is not told how the stack is")).ok();
    }

    fn gives_nominal_commands(&self) -> bool {
        self.heeds_upstream
    }

    fn next_due_ns(&self) -> Option<u64> {
        Some(self.next_command_ns)
    }

    fn poll(&mut self, now_ns: u64) -> Option<BridgeEvent> {
        self.began_ns.get_or_insert(now_ns);
        if now_ns >= self.next_command_ns {
            self.drive(now_ns);
        }
        // Nothing there, or nobody left to put something there: the ladder brakes for want of robot states.
        let mut event = self.events.try_recv().ok()?;
        // The filter takes a nominal command for as old as its handing over. What waited while this process slept is older.
        while is_overdue(&event, now_ns, self.upstream_silence_ns) {
            self.counters.count_refused();
            event = self.events.try_recv().ok()?;
        }
        self.note(&event);
        Some(event)
    }

    fn has_failed(&self) -> bool {
        self.reader.has_ended() || self.commander.as_ref().is_some_and(Commander::has_ended)
    }

    fn command(&mut self, command: &SafeCommand, now_ns: u64) {
        self.sink.take(command, now_ns);
    }

    fn status(&self, now_ns: u64) -> SourceStatus {
        SourceStatus {
            published_ns: now_ns,
            elapsed_ns: self.began_ns.map_or(0, |began_ns| now_ns.saturating_sub(began_ns)),
            total_ns: 0,
            accepted: self.accepted,
            refused: self.counters.lost_inputs() + self.sink.refusals(),
            min_clearance_m: f64::INFINITY,
            clearance_m: f64::INFINITY,
            path_length_m: self.path_length_m,
            goal_distance_m: self.goal_distance_m(),
            collisions: 0,
            goal_reached: u32::from(self.goal_reached),
            finished: 0,
            kind: SourceKind::Ros2.code(),
        }
    }

    fn sink_state(&self) -> Option<SinkState> {
        self.commander.is_some().then(|| self.sink.state())
    }
}

/// Whether this is a nominal command that arrived longer than `limit_ns` ago.
const fn is_overdue(event: &BridgeEvent, now_ns: u64, limit_ns: u64) -> bool {
    match event {
        BridgeEvent::NominalCommand(command) => now_ns.saturating_sub(command.received_ns) > limit_ns,
        BridgeEvent::RobotState(_) | BridgeEvent::Detections(_) | BridgeEvent::Goal(_) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use messages::{ControlKind, NominalCommand};
    use node_runtime::{Clock, RealClock};

    const MS: u64 = 1_000_000;

    fn settings() -> Settings {
        let text = include_str!("../../config/ground_robot.toml");
        Settings::parse(text, "shipped".as_ref(), ".".as_ref()).expect("shipped settings")
    }

    /// In a graph of nobody else's, on this machine alone.
    fn alone(settings: &Settings, shadow: bool) -> RosSource {
        let environment = Environment { domain_id: 201, localhost_only: true };
        RosSource::open_in(environment, settings, shadow).expect("a machine with a loopback interface")
    }

    // What tests/conformance.rs holds against the sources that come to an end.
    #[test]
    fn a_graph_without_anybody_keeps_the_promises_of_a_source() {
        for shadow in [false, true] {
            let mut source = alone(&settings(), shadow);
            let now_ns = RealClock.now_ns();
            assert_eq!(source.poll(now_ns), None);
            let due_ns = source.next_due_ns().expect("a live graph does not end");
            assert!(due_ns > now_ns && due_ns <= now_ns + 10 * MS, "due, but not handed over");
            assert_eq!(source.sink_state(), (!shadow).then_some(SinkState::Waiting));
            let mut command = SafeCommand {
                control: [0.5, 0.0],
                control_kind: ControlKind::Unicycle.code(),
                ..SafeCommand::zeroed()
            };
            command.ledger.filter_woke_ns = due_ns;
            source.command(&command, due_ns);
            source.poll(due_ns);
            assert_eq!(source.sink_state(), (!shadow).then_some(SinkState::Following));
            source.poll(due_ns + 30 * MS);
            let silent = SinkState::Braking(messages::Reason::SilentFilter);
            assert_eq!(source.sink_state(), (!shadow).then_some(silent));
            let status = source.status(due_ns + 30 * MS);
            assert_eq!((status.kind, status.finished), (SourceKind::Ros2.code(), 0));
            assert_eq!(status.elapsed_ns, due_ns + 30 * MS - now_ns);
            assert!(!source.has_failed() && !source.gives_nominal_commands());
        }
    }

    #[test]
    fn a_topic_is_not_both_heard_and_driven_unless_the_robot_is_left_alone() {
        let mut settings = settings();
        let mut ros2 = Ros2Settings::customary();
        ros2.nominal_topic = Some("/cmd_vel".to_owned());
        settings.source.ros2 = Some(ros2);
        let environment = Environment { domain_id: 201, localhost_only: true };
        let refused = RosSource::open_in(environment, &settings, false).err();
        assert!(matches!(refused, Some(RosError::HearsItself { .. })), "{refused:?}");
        let source = alone(&settings, true);
        assert!(source.gives_nominal_commands());
        let spoken = source.graph.records();
        assert!(spoken.iter().all(|record| record.direction == board::Direction::In), "{spoken:?}");
    }

    #[test]
    fn a_nominal_command_that_waited_too_long_is_overdue_and_a_goal_never_is() {
        let command = NominalCommand { received_ns: 100, ..NominalCommand::zeroed() };
        let command = BridgeEvent::NominalCommand(command);
        assert!(!is_overdue(&command, 90, 80) && !is_overdue(&command, 180, 80));
        assert!(is_overdue(&command, 181, 80));
        assert!(!is_overdue(&BridgeEvent::Goal(Goal::zeroed()), 1_000, 80));
    }
}
