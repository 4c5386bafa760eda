//! A look at a ROS 2 graph from outside, for `cncbf doctor`: who is there, which topics fit the settings, what the clocks say.
//!
//! It hears and never commands: the topic that drives a robot is compared with who listens there, and not opened.

use std::collections::BTreeSet;
use std::io;
use std::sync::Arc;
use std::time::Duration;

use recording::ros2::{Odometry, Ros2Message, Twist, TwistStamped};
use ros2_client::COMPILED_ROS_DISTRO;
use ros2_client::dds::rustdds::mio1::Poll;
use ros2_client::dds::rustdds::{QosPolicies, RTPSEntity};
use ros2_client::entities_info::{NodeEntitiesInfo, ParticipantEntitiesInfo};
use settings::{CommandMessage, Reliability, Ros2Settings, Settings};

use super::arrival::Arrival;
use super::board::{Direction, TopicRecord};
use super::environment::Environment;
use super::error::RosError;
use super::graph::{Graph, Profile};
use super::inputs::Inputs;
use super::watch::{Watch, Watched, durability, reliability};

/// Between two looks.
const LOOK: Duration = Duration::from_millis(20);
/// Where a simulation tells its time.
const CLOCK_TOPIC: &str = "rt/clock";

/// What was seen of a graph.
#[derive(Debug, Clone, PartialEq)]
pub struct GraphSurvey {
    /// The ROS 2 that this build speaks, for example `jazzy`.
    pub distribution: &'static str,
    /// DDS domain.
    pub domain_id: u16,
    /// Whether other machines are left out.
    pub localhost_only: bool,
    /// DDS participants that have said that they are there: processes, mostly.
    pub participants: usize,
    /// Full names of the nodes that have said so.
    pub nodes: Vec<String>,
    /// The topics of the settings.
    pub topics: Vec<SurveyedTopic>,
    /// Stamp of the newest odometry minus the date at its arrival, ms; `None` where none came or it was not stamped.
    pub odometry_ahead_ms: Option<f64>,
    /// Whether somebody publishes a simulation's time on `/clock`.
    pub has_clock: bool,
}

/// A topic of the settings and who uses it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SurveyedTopic {
    /// Full name.
    pub topic: String,
    /// Whether the stack would hear it; it would publish there otherwise.
    pub is_input: bool,
    /// The type that the settings name, for example `nav_msgs/Odometry`.
    pub expected: String,
    /// Reliability and durability that are asked for or offered.
    pub quality: String,
    /// Others that the stack would talk with.
    pub matched: usize,
    /// Other types under the same name.
    pub wrong_types: Vec<String>,
    /// What does not fit about others' quality of service.
    pub misfits: Vec<String>,
    /// Of a topic that this stack speaks on: those who do so now, a running stack included.
    pub speakers: usize,
}

/// Joins the graph that the environment names for `listening` and tells what is there.
///
/// # Errors
/// [`RosError`] if the environment is unusable or DDS refuses, for example without a network.
pub fn survey(settings: &Settings, listening: Duration) -> Result<GraphSurvey, RosError> {
    let environment = Environment::read()?;
    let ros2 = settings.source.ros2.clone().unwrap_or_else(Ros2Settings::customary);
    // The stack itself may be running under its own name.
    let visitor = Ros2Settings { node_name: format!("{}_doctor", ros2.node_name), ..ros2.clone() };
    let mut graph = Graph::join(&visitor, environment)?;
    let failed = |error: io::Error| RosError::Thread { cause: error.to_string() };
    let poll = Poll::new().map_err(failed)?;
    let inputs = Inputs::open(&mut graph, &settings.source, &ros2, poll.registry())?;
    let mut records = graph.records();
    records.push(Arc::new(command_record(&ros2)));
    let odometry_topic = match settings.source.odometry_topic.as_str() {
        "" => ros2.absolute("odom"),
        set => ros2.absolute(set),
    };
    let (odometry, _) =
        graph.subscribe::<Odometry>(&odometry_topic, Profile::Stream(Reliability::BestEffort))?;
    let nodes_seen = graph.subscribe_to_nodes()?;
    let participant = graph.participant();
    let mut watch = Watch::new(participant.clone(), records, String::new());

    let mut odometry_ahead_ms = None;
    let mut nodes = BTreeSet::new();
    let give_up_ns = Arrival::now().stack_ns + listening.as_nanos() as u64;
    loop {
        while let Ok(Some((message, _))) = odometry.take() {
            odometry_ahead_ms = ahead_ms(&message, Arrival::now());
        }
        while let Ok(Some((info, _))) = nodes_seen.take() {
            note_nodes(&mut nodes, &info);
        }
        if Arrival::now().stack_ns >= give_up_ns {
            break;
        }
        std::thread::sleep(LOOK);
    }
    watch.look();
    drop(inputs);
    let own = participant.guid().prefix;
    let writers = participant.discovered_writers();
    let readers = participant.discovered_readers();
    let writer_guids = writers.iter().map(|writer| writer.publication_topic_data.key);
    let reader_guids = readers.iter().map(|reader| reader.subscription_topic_data.key());
    let peers: BTreeSet<_> =
        writer_guids.chain(reader_guids).map(|guid| guid.prefix).filter(|prefix| *prefix != own).collect();
    nodes.remove(&visitor.absolute(&visitor.node_name));
    Ok(GraphSurvey {
        distribution: distribution(),
        domain_id: environment.domain_id,
        localhost_only: environment.localhost_only,
        participants: peers.len(),
        nodes: nodes.into_iter().collect(),
        topics: watch.topics().iter().map(surveyed).collect(),
        odometry_ahead_ms,
        has_clock: writers.iter().any(|writer| writer.publication_topic_data.topic_name == CLOCK_TOPIC),
    })
}

/// The ROS 2 that this build speaks.
fn distribution() -> &'static str {
    COMPILED_ROS_DISTRO.as_str()
}

/// The topic that drives the robot, as it would be opened.
fn command_record(ros2: &Ros2Settings) -> TopicRecord {
    let kind = match ros2.command {
        CommandMessage::Twist => Twist::NAME,
        CommandMessage::TwistStamped => TwistStamped::NAME,
    };
    let quality = QosPolicies::from(Graph::publishing());
    TopicRecord::new(&ros2.absolute(&ros2.command_topic), kind, Direction::Out, quality)
}

fn surveyed(watched: &Watched) -> SurveyedTopic {
    let Watched { record, others } = watched;
    let quality = &record.quality;
    SurveyedTopic {
        topic: record.topic.clone(),
        is_input: record.direction == Direction::In,
        expected: record.expected.to_owned(),
        quality: format!(
            "{}, {}",
            reliability(quality.reliability().as_ref()),
            durability(quality.durability())
        ),
        matched: others.matched,
        wrong_types: others.wrong_types.clone(),
        misfits: others.misfits.clone(),
        speakers: others.rivals,
    }
}

/// How far a stamp lies ahead of the date, ms.
fn ahead_ms(message: &Odometry, now: Arrival) -> Option<f64> {
    let stamp_ns = message.header.stamp.to_ns()?;
    Some((stamp_ns.cast_signed() - now.wall_ns.cast_signed()) as f64 * 1e-6)
}

fn note_nodes(nodes: &mut BTreeSet<String>, info: &ParticipantEntitiesInfo) {
    nodes.extend(info.nodes().iter().map(NodeEntitiesInfo::fully_qualified_name));
}
