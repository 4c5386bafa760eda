//! One topic that is listened to: its messages, and what there is to say about it in the log.

use std::collections::BTreeMap;
use std::sync::Arc;

use messages::Reason;
use recording::ros2::Ros2Message;
use ros2_client::dds::Subscription;
use ros2_client::dds::rustdds::mio1::{Interest, Registry, Token, event::Source};

use super::arrival::Arrival;
use super::board::TopicRecord;
use super::error::RosError;
use super::graph::{Graph, Profile};

/// A topic that says nothing for this long is named in the log and in /diagnostics, ns.
const SILENCE_NS: u64 = 1_200_000_000;
/// Most messages taken at one look, so that one topic cannot starve the others.
const READ_LIMIT: usize = 64;

/// A subscription with its history.
pub(super) struct Input<M> {
    topic: String,
    port: Subscription<M>,
    record: Arc<TopicRecord>,
    /// When it last said something, or when listening began, stack clock, ns.
    heard_ns: u64,
    is_silent: bool,
    /// How many were refused for each reason, and how many the log knows of.
    refused: BTreeMap<Reason, (u64, u64)>,
}

impl<M: Ros2Message + 'static> Input<M> {
    /// Begins to hear `topic`; arrivals show at `registry`.
    pub(super) fn open(
        graph: &mut Graph,
        topic: String,
        profile: Profile,
        registry: &Registry,
        now_ns: u64,
    ) -> Result<Self, RosError> {
        let (mut port, record) = graph.subscribe(&topic, profile)?;
        port.register(registry, Token(0), Interest::READABLE)
            .map_err(|error| RosError::Topic { topic: topic.clone(), cause: error.to_string() })?;
        let refused = BTreeMap::new();
        Ok(Self { topic, port, record, heard_ns: now_ns, is_silent: false, refused })
    }

    /// Takes what has arrived; `take` says why it refuses a message. Returns how many were refused.
    pub(super) fn drain(&mut self, mut take: impl FnMut(&M, Arrival) -> Result<(), Reason>) -> u64 {
        let mut refused = 0;
        for _ in 0..READ_LIMIT {
            let taken = match self.port.take() {
                Ok(Some((message, _))) => take(&message, Arrival::now()),
                Ok(None) => break,
                Err(_) => Err(Reason::MalformedInput),
            };
            self.heard_ns = Arrival::now().stack_ns;
            self.record.passed(self.heard_ns);
            if let Err(reason) = taken {
                self.record.refused(reason);
                self.refused.entry(reason).or_default().0 += 1;
                refused += 1;
            }
        }
        refused
    }

    /// Tells the log what has changed: a topic that fell silent or speaks again, messages refused.
    pub(super) fn tell(&mut self, now_ns: u64) {
        let is_silent = now_ns.saturating_sub(self.heard_ns) > SILENCE_NS;
        let (topic, expected) = (&self.topic, M::NAME);
        match (self.is_silent, is_silent) {
            (false, true) => tracing::warn!(
                topic,
                expected,
                "nothing arrives; is it published, with this type and a quality of service that fits?"
            ),
            (true, false) => tracing::info!(topic, "speaks again"),
            (true, true) | (false, false) => {}
        }
        self.is_silent = is_silent;
        self.record.set_silent(is_silent);
        self.tell_refusals();
    }

    /// Tells the log what was refused: the first for each reason at once, more whenever their number has doubled, so that a
    /// publisher that is never right does not fill it.
    pub(super) fn tell_refusals(&mut self) {
        for (reason, (count, said)) in &mut self.refused {
            if *count > *said && *count >= 2 * *said {
                tracing::warn!(topic = self.topic, %reason, count, "messages refused so far");
                *said = *count;
            }
        }
    }
}
