//! What the recorder writes comes back: by our reader, by the `mcap` crate's, bit for bit.

#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

mod common;

use std::fs;

use common::{sample_info, sample_messages, scratch, write_sample};
use messages::{Detections, Goal, Message, SafeCommand};
use recording::{McapReader, ReadWireError, RecordedKind, Recorder, WireMessage, read_wire};

#[test]
fn every_wire_message_comes_back_bit_for_bit_and_in_order() {
    let path = scratch("round_trip.mcap");
    write_sample(&path);
    let mut reader = McapReader::open(&path).unwrap();
    let wire: Vec<(u64, WireMessage)> = reader
        .by_ref()
        .filter_map(|message| match message.kind {
            RecordedKind::Wire(wire) => Some((message.log_time_ns, *wire)),
            _ => None,
        })
        .collect();
    assert_eq!(wire, sample_messages());
    assert_eq!(reader.refusals().total(), 0);
    assert_eq!(reader.summary().damage, []);
    assert_eq!(reader.summary().unchecked_chunks, 0);
    assert!(reader.summary().chunks >= 3, "three seconds are flushed at least thrice");
}

#[test]
fn ros_messages_say_the_same() {
    let path = scratch("round_trip_ros.mcap");
    write_sample(&path);
    let messages: Vec<_> = McapReader::open(&path).unwrap().collect();
    let count = |topic: &str| messages.iter().filter(|message| &*message.topic == topic).count();
    for topic in
        ["/odom", "/detections", "/cmd_vel", "/cmd_vel_nominal", "/cncbf/h", "/cncbf/sdf", "/cncbf/obstacles"]
    {
        assert_eq!(count(topic), 30, "{topic}");
    }
    assert_eq!(count("/goal_pose"), 3);

    let kind =
        |topic: &str| messages.iter().find(|message| &*message.topic == topic).map(|found| &found.kind);
    let Some(RecordedKind::Odometry(odometry)) = kind("/odom") else { panic!("no odometry") };
    assert_eq!(odometry.header.stamp.to_ns(), Some(5_000_000_000));
    assert_eq!((odometry.header.frame_id.as_str(), odometry.child_frame_id.as_str()), ("odom", "base_link"));
    assert_eq!([odometry.pose.pose.position.x, odometry.pose.pose.position.y], [-1.5, 0.25]);
    assert_eq!(odometry.twist.twist.linear.y, -0.01);
    let Some(RecordedKind::Detections(frame)) = kind("/detections") else { panic!("no detections") };
    let ids: Vec<_> = frame.detections.iter().map(|detection| detection.id.as_str()).collect();
    assert_eq!(ids, ["7", "1099511627776", ""]);
    assert_eq!(frame.detections[1].results[0].pose.covariance[0][1], 0.002);
    assert_eq!(frame.detections[2].bbox.size.x, 1.0);
    let Some(RecordedKind::Markers(markers)) = kind("/cncbf/obstacles") else { panic!("no markers") };
    assert_eq!(markers.markers.len(), 1 + 2 * 3);
}

#[test]
fn the_mcap_crate_reads_the_same_messages() {
    let path = scratch("round_trip_judge.mcap");
    write_sample(&path);
    let bytes = fs::read(&path).unwrap();
    let mut judged: Vec<_> = mcap::MessageStream::new(&bytes)
        .unwrap()
        .map(Result::unwrap)
        .map(|message| (message.log_time, message.channel.topic.clone()))
        .collect();
    judged.sort_by_key(|(log_time_ns, _)| *log_time_ns);
    let ours: Vec<_> = McapReader::open(&path)
        .unwrap()
        .map(|message| (message.log_time_ns, message.topic.to_string()))
        .collect();
    assert_eq!(ours, judged);
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    assert_eq!(summary.stats.unwrap().message_count, judged.len() as u64);
}

