//! What is known of each topic, in and out: who uses it writes, who tells about it reads, and nobody waits.
//!
//! Not here: what DDS knows of others on the topic (`watch`).

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};

use messages::Reason;
use ros2_client::dds::rustdds::QosPolicies;

use crate::command_sink::SinkState;

/// Which way messages go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Direction {
    /// Heard by this node.
    In,
    /// Published by this node.
    Out,
}

/// One topic of this node.
#[derive(Debug)]
pub(super) struct TopicRecord {
    /// Full name.
    pub(super) topic: String,
    /// Its type here, for example `nav_msgs/Odometry`.
    pub(super) expected: &'static str,
    /// Which way.
    pub(super) direction: Direction,
    /// Quality of service asked for or offered.
    pub(super) quality: QosPolicies,
    messages: AtomicU64,
    last_ns: AtomicU64,
    is_silent: AtomicBool,
    refused: [AtomicU64; Reason::ALL.len()],
}

impl TopicRecord {
    /// A topic that has seen nothing yet.
    pub(super) fn new(
        topic: &str,
        expected: &'static str,
        direction: Direction,
        quality: QosPolicies,
    ) -> Self {
        Self {
            topic: topic.to_owned(),
            expected,
            direction,
            quality,
            messages: AtomicU64::new(0),
            last_ns: AtomicU64::new(0),
            is_silent: AtomicBool::new(false),
            refused: [const { AtomicU64::new(0) }; Reason::ALL.len()],
        }
    }

    /// A message passed at `now_ns`, stack clock.
    pub(super) fn passed(&self, now_ns: u64) {
        self.messages.fetch_add(1, Ordering::Relaxed);
        self.last_ns.store(now_ns, Ordering::Relaxed);
    }

    /// A message was refused, or did not leave.
    pub(super) fn refused(&self, reason: Reason) {
        if let Some(index) = Reason::ALL.iter().position(|other| *other == reason) {
            self.refused[index].fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Whether it should speak and does not.
    pub(super) fn set_silent(&self, is_silent: bool) {
        self.is_silent.store(is_silent, Ordering::Relaxed);
    }

    /// Whether it should speak and does not.
    pub(super) fn is_silent(&self) -> bool {
        self.is_silent.load(Ordering::Relaxed)
    }

    /// Messages so far, refused ones included.
    pub(super) fn messages(&self) -> u64 {
        self.messages.load(Ordering::Relaxed)
    }

    /// Time since the last message, ns; `None` where none has come.
    pub(super) fn age_ns(&self, now_ns: u64) -> Option<u64> {
        let last_ns = self.last_ns.load(Ordering::Relaxed);
        (last_ns > 0).then(|| now_ns.saturating_sub(last_ns))
    }

    /// How many were refused, by reason; reasons without any are left out.
    pub(super) fn refusals(&self) -> impl Iterator<Item = (Reason, u64)> + '_ {
        let counts = self.refused.iter().map(|count| count.load(Ordering::Relaxed));
        Reason::ALL.iter().copied().zip(counts).filter(|(_, count)| *count > 0)
    }
}

/// What the command sink does, posted by the bridge's loop.
#[derive(Debug)]
pub(super) struct SinkBoard(AtomicU32);

/// Codes beside those of [`Reason`], which say why it brakes.
const WAITING: u32 = u32::MAX;
const FOLLOWING: u32 = u32::MAX - 1;

impl SinkBoard {
    /// Nothing has come yet.
    pub(super) const fn new() -> Self {
        Self(AtomicU32::new(WAITING))
    }

    /// Says what it does now. Neither blocks nor allocates.
    pub(super) fn post(&self, state: SinkState) {
        let code = match state {
            SinkState::Waiting => WAITING,
            SinkState::Following => FOLLOWING,
            SinkState::Braking(reason) => reason.code(),
        };
        self.0.store(code, Ordering::Relaxed);
    }

    /// What it did last.
    pub(super) fn read(&self) -> SinkState {
        match self.0.load(Ordering::Relaxed) {
            WAITING => SinkState::Waiting,
            FOLLOWING => SinkState::Following,
            code => SinkState::Braking(Reason::try_from(code).unwrap_or(Reason::MalformedInput)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_tells_what_passed_and_why_the_rest_did_not() {
        let record = TopicRecord::new("/odom", "nav_msgs/Odometry", Direction::In, QosPolicies::default());
        assert_eq!((record.messages(), record.age_ns(5), record.is_silent()), (0, None, false));
        record.passed(3);
        record.refused(Reason::FutureStamp);
        record.refused(Reason::FutureStamp);
        record.set_silent(true);
        assert_eq!((record.messages(), record.age_ns(5), record.is_silent()), (1, Some(2), true));
        assert_eq!(record.refusals().collect::<Vec<_>>(), [(Reason::FutureStamp, 2)]);
    }

    #[test]
    fn the_sink_is_read_as_it_was_posted() {
        let board = SinkBoard::new();
        assert_eq!(board.read(), SinkState::Waiting);
        for state in [SinkState::Following, SinkState::Braking(Reason::SilentFilter), SinkState::Waiting] {
            board.post(state);
            assert_eq!(board.read(), state);
        }
    }
}
