//! What DDS knows of others on this node's topics: who is matched, and who speaks or expects something else.
//!
//! DDS itself is silent about the commonest faults of a graph: another type under the same name, or a quality of service that
//! does not fit. Both are found here by comparing what others announce with what this node opened.

use std::fmt;
use std::sync::Arc;

use ros2_client::dds::rustdds::policy::{Durability, Reliability};
use ros2_client::dds::rustdds::{DomainParticipant, GUID, QosPolicies, RTPSEntity};

use super::board::{Direction, TopicRecord};

/// What others announce on one topic.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Others {
    /// Those that this node talks with.
    pub(super) matched: usize,
    /// Types of those that speak or expect another one, each once, as `package/Type`.
    pub(super) wrong_types: Vec<String>,
    /// What does not fit about the quality of service of the rest, each once.
    pub(super) misfits: Vec<String>,
    /// Those that speak where this node does.
    pub(super) rivals: usize,
}

impl Others {
    /// Whether somebody there does not fit.
    pub(super) fn is_faulty(&self) -> bool {
        !self.wrong_types.is_empty() || !self.misfits.is_empty()
    }
}

/// One topic with what is known of both ends.
#[derive(Debug)]
pub(super) struct Watched {
    /// This node's end.
    pub(super) record: Arc<TopicRecord>,
    /// The others'.
    pub(super) others: Others,
}

/// Somebody else's end of a topic, as announced.
struct Announced {
    guid: GUID,
    topic: String,
    type_name: String,
    quality: QosPolicies,
}

/// Looks at the graph when told to.
pub(super) struct Watch {
    participant: DomainParticipant,
    topics: Vec<Watched>,
    /// The topic on which nobody else may speak.
    command_topic: String,
}

impl Watch {
    /// Watches the topics of `records`. `command_topic` drives the robot.
    pub(super) fn new(
        participant: DomainParticipant,
        records: Vec<Arc<TopicRecord>>,
        command_topic: String,
    ) -> Self {
        let topics =
            records.into_iter().map(|record| Watched { record, others: Others::default() }).collect();
        Self { participant, topics, command_topic }
    }

    /// Every topic, as last looked at.
    pub(super) fn topics(&self) -> &[Watched] {
        &self.topics
    }

    /// Looks again, and tells the log what has changed.
    pub(super) fn look(&mut self) {
        let own = self.participant.guid().prefix;
        let writers: Vec<_> = self
            .participant
            .discovered_writers()
            .into_iter()
            .map(|writer| Announced {
                guid: writer.publication_topic_data.key,
                quality: writer.publication_topic_data.qos(),
                topic: writer.publication_topic_data.topic_name,
                type_name: writer.publication_topic_data.type_name,
            })
            .filter(|writer| writer.guid.prefix != own)
            .collect();
        let readers: Vec<_> = self
            .participant
            .discovered_readers()
            .into_iter()
            .map(|reader| reader.subscription_topic_data)
            .map(|reader| Announced {
                guid: reader.key(),
                quality: reader.qos(),
                topic: reader.topic_name().clone(),
                type_name: reader.type_name().clone(),
            })
            .filter(|reader| reader.guid.prefix != own)
            .collect();
        for Watched { record, others } in &mut self.topics {
            let seen = match record.direction {
                Direction::In => compare(record, &writers),
                Direction::Out => {
                    Others { rivals: on_topic(record, &writers).count(), ..compare(record, &readers) }
                }
            };
            tell(record, others, &seen);
            if record.topic == self.command_topic {
                tell_rivals(record, others.rivals, seen.rivals);
            }
            *others = seen;
        }
    }
}

/// Those of `announced` that are about the topic of `record`.
fn on_topic<'a>(record: &TopicRecord, announced: &'a [Announced]) -> impl Iterator<Item = &'a Announced> {
    announced.iter().filter(|other| other.topic.strip_prefix("rt") == Some(&record.topic))
}

/// What `announced` means for the topic of `record`.
fn compare(record: &TopicRecord, announced: &[Announced]) -> Others {
    let mut others = Others::default();
    for other in on_topic(record, announced) {
        let type_name = plain_type(&other.type_name);
        let (offered, requested) = match record.direction {
            Direction::In => (&other.quality, &record.quality),
            Direction::Out => (&record.quality, &other.quality),
        };
        if type_name != record.expected {
            add(&mut others.wrong_types, type_name);
        } else if let Some(policy) = offered.compliance_failure_wrt(requested) {
            add(&mut others.misfits, misfit(&policy, offered, requested));
        } else {
            others.matched += 1;
        }
    }
    others
}

fn add(list: &mut Vec<String>, item: String) {
    if !list.contains(&item) {
        list.push(item);
    }
}

/// `nav_msgs::msg::dds_::Odometry_` is `nav_msgs/Odometry`. A name of another form is left as it is.
pub(super) fn plain_type(dds_name: &str) -> String {
    let parts = dds_name.split_once("::msg::dds_::");
    match parts.and_then(|(package, name)| Some((package, name.strip_suffix('_')?))) {
        Some((package, name)) => format!("{package}/{name}"),
        None => dds_name.to_owned(),
    }
}

