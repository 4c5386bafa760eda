//! What `cncbf doctor` saw of the ROS 2 graph, as text and as JSON.
//!
//! None of it makes a machine unsound: a stack may run on recordings alone.

use std::fmt::Write as _;
use std::time::Duration;

use perception_bridge::{GraphSurvey, RosError, SurveyedTopic, survey};
use serde_json::{Value, json};
use settings::Settings;

/// How long the graph is listened to: peers are found within a second, rarely two.
const LISTENING: Duration = Duration::from_secs(2);
/// Odometry is refused from here on, ms.
const MOST_AHEAD_MS: f64 = 100.0;
const MOST_BEHIND_MS: f64 = 500.0;

/// What was seen, or why nothing could be.
pub(crate) struct GraphView(Result<GraphSurvey, RosError>);

impl GraphView {
    /// Listens to the graph that the environment names.
    pub(crate) fn of(settings: &Settings) -> Self {
        Self(survey(settings, LISTENING))
    }

    /// For a person.
    pub(crate) fn write(&self, text: &mut String) -> std::fmt::Result {
        writeln!(text, "\nThe ROS 2 graph, listened to for {} s", LISTENING.as_secs())?;
        let graph = match &self.0 {
            Ok(graph) => graph,
            Err(error) => return writeln!(text, "  cannot be joined: {error}"),
        };
        let reach = if graph.localhost_only { "this machine only" } else { "this machine and the subnet" };
        writeln!(
            text,
            "  spoken     {} by DDS itself (no RMW and no ROS 2 installation); domain {}, {reach}",
            graph.distribution, graph.domain_id
        )?;
        if graph.participants == 0 {
            writeln!(text, "  peers      none")?;
            return writeln!(
                text,
                "           -> where the robot runs: same ROS_DOMAIN_ID, ROS_LOCALHOST_ONLY, network and firewall (UDP)?"
            );
        }
        let nodes = if graph.nodes.is_empty() { "none named".to_owned() } else { graph.nodes.join(" ") };
        writeln!(text, "  peers      {} participants; nodes: {nodes}", graph.participants)?;
        for topic in &graph.topics {
            writeln!(text, "  {}", line(topic))?;
        }
        let clock = if graph.has_clock { "/clock is published" } else { "nobody publishes /clock" };
        match graph.odometry_ahead_ms {
            Some(ahead_ms) => {
                writeln!(text, "  clocks     odometry is stamped {ahead_ms:+.1} ms from the date; {clock}")?;
                if !(-MOST_BEHIND_MS..=MOST_AHEAD_MS).contains(&ahead_ms) {
                    writeln!(
                        text,
                        "           -> such stamps are refused or stale: set the date by NTP or PTP, or use source.ros2.use_sim_time"
                    )?;
                }
                Ok(())
            }
            None => writeln!(text, "  clocks     no stamped odometry was heard; {clock}"),
        }
    }

    /// For a program.
    pub(crate) fn to_json(&self) -> Value {
        match &self.0 {
            Err(error) => json!({ "error": error.to_string() }),
            Ok(graph) => json!({
                "distribution": graph.distribution,
                "domain_id": graph.domain_id,
                "localhost_only": graph.localhost_only,
                "participants": graph.participants,
                "nodes": graph.nodes,
                "topics": graph.topics.iter().map(topic_json).collect::<Vec<_>>(),
                "odometry_ahead_ms": graph.odometry_ahead_ms,
                "has_clock": graph.has_clock,
            }),
        }
    }
}

fn line(topic: &SurveyedTopic) -> String {
    let (direction, others) =
        if topic.is_input { ("input ", "publishers") } else { ("output", "subscribers") };
    let mut line = format!(
        "{direction}     {} {} ({}): {} {others}",
        topic.topic, topic.expected, topic.quality, topic.matched
    );
    for other in &topic.wrong_types {
        // Writing to a string cannot fail.
        let _ = write!(line, "; somebody speaks {other} there");
    }
    for misfit in &topic.misfits {
        let _ = write!(line, "; does not fit: {misfit}");
    }
    if topic.speakers > 0 {
        let _ = write!(
            line,
            "; {} already publish there: a running stack, or somebody past the filter",
            topic.speakers
        );
    }
    line
}

fn topic_json(topic: &SurveyedTopic) -> Value {
    json!({
        "topic": topic.topic,
        "direction": if topic.is_input { "input" } else { "output" },
        "type": topic.expected,
        "quality": topic.quality,
        "matched": topic.matched,
        "wrong_types": topic.wrong_types,
        "misfits": topic.misfits,
        "speakers": topic.speakers,
    })
}
