//! Where the robot shall go.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::{Message, Stamp, layout::assert_layout};

/// Target pose, or the next point of a path. Bridge → nominal controller. Holds until replaced.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("cncbf/Goal/v1")]
pub struct Goal {
    /// Identity and times.
    pub stamp: Stamp,
    /// Target position in `odom`, `[x, y]`, m.
    pub position_in_odom_m: [f64; 2],
    /// Target heading in `odom`, rad in [-π, π).
    pub heading_rad: f64,
}

assert_layout!(Goal, 64, { stamp: 0, position_in_odom_m: 40, heading_rad: 56 });

impl Message for Goal {
    const SERVICE: &'static str = "goal";
    const TYPE_NAME: &'static str = "cncbf/Goal/v1";
}

impl Goal {
    /// Whether every physical quantity is finite.
    pub fn is_finite(&self) -> bool {
        self.position_in_odom_m.iter().all(|value| value.is_finite()) && self.heading_rad.is_finite()
    }
}
