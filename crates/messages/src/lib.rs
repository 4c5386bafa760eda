//! Wire types and service names that the processes share.
//!
//! Every type is `#[repr(C)]`, free of padding and of pointers, and made of `u32`, `u64` and `f64` only, so that any
//! bit pattern is a valid value and any language can read it. Codes travel as `u32`; [`codes`] names them. Field order,
//! size and offsets are asserted at compile time beside each type; a change of layout is a new version in the type name.
//!
//! What is deliberately absent: logic, clocks, ports. `node_runtime` moves these types, the processes fill them.
//!
//! # Time
//! Fields ending in `_ns` are nanoseconds. Except for [`Stamp::source_ns`] (the sensor's own clock) all of them are on
//! the *stack clock*: `CLOCK_MONOTONIC` onboard, virtual time in lockstep. Zero means "never".
//!
//! # Frames
//! `odom` is the fixed, locally continuous world frame (REP-105); `base` is the robot's, x forward, y left.

pub mod codes;
mod cycle;
mod goal;
mod health;
mod layout;
mod nominal_command;
mod obstacle;
mod robot_state;
mod safe_command;
mod source_status;
mod stamp;

pub use codes::{
    ControlKind, Controller, DetectionFlags, Intent, ObstacleClass, ObstacleQuality, ProcessId,
    RealtimeFlags, Reason, SafetyStatus, SourceKind, Trigger, UnknownCode,
};
pub use cycle::Cycle;
pub use goal::Goal;
pub use health::Health;
pub use nominal_command::NominalCommand;
pub use obstacle::{Detection, Detections, Obstacle, Obstacles};
pub use robot_state::RobotState;
pub use safe_command::{Ledger, SafeCommand};
pub use source_status::SourceStatus;
pub use stamp::Stamp;

use bytemuck::Pod;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

/// Obstacles that one message can carry. The nearest are kept, the number of the others travels along.
pub const MAX_OBSTACLES: usize = 64;

/// A type that travels on a service of its own.
pub trait Message: ZeroCopySend + Pod + core::fmt::Debug + PartialEq + Send + Sync + 'static {
    /// Service name without the instance prefix, for example `robot_state` of `demo/robot_state`.
    const SERVICE: &'static str;
    /// Versioned type name, checked by iceoryx2 when a port opens and written into recordings.
    const TYPE_NAME: &'static str;
}
