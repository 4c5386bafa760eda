//! Where the robot is and how it moves.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::{Message, Stamp, layout::assert_layout};

/// Pose of `base` in `odom` and the body's velocity. Bridge → everyone.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("cncbf/RobotState/v1")]
pub struct RobotState {
    /// Identity and times; `valid_at_ns` is when the pose held.
    pub stamp: Stamp,
    /// Origin of `base` in `odom`, `[x, y]`, m.
    pub position_in_odom_m: [f64; 2],
    /// Angle from the x axis of `odom` to the x axis of `base`, rad in [-π, π).
    pub heading_rad: f64,
    /// Velocity of `base` expressed in `base`, `[forward, left]`, m/s.
    pub velocity_in_base_mps: [f64; 2],
    /// Rate of `heading_rad`, rad/s, positive to the left.
    pub yaw_rate_radps: f64,
}

assert_layout!(RobotState, 88, {
    stamp: 0, position_in_odom_m: 40, heading_rad: 56, velocity_in_base_mps: 64, yaw_rate_radps: 80,
});

impl Message for RobotState {
    const SERVICE: &'static str = "robot_state";
    const TYPE_NAME: &'static str = "cncbf/RobotState/v1";
}

impl RobotState {
    /// Velocity of `base` expressed in `odom`, `[x, y]`, m/s.
    pub fn velocity_in_odom_mps(&self) -> [f64; 2] {
        let (sin, cos) = self.heading_rad.sin_cos();
        let [forward, left] = self.velocity_in_base_mps;
        [cos * forward - sin * left, sin * forward + cos * left]
    }

    /// Whether every physical quantity is finite.
    pub fn is_finite(&self) -> bool {
        self.position_in_odom_m.iter().chain(&self.velocity_in_base_mps).all(|value| value.is_finite())
            && self.heading_rad.is_finite()
            && self.yaw_rate_radps.is_finite()
    }
}