/// The policy that does not fit, with both sides where they are customary ones.
fn misfit(policy: &impl fmt::Debug, offered: &QosPolicies, requested: &QosPolicies) -> String {
    let policy = format!("{policy:?}").to_lowercase();
    match policy.as_str() {
        "reliability" => format!(
            "reliability {} offered, {} asked for",
            reliability(offered.reliability().as_ref()),
            reliability(requested.reliability().as_ref())
        ),
        "durability" => format!(
            "durability {} offered, {} asked for",
            durability(offered.durability()),
            durability(requested.durability())
        ),
        "representation" => "data representation: XCDR1 is what ROS 2 speaks".to_owned(),
        _ => policy,
    }
}

/// What ROS 2 calls it.
pub(super) fn reliability(policy: Option<&Reliability>) -> &'static str {
    match policy {
        Some(Reliability::BestEffort) => "best_effort",
        Some(Reliability::Reliable { .. }) => "reliable",
        None => "of its own default",
    }
}

/// What ROS 2 calls it.
pub(super) fn durability(policy: Option<Durability>) -> &'static str {
    match policy {
        Some(Durability::Volatile) | None => "volatile",
        Some(Durability::TransientLocal) => "transient_local",
        Some(Durability::Transient) => "transient",
        Some(Durability::Persistent) => "persistent",
    }
}

/// Tells the log which faults are new, and when the last one is gone.
fn tell(record: &TopicRecord, before: &Others, now: &Others) {
    let (topic, expected) = (&record.topic, record.expected);
    for other in now.wrong_types.iter().filter(|other| !before.wrong_types.contains(other)) {
        match record.direction {
            Direction::In => tracing::warn!(
                topic,
                expected,
                published = other,
                "a publisher speaks another type; it is not heard"
            ),
            Direction::Out => tracing::warn!(
                topic,
                published = expected,
                expected = other,
                "a subscriber expects another type; it hears nothing"
            ),
        }
    }
    for misfit in now.misfits.iter().filter(|misfit| !before.misfits.contains(misfit)) {
        match record.direction {
            Direction::In => tracing::warn!(
                topic,
                misfit,
                "a publisher's quality of service does not fit; it is not heard (source.ros2.reliability)"
            ),
            Direction::Out => tracing::warn!(
                topic,
                misfit,
                "a subscriber's quality of service does not fit; it hears nothing"
            ),
        }
    }
    if before.is_faulty() && !now.is_faulty() {
        tracing::info!(topic, "types and qualities of service fit again");
    }
}

/// Tells the log of those who command the robot beside this node: it obeys whoever spoke last.
fn tell_rivals(record: &TopicRecord, before: usize, now: usize) {
    let topic = &record.topic;
    if now > before {
        tracing::error!(
            topic,
            publishers = now,
            "somebody else commands the robot, too, past the filter; remap that program's topic"
        );
    } else if now == 0 && before > 0 {
        tracing::info!(topic, "nobody else commands the robot any more");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ros2_client::dds::rustdds::{Duration, QosPolicyBuilder};

    fn quality(reliable: bool) -> QosPolicies {
        let builder = QosPolicyBuilder::new();
        let builder = if reliable { builder.reliable(Duration::ZERO) } else { builder.best_effort() };
        builder.build()
    }

    fn announced(topic: &str, type_name: &str, reliable: bool) -> Announced {
        Announced {
            guid: GUID::GUID_UNKNOWN,
            topic: topic.to_owned(),
            type_name: type_name.to_owned(),
            quality: quality(reliable),
        }
    }

    #[test]
    fn another_type_and_another_quality_are_named_and_other_topics_left_alone() {
        const ODOMETRY: &str = "nav_msgs::msg::dds_::Odometry_";
        let record = TopicRecord::new("/odom", "nav_msgs/Odometry", Direction::In, quality(true));
        let others = compare(
            &record,
            &[
                announced("rt/odom", ODOMETRY, true),
                announced("rt/odom", ODOMETRY, false),
                announced("rt/odom", "std_msgs::msg::dds_::Bool_", true),
                announced("rt/odom2", "std_msgs::msg::dds_::Bool_", true),
                announced("odom", ODOMETRY, true),
            ],
        );
        assert_eq!(others.matched, 1);
        assert_eq!(others.wrong_types, ["std_msgs/Bool"]);
        assert_eq!(others.misfits, ["reliability best_effort offered, reliable asked for"]);
    }

    #[test]
    fn what_is_published_fits_who_asks_for_less() {
        let record = TopicRecord::new("/cmd_vel", "geometry_msgs/Twist", Direction::Out, quality(true));
        let twist = "geometry_msgs::msg::dds_::Twist_";
        let readers = [announced("rt/cmd_vel", twist, false), announced("rt/cmd_vel", twist, true)];
        assert_eq!(compare(&record, &readers), Others { matched: 2, ..Others::default() });
        let stamped = announced("rt/cmd_vel", "geometry_msgs::msg::dds_::TwistStamped_", true);
        assert_eq!(compare(&record, &[stamped]).wrong_types, ["geometry_msgs/TwistStamped"]);
    }

    #[test]
    fn types_of_other_worlds_keep_their_name() {
        assert_eq!(plain_type("HelloWorld"), "HelloWorld");
        assert_eq!(plain_type("tf2_msgs::msg::dds_::TFMessage_"), "tf2_msgs/TFMessage");
    }
}
