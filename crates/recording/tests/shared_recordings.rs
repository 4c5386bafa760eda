//! Recordings of real pedestrians that lie beside the checkout on some machines: every message is handed out or counted.

#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use std::path::Path;

use recording::{McapReader, RecordedKind, RefusalReason};

/// Opens one of the recordings; where it is absent, says so.
fn open(name: &str) -> Option<McapReader> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/recordings").join(name);
    if path.exists() {
        Some(McapReader::open(&path).unwrap())
    } else {
        println!("skipped: no recording {name} beside this checkout");
        None
    }
}

#[test]
fn all_messages_of_the_pedestrian_recordings_are_handed_out() {
    for name in ["eth_seq_eth.mcap", "eth_seq_hotel.mcap"] {
        let Some(mut reader) = open(name) else { continue };
        let (mut odometry, mut detections) = (0, 0);
        while let Some(message) = reader.next_message() {
            match message.kind {
                RecordedKind::Odometry(_) => odometry += 1,
                RecordedKind::Detections(_) => detections += 1,
                other => panic!("{other:?}"),
            }
        }
        assert_eq!((odometry, detections, reader.refusals().total()), (3000, 1200, 0), "{name}");
        assert!(reader.summary().unchecked_chunks > 0, "rosbags writes no checksums");
    }
}

#[test]
fn of_the_wheelchair_recording_only_the_laser_scans_are_refused() {
    let Some(mut reader) = open("real_wheelchair_moving_1.mcap") else { return };
    let handed_out = reader.by_ref().count() as u64;
    let refused: Vec<_> = reader.refusals().iter().collect();
    assert_eq!(handed_out, 11_561 + 272 + 1);
    assert_eq!(refused, [(RefusalReason::UnknownSchema, 873)]);
    assert_eq!(reader.summary().messages, handed_out + reader.refusals().total());
}
