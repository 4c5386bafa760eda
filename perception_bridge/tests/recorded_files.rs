//! Whole files as sources: our own recordings bit for bit, those of others with every message accounted for.
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use std::path::{Path, PathBuf};

use bytemuck::Zeroable;
use messages::{Detections, RobotState};
use perception_bridge::{BridgeEvent, McapSource, SimulatedCrowd, Source, SourceError};
use recording::{Recorder, RecordingInfo};
use settings::Settings;

const MS: u64 = 1_000_000;
const BEGIN_NS: u64 = 3_000 * MS;

fn settings() -> Settings {
    Settings::load(&repository("config/ground_robot.toml")).unwrap()
}

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

fn scratch(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// Plays a source on a 1 ms grid.
fn play(source: &mut dyn Source, milliseconds: u64) -> Vec<BridgeEvent> {
    let mut events = Vec::new();
    for tick in 0..milliseconds {
        while let Some(event) = source.poll(BEGIN_NS + tick * MS) {
            events.push(event);
        }
    }
    events
}

fn frames(events: &[BridgeEvent]) -> Vec<Detections> {
    let frame = |event: &BridgeEvent| match event {
        BridgeEvent::Detections(frame) => Some(*frame),
        BridgeEvent::RobotState(_) | BridgeEvent::Goal(_) | BridgeEvent::NominalCommand(_) => None,
    };
    events.iter().filter_map(frame).collect()
}

fn states(events: &[BridgeEvent]) -> Vec<RobotState> {
    let state = |event: &BridgeEvent| match event {
        BridgeEvent::RobotState(state) => Some(*state),
        BridgeEvent::Detections(_) | BridgeEvent::Goal(_) | BridgeEvent::NominalCommand(_) => None,
    };
    events.iter().filter_map(state).collect()
}

#[test]
fn our_own_recording_of_a_simulation_plays_back_exactly_what_was_published() {
    let settings = settings();
    let path = scratch("own.mcap");
    let live = play(&mut SimulatedCrowd::new(&settings).unwrap(), 1_000);
    let info =
        RecordingInfo { odom_frame: "odom".into(), base_frame: "base".into(), ..RecordingInfo::default() };
    let mut recorder = Recorder::create(&path, info).unwrap();
    for event in &live {
        let recorded = match event.clone() {
            BridgeEvent::RobotState(mut message) => {
                message.stamp.published_ns = message.stamp.ingress_ns;
                recorder.record(message.stamp.published_ns, message)
            }
            BridgeEvent::Detections(mut message) => {
                message.stamp.published_ns = message.stamp.ingress_ns;
                recorder.record(message.stamp.published_ns, message)
            }
            BridgeEvent::Goal(mut message) => {
                message.stamp.published_ns = message.stamp.ingress_ns;
                recorder.record(message.stamp.published_ns, message)
            }
            BridgeEvent::NominalCommand(_) => panic!("a simulation has no controller of its own"),
        };
        assert!(recorded);
    }
    recorder.finish().unwrap();

    let mut source = McapSource::open(&path, &settings, false).unwrap();
    let report = source.report().clone();
    assert_eq!(report.found, report.used + report.refused_total() + report.not_needed);
    assert_eq!(report.used, live.len() as u64);
    let replayed = play(&mut source, 1_100);
    assert_eq!(states(&replayed), states(&live));
    assert_eq!(frames(&replayed), frames(&live));
}

#[test]
fn the_ros_side_of_our_recording_gives_the_same_up_to_what_ros_cannot_say() {
    let mut settings = settings();
    let path = scratch("own_ros.mcap");
    let live = play(&mut SimulatedCrowd::new(&settings).unwrap(), 500);
    let info =
        RecordingInfo { odom_frame: "odom".into(), base_frame: "base".into(), ..RecordingInfo::default() };
    let mut recorder = Recorder::create(&path, info).unwrap();
    for event in &live {
        match event.clone() {
            BridgeEvent::RobotState(message) => recorder.record(message.stamp.ingress_ns, message),
            BridgeEvent::Detections(message) => recorder.record(message.stamp.ingress_ns, message),
            BridgeEvent::Goal(message) => recorder.record(message.stamp.ingress_ns, message),
            BridgeEvent::NominalCommand(message) => recorder.record(message.stamp.ingress_ns, message),
        };
    }
    recorder.finish().unwrap();
    settings.source.odometry_topic = "/odom".into();
    settings.source.detections_topic = "/detections".into();
    settings.source.assume_odom_frame = false;
    let replayed = play(&mut McapSource::open(&path, &settings, false).unwrap(), 600);
    assert_eq!(states(&replayed).len(), states(&live).len());
    for (replayed, live) in frames(&replayed).iter().zip(frames(&live)) {
        for (replayed, live) in replayed.as_slice().iter().zip(live.as_slice()) {
            assert_eq!(replayed.track_id, live.track_id);
            assert_eq!(replayed.position_in_odom_m, live.position_in_odom_m);
            assert_eq!((replayed.radius_m, replayed.class, replayed.flags), (live.radius_m, live.class, 0));
        }
    }
}

#[test]
fn a_file_of_rosbags_is_accounted_for_message_by_message() {
    let settings = settings();
    let path = repository("tests/data/mcap_rosbags_reference.mcap");
    let mut source = McapSource::open(&path, &settings, false).unwrap();
    let report = source.report().clone();
    assert_eq!(report.found, 49);
    assert_eq!(report.found, report.used + report.refused_total() + report.not_needed);
    assert_eq!(report.not_needed, 12, "/people, since /detections has identities");
    assert!(!play(&mut source, 500).is_empty());
}

#[test]
fn what_is_missing_or_misnamed_is_said_with_what_there_is() {
    let mut settings = settings();
    let path = scratch("no_people.mcap");
    let mut recorder = Recorder::create(&path, RecordingInfo::default()).unwrap();
    recorder.record(1, RobotState::zeroed());
    recorder.finish().unwrap();
    let error = McapSource::open(&path, &settings, false).err().unwrap();
    assert!(matches!(error, SourceError::Missing { .. }));
    let text = error.to_string();
    assert!(text.contains("no detections") && text.contains("/cncbf/wire/robot_state"), "{text}");
    settings.source.odometry_topic = "/odometry/filtered".into();
    let text = McapSource::open(&path, &settings, false).err().unwrap().to_string();
    assert!(text.contains("/odometry/filtered") && text.contains("source.odometry_topic"), "{text}");
    assert!(McapSource::open(&scratch("nowhere.mcap"), &settings, false).is_err());
}

#[test]
fn real_recordings_beside_the_checkout_are_consumed_completely() {
    let settings = settings();
    for (name, used, refused) in [
        ("eth_seq_eth.mcap", 4200, 0),
        ("eth_seq_hotel.mcap", 4200, 0),
        ("real_wheelchair_moving_1.mcap", 11_834, 873),
    ] {
        let path = repository("../shared/recordings").join(name);
        if !path.exists() {
            println!("skipped: no recording {name} beside this checkout");
            continue;
        }
        let mut source = McapSource::open(&path, &settings, false).unwrap();
        let report = source.report().clone();
        assert_eq!((report.used, report.refused_total()), (used, refused), "{name}: {report:?}");
        let mut events = 0;
        let mut now_ns = BEGIN_NS;
        while let Some(due_ns) = source.next_due_ns() {
            now_ns = now_ns.max(due_ns);
            events += u64::from(source.poll(now_ns).is_some());
        }
        let status = source.status(now_ns);
        println!("{name}: {events} events, {status:?}");
        assert!(status.min_clearance_m.is_finite() && status.path_length_m > 1.0);
    }
}
