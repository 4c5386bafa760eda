//! People and things around the robot: as perceived ([`Detections`]) and as estimated ([`Obstacles`]).

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::{MAX_OBSTACLES, Message, Stamp, layout::assert_layout};

/// One perceived obstacle: a disc in `odom`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("cncbf/Detection/v1")]
pub struct Detection {
    /// Identity given by perception; 0 where it gives none.
    pub track_id: u64,
    /// Centre in `odom`, `[x, y]`, m.
    pub position_in_odom_m: [f64; 2],
    /// Velocity of the centre in `odom`, `[x, y]`, m/s. Meaningful only with [`crate::DetectionFlags::HAS_VELOCITY`].
    pub velocity_in_odom_mps: [f64; 2],
    /// Covariance of the position `[xx, xy, yy]`, m². Meaningful only with [`crate::DetectionFlags::HAS_COVARIANCE`].
    pub position_covariance_m2: [f64; 3],
    /// Radius without the robot's own, m.
    pub radius_m: f64,
    /// An [`crate::ObstacleClass`] code.
    pub class: u32,
    /// [`crate::DetectionFlags`] bits.
    pub flags: u32,
}

assert_layout!(Detection, 80, {
    track_id: 0, position_in_odom_m: 8, velocity_in_odom_mps: 24, position_covariance_m2: 40, radius_m: 64, class: 72,
    flags: 76,
});

/// One frame of perception. Bridge → estimator. An empty frame says "nobody seen" and is not the same as silence.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("cncbf/Detections/v1")]
pub struct Detections {
    /// Identity and times; `valid_at_ns` is when the positions held.
    pub stamp: Stamp,
    /// How many of `items` are set.
    pub count: u32,
    /// How many were perceived beyond [`MAX_OBSTACLES`] and left out, the farthest ones.
    pub left_out: u32,
    /// The detections; entries from `count` on are zero.
    pub items: [Detection; MAX_OBSTACLES],
}

assert_layout!(Detections, 48 + 80 * MAX_OBSTACLES, { stamp: 0, count: 40, left_out: 44, items: 48 });

impl Message for Detections {
    const SERVICE: &'static str = "detections";
    const TYPE_NAME: &'static str = "cncbf/Detections/v1";
}

impl Detections {
    /// The entries that are set. A count beyond the capacity, which only a foreign sender can cause, is cut.
    pub fn as_slice(&self) -> &[Detection] {
        &self.items[..(self.count as usize).min(MAX_OBSTACLES)]
    }
}

/// One tracked obstacle: a disc, its motion, and the rate at which that motion changes.
///
/// Vectors are expressed in `odom`; none is relative to the robot. Both obstacle models of the paper are served: the
/// unicycle o = `[x, y, heading, speed]` and the double integrator o = `[x, y, vx, vy]`, each with its derivative ȯ.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("cncbf/Obstacle/v1")]
pub struct Obstacle {
    /// Identity kept while the track lives, never 0.
    pub track_id: u64,
    /// Stack clock time of the newest measurement behind this estimate, ns. Not the send time.
    pub measured_at_ns: u64,
    /// Stack clock time the estimate holds for, ns; later than `measured_at_ns` while the track coasts.
    pub valid_at_ns: u64,
    /// Centre `[x, y]`, m.
    pub position_in_odom_m: [f64; 2],
    /// Velocity of the centre `[x, y]`, m/s.
    pub velocity_in_odom_mps: [f64; 2],
    /// Acceleration of the centre `[x, y]`, m/s².
    pub acceleration_in_odom_mps2: [f64; 2],
    /// Direction of motion, rad in [-π, π); kept from the last clear motion while the obstacle stands.
    pub heading_rad: f64,
    /// Rate of `heading_rad`, rad/s.
    pub heading_rate_radps: f64,
    /// Speed along the heading, m/s, ≥ 0.
    pub speed_mps: f64,
    /// Rate of `speed_mps`, m/s².
    pub speed_rate_mps2: f64,
    /// Radius **without** the robot's own, m. Finite and > 0.
    pub radius_m: f64,
    /// An [`crate::ObstacleClass`] code.
    pub class: u32,
    /// An [`crate::ObstacleQuality`] code.
    pub quality: u32,
}

assert_layout!(Obstacle, 120, {
    track_id: 0, measured_at_ns: 8, valid_at_ns: 16, position_in_odom_m: 24, velocity_in_odom_mps: 40,
    acceleration_in_odom_mps2: 56, heading_rad: 72, heading_rate_radps: 80, speed_mps: 88, speed_rate_mps2: 96,
    radius_m: 104, class: 112, quality: 116,
});

impl Obstacle {
    /// Whether every physical quantity is finite and the radius positive.
    pub fn is_sound(&self) -> bool {
        let vectors = [self.position_in_odom_m, self.velocity_in_odom_mps, self.acceleration_in_odom_mps2];
        let scalars =
            [self.heading_rad, self.heading_rate_radps, self.speed_mps, self.speed_rate_mps2, self.radius_m];
        vectors.as_flattened().iter().chain(&scalars).all(|value| value.is_finite()) && self.radius_m > 0.0
    }
}

/// Everything the estimator believes is around the robot. Estimator → filter and planners.
///
/// Published on every [`Detections`] frame and, as a sign of life, on the estimator's heartbeat in between; the stamp
/// then still tells when perception last spoke.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("cncbf/Obstacles/v1")]
pub struct Obstacles {
    /// Own sequence and publication time; source, validity and ingress are those of the newest accepted frame.
    pub stamp: Stamp,
    /// When the bridge published that frame, stack clock, ns.
    pub bridge_published_ns: u64,
    /// When the estimator took it, stack clock, ns.
    pub received_ns: u64,
    /// How many of `items` are set.
    pub count: u32,
    /// How many obstacles were left out on the way for want of room.
    pub left_out: u32,
    /// The obstacles; entries from `count` on are zero.
    pub items: [Obstacle; MAX_OBSTACLES],
}

assert_layout!(Obstacles, 64 + 120 * MAX_OBSTACLES, {
    stamp: 0, bridge_published_ns: 40, received_ns: 48, count: 56, left_out: 60, items: 64,
});

impl Message for Obstacles {
    const SERVICE: &'static str = "obstacles";
    const TYPE_NAME: &'static str = "cncbf/Obstacles/v1";
}

impl Obstacles {
    /// The entries that are set. A count beyond the capacity, which only a foreign sender can cause, is cut.
    pub fn as_slice(&self) -> &[Obstacle] {
        &self.items[..(self.count as usize).min(MAX_OBSTACLES)]
    }
}
