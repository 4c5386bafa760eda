//! Frames and settings that the estimator's tests share.

// Each test file is a crate of its own and uses a part of this.
#![allow(dead_code)]

use bytemuck::Zeroable;
use messages::{Detection, DetectionFlags, Detections, Obstacle, Obstacles};
use obstacle_estimator::Estimator;
use settings::{
    EstimatorKind, EstimatorSettings, ImmSettings, KalmanSettings, LearnedNoiseSettings, ManoeuvreSettings,
    NoiseSettings,
};

pub(crate) const MS: u64 = 1_000_000;
/// Tests begin here: a stack clock that has run for a while.
pub(crate) const START_NS: u64 = 10_000 * MS;

pub(crate) fn settings() -> EstimatorSettings {
    EstimatorSettings {
        kind: EstimatorKind::BackwardDifference,
        heartbeat_ms: 25,
        coast_ms: 500,
        teleport_speed_mps: 8.0,
        max_difference_interval_ms: 300,
        heading_hold_speed_mps: 0.2,
        max_speed_rate_mps2: 1.0,
        max_heading_rate_radps: 0.35,
        association_gate_m: 0.75,
        noise: None,
        kalman: None,
        imm: None,
    }
}

pub(crate) const NOISE: NoiseSettings =
    NoiseSettings { position_sd_m: 0.05, initial_speed_sd_mps: 1.5, radius_sds: 0.0, learned: None };

pub(crate) fn kalman() -> EstimatorSettings {
    EstimatorSettings {
        kind: EstimatorKind::Kalman,
        noise: Some(NOISE),
        kalman: Some(KalmanSettings { acceleration_sd_mps2: 1.0 }),
        ..settings()
    }
}

pub(crate) fn imm() -> EstimatorSettings {
    EstimatorSettings {
        kind: EstimatorKind::Imm,
        noise: Some(NOISE),
        imm: Some(ImmSettings {
            calm_acceleration_sd_mps2: 0.3,
            lively_acceleration_sd_mps2: 2.0,
            mean_stay_s: 1.7,
            manoeuvre: Some(ManoeuvreSettings { acceleration_sd_mps2: 2.0, time_constant_s: 0.5 }),
        }),
        ..settings()
    }
}

pub(crate) const LEARNED: LearnedNoiseSettings =
    LearnedNoiseSettings { least_sd_m: 0.001, most_sd_m: 0.5, difference_sd_mps: 0.02 };

/// The interacting models, which learn how noisy positions are.
pub(crate) fn learning() -> EstimatorSettings {
    EstimatorSettings { noise: Some(NoiseSettings { learned: Some(LEARNED), ..NOISE }), ..imm() }
}

pub(crate) fn provided() -> EstimatorSettings {
    EstimatorSettings { kind: EstimatorKind::Provided, ..settings() }
}

/// One sighting of `id` (0: anonymous) at `position_m`, radius 0.3 m.
pub(crate) fn seen(id: u64, position_m: [f64; 2]) -> Detection {
    Detection { track_id: id, position_in_odom_m: position_m, radius_m: 0.3, class: 1, ..Detection::zeroed() }
}

/// The same with a measured velocity.
pub(crate) fn moving(id: u64, position_m: [f64; 2], velocity_mps: [f64; 2]) -> Detection {
    Detection {
        velocity_in_odom_mps: velocity_mps,
        flags: DetectionFlags::HAS_VELOCITY,
        ..seen(id, position_m)
    }
}

/// A frame measured `at_ms` after the start.
pub(crate) fn frame(at_ms: u64, detections: &[Detection]) -> Detections {
    let mut frame = Detections::zeroed();
    frame.stamp.valid_at_ns = START_NS + at_ms * MS;
    frame.stamp.source_ns = 77 + at_ms * MS;
    frame.stamp.ingress_ns = frame.stamp.valid_at_ns + MS;
    frame.stamp.published_ns = frame.stamp.valid_at_ns + 2 * MS;
    frame.count = detections.len() as u32;
    frame.items[..detections.len()].copy_from_slice(detections);
    frame
}

/// Feeds a frame that arrives 3 ms after its measurement.
pub(crate) fn feed(estimator: &mut Estimator, at_ms: u64, detections: &[Detection]) -> Obstacles {
    *estimator.step(&frame(at_ms, detections), START_NS + (at_ms + 3) * MS)
}

/// The obstacle `id`, which must be there.
pub(crate) fn of(obstacles: &Obstacles, id: u64) -> Obstacle {
    *obstacles.as_slice().iter().find(|obstacle| obstacle.track_id == id).expect("the obstacle is tracked")
}

pub(crate) fn ids(obstacles: &Obstacles) -> Vec<u64> {
    obstacles.as_slice().iter().map(|obstacle| obstacle.track_id).collect()
}

pub(crate) fn close(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-9
}
