//! How a process is doing.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::{Message, layout::assert_layout};

/// Counters of one process since it started. Every process → launcher, a few times a second.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("cncbf/Health/v2")]
pub struct Health {
    /// When this was published, stack clock, ns.
    pub published_ns: u64,
    /// Cycles run.
    pub cycles: u64,
    /// Cycles that began later than one whole period after they were due.
    pub missed_deadlines: u64,
    /// Largest lateness of a cycle's beginning, ns. Never filtered.
    pub max_lateness_ns: u64,
    /// Inputs used.
    pub accepted_inputs: u64,
    /// Inputs refused, each for a stated reason.
    pub refused_inputs: u64,
    /// A [`crate::ProcessId`] code.
    pub process: u32,
    /// Operating-system process id.
    pub pid: u32,
    /// A [`crate::Reason`] code: the last thing that went wrong; `NONE` if nothing did.
    pub last_reason: u32,
    /// How many things went wrong.
    pub errors: u32,
    /// [`crate::RealtimeFlags`] bits of what the process asked the kernel for.
    pub realtime_asked: u32,
    /// [`crate::RealtimeFlags`] bits of what the kernel granted.
    pub realtime_granted: u32,
}

assert_layout!(Health, 72, {
    published_ns: 0, cycles: 8, missed_deadlines: 16, max_lateness_ns: 24, accepted_inputs: 32, refused_inputs: 40,
    process: 48, pid: 52, last_reason: 56, errors: 60, realtime_asked: 64,
    realtime_granted: 68,
});

impl Message for Health {
    const SERVICE: &'static str = "health";
    const TYPE_NAME: &'static str = "cncbf/Health/v2";
}
