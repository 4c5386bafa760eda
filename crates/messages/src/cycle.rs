//! One cycle of one process, for the record.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::{Message, layout::assert_layout};

/// When a process' cycle ran and what the kernel did to its thread meanwhile. Every process → recorder, once its outputs are
/// handed over; nothing on the path from sensor to command waits for it.
///
/// Faults, switches and processor time count since the end of the previous cycle, so that nothing lies between two cycles
/// uncounted; one voluntary switch is the sleep before this cycle.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[type_name("cncbf/Cycle/v1")]
pub struct Cycle {
    /// Counts the cycles of one process, from 1. A gap is a lost record, a fall is a restart.
    pub sequence: u64,
    /// When the cycle was due, stack clock, ns; 0 where an input began it.
    pub due_ns: u64,
    /// When it began, stack clock, ns.
    pub woke_ns: u64,
    /// When its outputs had been handed over, stack clock, ns.
    pub done_ns: u64,
    /// Processor time of its thread, ns.
    pub cpu_ns: u64,
    /// A [`crate::ProcessId`] code.
    pub process: u32,
    /// The processor it ended on.
    pub processor: u32,
    /// A [`crate::Trigger`] code: what began it.
    pub trigger: u32,
    /// Due times before `due_ns` that passed without a cycle.
    pub skipped: u32,
    /// Page faults that needed no disk.
    pub minor_faults: u32,
    /// Page faults that waited for the disk.
    pub major_faults: u32,
    /// How often the thread gave up its processor.
    pub voluntary_switches: u32,
    /// How often the thread was pushed off its processor.
    pub involuntary_switches: u32,
}

assert_layout!(Cycle, 72, {
    sequence: 0, due_ns: 8, woke_ns: 16, done_ns: 24, cpu_ns: 32, process: 40, processor: 44, trigger: 48, skipped: 52,
    minor_faults: 56, major_faults: 60, voluntary_switches: 64, involuntary_switches: 68,
});

impl Message for Cycle {
    const SERVICE: &'static str = "cycles";
    const TYPE_NAME: &'static str = "cncbf/Cycle/v1";
}
