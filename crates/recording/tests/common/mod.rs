//! A small recording with every kind of message, the same on every run.

use std::path::{Path, PathBuf};

use bytemuck::Zeroable;
use messages::{
    ControlKind, Controller, Detection, DetectionFlags, Detections, Goal, Health, Intent, NominalCommand,
    Obstacle, ObstacleClass, ObstacleQuality, Obstacles, ProcessId, RobotState, SafeCommand, SafetyStatus,
    SourceKind, SourceStatus, Stamp,
};
use recording::{Recorder, RecordingInfo, WireMessage};

/// A fresh path for a test's file.
pub(crate) fn scratch(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

fn stamp(sequence: u64, time_ns: u64) -> Stamp {
    Stamp {
        sequence,
        source_ns: time_ns + 7,
        valid_at_ns: time_ns,
        ingress_ns: time_ns + 1_000,
        published_ns: time_ns + 2_000,
    }
}

/// Every message of the sample with its log time: three seconds, all services, an empty frame and infinities included.
pub(crate) fn sample_messages() -> Vec<(u64, WireMessage)> {
    let mut messages = Vec::new();
    for step in 0..30_u32 {
        let time_ns = 5_000_000_000 + u64::from(step) * 100_000_000;
        let at = f64::from(step) * 0.1;
        let sequence = u64::from(step) + 1;
        let log_time_ns = time_ns + 3_000;
        let state = RobotState {
            stamp: stamp(sequence, time_ns),
            position_in_odom_m: [0.5 * at - 1.5, 0.25],
            heading_rad: 0.1 * at,
            velocity_in_base_mps: [0.5, -0.01],
            yaw_rate_radps: 0.1,
        };
        let nominal = NominalCommand {
            stamp: stamp(sequence, time_ns),
            bridge_published_ns: time_ns + 2_000,
            received_ns: time_ns + 2_500,
            control: [0.75, -0.2],
            control_kind: ControlKind::Unicycle.code(),
            intent: Intent::Drive.code(),
            controller: Controller::Mpc.code(),
            effort: 3,
        };
        let detections = detections(step, time_ns);
        messages.push((log_time_ns, state.into()));
        messages.push((log_time_ns, detections.into()));
        messages.push((log_time_ns + 10, obstacles(&detections).into()));
        messages.push((log_time_ns + 20, nominal.into()));
        messages.push((log_time_ns + 30, safe_command(step, time_ns, &nominal).into()));
        if step % 10 == 0 {
            messages.extend(slow_messages(sequence, time_ns, log_time_ns + 40));
        }
    }
    messages
}

fn detections(step: u32, time_ns: u64) -> Detections {
    let mut frame = Detections { stamp: stamp(u64::from(step) + 1, time_ns), ..Detections::zeroed() };
    // Every fifth frame sees nobody.
    if step % 5 == 4 {
        return frame;
    }
    let at = f64::from(step) * 0.1;
    let base = Detection { radius_m: 0.35, class: ObstacleClass::Pedestrian.code(), ..Detection::zeroed() };
    let flags = DetectionFlags::HAS_COVARIANCE | DetectionFlags::HAS_VELOCITY;
    frame.count = 3;
    frame.items[0] = Detection { track_id: 7, position_in_odom_m: [3.0 - at, 1.0], ..base };
    frame.items[1] = Detection {
        track_id: 1 << 40,
        position_in_odom_m: [4.0, -2.0 + at],
        velocity_in_odom_mps: [0.0, 1.0],
        position_covariance_m2: [0.01, 0.002, 0.04],
        flags,
        ..base
    };
    frame.items[2] = Detection { position_in_odom_m: [-3.25, 2.5], radius_m: 0.5, class: 0, ..base };
    frame
}

fn obstacles(frame: &Detections) -> Obstacles {
    let mut obstacles = Obstacles {
        stamp: frame.stamp,
        bridge_published_ns: frame.stamp.published_ns,
        received_ns: frame.stamp.published_ns + 500,
        count: frame.count,
        ..Obstacles::zeroed()
    };
    for (obstacle, detection) in obstacles.items.iter_mut().zip(frame.as_slice()) {
        *obstacle = Obstacle {
            track_id: detection.track_id.max(1),
            measured_at_ns: frame.stamp.valid_at_ns,
            valid_at_ns: frame.stamp.valid_at_ns,
            position_in_odom_m: detection.position_in_odom_m,
            velocity_in_odom_mps: [-1.0, 0.5],
            speed_mps: 1.25_f64.sqrt(),
            radius_m: detection.radius_m,
            class: detection.class,
            quality: ObstacleQuality::Velocity.code(),
            ..Obstacle::zeroed()
        };
    }
    obstacles
}

fn safe_command(step: u32, time_ns: u64, nominal: &NominalCommand) -> SafeCommand {
    let sees_nobody = step % 5 == 4;
    let h_m = if sees_nobody { f64::INFINITY } else { 1.5 - 0.02 * f64::from(step) };
    SafeCommand {
        sequence: u64::from(step) + 1,
        control: [0.5, 0.3 - 0.01 * f64::from(step)],
        nominal: nominal.control,
        control_kind: ControlKind::Unicycle.code(),
        status: SafetyStatus::Filtered.code(),
        h_m,
        sdf_m: h_m + 0.25,
        critical_track_id: if sees_nobody { 0 } else { 7 },
        ledger: messages::Ledger { filter_published_ns: time_ns + 2_900, ..messages::Ledger::zeroed() },
        ..SafeCommand::zeroed()
    }
}

fn slow_messages(sequence: u64, time_ns: u64, log_time_ns: u64) -> Vec<(u64, WireMessage)> {
    let goal = Goal { stamp: stamp(sequence, time_ns), position_in_odom_m: [13.5, -0.5], heading_rad: 0.25 };
    let status = SourceStatus {
        published_ns: time_ns,
        min_clearance_m: f64::INFINITY,
        kind: SourceKind::Simulation.code(),
        ..SourceStatus::zeroed()
    };
    let health = Health { published_ns: time_ns, process: ProcessId::Filter.code(), ..Health::zeroed() };
    vec![(log_time_ns, goal.into()), (log_time_ns, status.into()), (log_time_ns, health.into())]
}

/// What the sample says of itself.
pub(crate) fn sample_info() -> RecordingInfo {
    RecordingInfo {
        version: "0.0.0-sample".into(),
        kernel: "portable".into(),
        settings: "[robot]\nkind = \"unicycle\"\n".into(),
        shadow: false,
        odom_frame: "odom".into(),
        base_frame: "base_link".into(),
    }
}

/// Writes the sample.
pub(crate) fn write_sample(path: &Path) {
    let mut recorder = Recorder::create(path, sample_info()).unwrap();
    for (log_time_ns, message) in sample_messages() {
        assert!(recorder.record(log_time_ns, message), "the queue holds the whole sample");
    }
    let report = recorder.finish().unwrap();
    assert_eq!((report.written, report.dropped), (sample_messages().len() as u64, 0));
}
