//! When something was observed and when the stack passed it on.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::layout::assert_layout;

/// Identity and times of one message.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[type_name("cncbf/Stamp/v1")]
pub struct Stamp {
    /// Counts the messages of one publisher on one service, from 1. A gap is a lost message, a fall is a restart.
    pub sequence: u64,
    /// Time of measurement on the sensor's clock, ns. For the log only: never compare it with the other stamps.
    pub source_ns: u64,
    /// The same instant on the stack clock, ns: the time the content holds for. Physics uses this one.
    pub valid_at_ns: u64,
    /// When the bridge first saw the measurement, stack clock, ns.
    pub ingress_ns: u64,
    /// When the sender handed this message over, stack clock, ns.
    pub published_ns: u64,
}

assert_layout!(Stamp, 40, { sequence: 0, source_ns: 8, valid_at_ns: 16, ingress_ns: 24, published_ns: 32 });

impl Stamp {
    /// Age of the content at `now_ns`, ns; zero if it claims to come from the future.
    pub const fn age_ns(&self, now_ns: u64) -> u64 {
        now_ns.saturating_sub(self.valid_at_ns)
    }
}
