//! One node in a ROS 2 graph: joins a DDS domain, opens topics with the profiles that ROS 2 has for them.

use std::net::Ipv4Addr;
use std::sync::Arc;

use recording::ros2::Ros2Message;
use ros2_client::dds::rustdds::{DomainParticipant, DomainParticipantBuilder, QosPolicies};
use ros2_client::dds::{Context, Node, Subscription};
use ros2_client::entities_info::ParticipantEntitiesInfo;
use ros2_client::qos::{Durability, History, QosProfile, Reliability as Delivery, WhenFull};
use ros2_client::{MessageTypeName, NodeName, NodeOptions};
use settings::{Reliability, Ros2Settings};

use super::board::{Direction, TopicRecord};
use super::environment::Environment;
use super::error::RosError;
use super::outlet::Outlet;

/// Messages that a subscription keeps until they are looked at.
const DEPTH: usize = 10;
/// The same of topics whose old messages count.
const LATCHED_DEPTH: usize = 100;

/// Where participants say which nodes they are.
const NODES_TOPIC: &str = "ros_discovery_info";

/// How a topic is heard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Profile {
    /// A stream, as the settings say.
    Stream(Reliability),
    /// Reliable, and what was said before counts: `/tf_static`.
    Latched,
}

/// The stack's node.
pub(super) struct Graph {
    node: Node,
    context: Context,
    records: Vec<Arc<TopicRecord>>,
}

impl Graph {
    /// Joins the domain as the node of the settings.
    pub(super) fn join(ros2: &Ros2Settings, environment: Environment) -> Result<Self, RosError> {
        let Environment { domain_id, localhost_only } = environment;
        let failed = |cause: String| RosError::Join { domain_id, cause };
        let builder = DomainParticipantBuilder::new(domain_id);
        let builder =
            if localhost_only { builder.with_only_networks([Ipv4Addr::LOCALHOST]) } else { builder };
        let participant = builder.build().map_err(|error| failed(error.to_string()))?;
        let context =
            Context::from_domain_participant(participant).map_err(|error| failed(error.to_string()))?;
        let name =
            NodeName::new(&ros2.namespace, &ros2.node_name).map_err(|error| failed(error.to_string()))?;
        let node = context
            .new_node(name, NodeOptions::new().enable_rosout(false))
            .map_err(|error| failed(error.to_string()))?;
        Ok(Self { node, context, records: Vec::new() })
    }

    /// Begins to hear `topic`, a full name. What is heard there shall be noted in the record.
    pub(super) fn subscribe<M: Ros2Message + 'static>(
        &mut self,
        topic: &str,
        profile: Profile,
    ) -> Result<(Subscription<M>, Arc<TopicRecord>), RosError> {
        let base =
            QosProfile { history: History::KeepLast { depth: DEPTH }, ..QosProfile::subscription_default() };
        let profile = match profile {
            Profile::Stream(Reliability::BestEffort) => base.reliability_best_effort(),
            Profile::Stream(Reliability::Reliable) => base.reliability_reliable(WhenFull::Fail),
            Profile::Latched => base
                .reliability_reliable(WhenFull::Fail)
                .durability(Durability::TransientLocal)
                .history(History::KeepLast { depth: LATCHED_DEPTH }),
        };
        let failed = |cause: String| RosError::Topic { topic: topic.to_owned(), cause };
        let dds_topic = self
            .context
            .create_topic(format!("rt{topic}"), type_name::<M>(), &profile)
            .map_err(|error| failed(error.to_string()))?;
        let record = self.record::<M>(topic, Direction::In, &profile);
        let port = self.node.create_subscription(&dds_topic, Some(profile));
        Ok((port.map_err(|error| failed(error.to_string()))?, record))
    }

    /// How every topic is published.
    pub(super) fn publishing() -> QosProfile {
        QosProfile { history: History::KeepLast { depth: 1 }, ..QosProfile::publisher_default() }
            .reliability(Delivery::Reliable { when_full: WhenFull::Fail })
    }

    /// Begins to hear which nodes others say they are.
    pub(super) fn subscribe_to_nodes(&mut self) -> Result<Subscription<ParticipantEntitiesInfo>, RosError> {
        let failed = |cause: String| RosError::Topic { topic: NODES_TOPIC.to_owned(), cause };
        let profile = QosProfile::subscription_default()
            .reliability_reliable(WhenFull::Fail)
            .durability(Durability::TransientLocal)
            .history(History::KeepLast { depth: LATCHED_DEPTH });
        let kind = MessageTypeName::new("rmw_dds_common", "ParticipantEntitiesInfo");
        let topic = self
            .context
            .create_topic(NODES_TOPIC.to_owned(), kind, &profile)
            .map_err(|error| failed(error.to_string()))?;
        self.node.create_subscription(&topic, Some(profile)).map_err(|error| failed(error.to_string()))
    }

    /// Becomes able to speak on `topic`, a full name. Reliable, since drivers ask for that; a publication never waits.
    pub(super) fn publish<M: Ros2Message>(&mut self, topic: &str) -> Result<Outlet<M>, RosError> {
        let profile = Self::publishing();
        let failed = |cause: String| RosError::Topic { topic: topic.to_owned(), cause };
        let dds_topic = self
            .context
            .create_topic(format!("rt{topic}"), type_name::<M>(), &profile)
            .map_err(|error| failed(error.to_string()))?;
        let record = self.record::<M>(topic, Direction::Out, &profile);
        let port = self.node.create_publisher(&dds_topic, Some(profile));
        Ok(Outlet::new(port.map_err(|error| failed(error.to_string()))?, record))
    }

    fn record<M: Ros2Message>(
        &mut self,
        topic: &str,
        direction: Direction,
        profile: &QosProfile,
    ) -> Arc<TopicRecord> {
        let record = Arc::new(TopicRecord::new(topic, M::NAME, direction, QosPolicies::from(profile)));
        self.records.push(Arc::clone(&record));
        record
    }

    /// Every topic opened so far.
    pub(super) fn records(&self) -> Vec<Arc<TopicRecord>> {
        self.records.clone()
    }

    /// What DDS knows of others.
    pub(super) fn participant(&self) -> DomainParticipant {
        self.context.domain_participant()
    }
}

/// A type as DDS knows it.
fn type_name<M: Ros2Message>() -> MessageTypeName {
    let (package, name) = M::NAME.split_once('/').unwrap_or(("", M::NAME));
    MessageTypeName::new(package, name)
}