#[test]
fn one_service_is_read_typed_and_its_absence_and_other_versions_are_named() {
    let path = scratch("typed.mcap");
    write_sample(&path);
    let commands = read_wire::<SafeCommand>(&path).unwrap();
    assert_eq!(commands.len(), 30);
    assert_eq!(commands[4].1.h_m, f64::INFINITY);

    let only_goals = scratch("typed_goals.mcap");
    let mut recorder = Recorder::create(&only_goals, sample_info()).unwrap();
    recorder.record(1, commands[0].1);
    recorder.finish().unwrap();
    assert!(matches!(read_wire::<Goal>(&only_goals), Err(ReadWireError::NoChannel { .. })));

    let forged = scratch("typed_forged.mcap");
    forge(&forged, "cncbf/Detections/v99", &[0; 16]);
    assert!(matches!(read_wire::<Detections>(&forged), Err(ReadWireError::Open(_))), "nothing else is in it");
    forge(&forged, Detections::TYPE_NAME, &[0; 16]);
    assert!(matches!(
        read_wire::<Detections>(&forged),
        Err(ReadWireError::Size { found: 16, expected: 5168, .. })
    ));
}

/// A file with one wire message of any type name and content.
fn forge(path: &std::path::Path, type_name: &str, data: &[u8]) {
    let mut writer = mcap::Writer::new(fs::File::create(path).unwrap()).unwrap();
    let notes = [(recording::WIRE_TYPE_NOTE.to_owned(), type_name.to_owned())].into();
    let topic = recording::wire_topic(Detections::SERVICE);
    let channel_id = writer.add_channel(0, &topic, recording::WIRE_ENCODING, &notes).unwrap();
    let header = mcap::records::MessageHeader { channel_id, sequence: 0, log_time: 1, publish_time: 1 };
    writer.write_to_known_channel(&header, data).unwrap();
    writer.finish().unwrap();
}

#[test]
fn the_file_names_version_kernel_and_settings() {
    let path = scratch("metadata.mcap");
    write_sample(&path);
    let reader = McapReader::open(&path).unwrap();
    assert_eq!(reader.summary().profile, "ros2");
    let notes = &reader.summary().metadata["cncbf"];
    assert_eq!(notes["version"], "0.0.0-sample");
    assert_eq!(notes["kernel"], "portable");
    assert_eq!(notes["settings"], sample_info().settings);
}

#[test]
fn equal_runs_give_equal_files() {
    let (first, second) = (scratch("equal_1.mcap"), scratch("equal_2.mcap"));
    write_sample(&first);
    write_sample(&second);
    assert!(fs::read(first).unwrap() == fs::read(second).unwrap());
}

#[test]
fn a_file_that_cannot_be_made_says_which() {
    let error = Recorder::create(&scratch("no/such/folder.mcap"), sample_info()).unwrap_err().to_string();
    assert!(error.contains("no/such/folder.mcap") && error.contains("check"), "{error}");
}

#[test]
fn a_full_disk_is_named() {
    let full = std::path::Path::new("/dev/full");
    if !full.exists() {
        println!("skipped: this system has no /dev/full");
        return;
    }
    let error = Recorder::create(full, sample_info()).unwrap_err().to_string();
    assert!(error.contains("/dev/full") && error.contains("No space left"), "{error}");
}

#[test]
fn under_overload_what_is_dropped_is_counted_and_the_rest_is_written() {
    let path = scratch("overload.mcap");
    let mut recorder = Recorder::create(&path, sample_info()).unwrap();
    let (mut offered, mut taken) = (0, 0);
    for _ in 0..60 {
        for (log_time_ns, message) in sample_messages() {
            offered += 1;
            taken += u64::from(recorder.record(log_time_ns, message));
        }
    }
    let report = recorder.finish().unwrap();
    assert_eq!((report.written, report.written + report.dropped), (taken, offered));
    let mut reader = McapReader::open(&path).unwrap();
    let wire = reader.by_ref().filter(|message| matches!(message.kind, RecordedKind::Wire(_))).count();
    assert_eq!(wire as u64, taken);
}
