//! How far the world outside has come: what a run or a replay is judged by.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::{Message, layout::assert_layout};

/// Progress of the bridge's source and, where the source knows the truth, the outcome so far. Bridge → launcher, recorder.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("cncbf/SourceStatus/v1")]
pub struct SourceStatus {
    /// When this was published, stack clock, ns.
    pub published_ns: u64,
    /// Time the source has run, in its own time, ns.
    pub elapsed_ns: u64,
    /// Time the source will run, ns; 0 where it has no end of its own.
    pub total_ns: u64,
    /// Sensor messages handed on.
    pub accepted: u64,
    /// Sensor messages refused, each logged with a reason.
    pub refused: u64,
    /// Smallest distance between the true discs of robot and people so far, m; `+∞` if unknown.
    pub min_clearance_m: f64,
    /// The same distance now, m; `+∞` if unknown.
    pub clearance_m: f64,
    /// Length of the robot's path so far, m.
    pub path_length_m: f64,
    /// Distance from the robot to its goal, m; `+∞` without a goal.
    pub goal_distance_m: f64,
    /// Contacts between robot and people so far; each counts once, when it begins.
    pub collisions: u32,
    /// 1 once the robot came within the goal tolerance, else 0.
    pub goal_reached: u32,
    /// 1 once the source has nothing more to give, else 0.
    pub finished: u32,
    /// A [`crate::SourceKind`] code.
    pub kind: u32,
}

assert_layout!(SourceStatus, 88, {
    published_ns: 0, elapsed_ns: 8, total_ns: 16, accepted: 24, refused: 32, min_clearance_m: 40, clearance_m: 48,
    path_length_m: 56, goal_distance_m: 64, collisions: 72, goal_reached: 76, finished: 80, kind: 84,
});

impl Message for SourceStatus {
    const SERVICE: &'static str = "source_status";
    const TYPE_NAME: &'static str = "cncbf/SourceStatus/v1";
}
