//! What the robot would do if it were alone.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::{Message, Stamp, layout::assert_layout};

/// Command of a nominal controller, which is blind to obstacles. Any nominal controller → filter.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("cncbf/NominalCommand/v1")]
pub struct NominalCommand {
    /// Own sequence and publication time; source, validity and ingress are those of the robot state it answers.
    pub stamp: Stamp,
    /// When the bridge published that robot state, stack clock, ns.
    pub bridge_published_ns: u64,
    /// When the controller took it, stack clock, ns.
    pub received_ns: u64,
    /// The control u_nom: `[speed m/s, yaw rate rad/s]` or `[ax, ay] m/s²` in `odom`, as `control_kind` says.
    pub control: [f64; 2],
    /// A [`crate::ControlKind`] code.
    pub control_kind: u32,
    /// An [`crate::Intent`] code: drive with `control`, or come to a halt whatever `control` says.
    pub intent: u32,
    /// A [`crate::Controller`] code, or any value ≥ 1,000 that an external controller chooses for itself.
    pub controller: u32,
    /// Iterations or similar effort figure of the controller, for the log.
    pub effort: u32,
}

assert_layout!(NominalCommand, 88, {
    stamp: 0, bridge_published_ns: 40, received_ns: 48, control: 56, control_kind: 72, intent: 76, controller: 80,
    effort: 84,
});

impl Message for NominalCommand {
    const SERVICE: &'static str = "nominal_command";
    const TYPE_NAME: &'static str = "cncbf/NominalCommand/v1";
}
