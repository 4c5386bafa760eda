//! Damaged files: nothing panics, nothing good is lost, everything bad is counted.

#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use common::{scratch, write_sample};
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions};
use rand::RngExt;
use rand_pcg::Pcg64;
use recording::ros2::{Float64, PoseStamped, Ros2Message};
use recording::{Damage, McapReader, OpenError, RecordedKind, RefusalReason, cdr};

fn number(value: f64) -> Vec<u8> {
    let mut bytes = Vec::new();
    cdr::encode(&Float64 { data: value }, &mut bytes).unwrap();
    bytes
}

/// Writes numbers 0, 1, … on /numbers, ten to a chunk, by the `mcap` crate.
fn write_numbers(path: &Path, count: u32, options: WriteOptions) {
    let mut writer = options.create(fs::File::create(path).unwrap()).unwrap();
    let definition = Float64::definition();
    let schema = writer.add_schema(&Float64::type_name(), "ros2msg", definition.as_bytes()).unwrap();
    let channel_id = writer.add_channel(schema, "/numbers", "cdr", &BTreeMap::new()).unwrap();
    for sequence in 0..count {
        let log_time = u64::from(sequence) * 1_000;
        let header = MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
        writer.write_to_known_channel(&header, &number(f64::from(sequence))).unwrap();
        if sequence % 10 == 9 {
            writer.flush().unwrap();
        }
    }
    writer.finish().unwrap();
}

fn numbers(reader: &mut McapReader) -> Vec<f64> {
    reader
        .map(|message| match message.kind {
            RecordedKind::Number(number) => number.data,
            other => panic!("{other:?}"),
        })
        .collect()
}

fn is_complete(reader: &McapReader, handed_out: usize) -> bool {
    reader.summary().messages == handed_out as u64 + reader.refusals().total()
}

#[test]
fn chunks_plain_lz4_and_zstd_and_no_chunks_at_all_are_read() {
    let expected: Vec<f64> = (0..45).map(f64::from).collect();
    for compression in [None, Some(Compression::Lz4), Some(Compression::Zstd)] {
        let path = scratch("compressions.mcap");
        write_numbers(&path, 45, WriteOptions::new().compression(compression));
        assert_eq!(numbers(&mut McapReader::open(&path).unwrap()), expected, "{compression:?}");
    }
    let path = scratch("no_chunks.mcap");
    write_numbers(&path, 45, WriteOptions::new().use_chunks(false));
    assert_eq!(numbers(&mut McapReader::open(&path).unwrap()), expected);
}

#[test]
fn a_file_larger_than_every_buffer_is_read_whole() {
    let path = scratch("large.mcap");
    write_numbers(&path, 20_000, WriteOptions::new().compression(None));
    assert!(fs::metadata(&path).unwrap().len() > 1 << 20);
    let found = numbers(&mut McapReader::open(&path).unwrap());
    assert_eq!(found, (0..20_000).map(f64::from).collect::<Vec<_>>());
}

#[test]
fn messages_come_in_log_time_order_whatever_the_file_order() {
    let path = scratch("shuffled.mcap");
    let mut writer = WriteOptions::new().create(fs::File::create(&path).unwrap()).unwrap();
    let schema = writer.add_schema("std_msgs/msg/Float64", "ros2msg", b"float64 data\n").unwrap();
    let channel_id = writer.add_channel(schema, "/numbers", "cdr", &BTreeMap::new()).unwrap();
    // Two chunks that overlap in time, and equal times that must keep their order.
    for (time, value) in
        [(50, 5.0), (10, 1.0), (10, 1.5), (90, 9.0), (30, 3.0), (0, 0.0), (70, 7.0), (10, 1.75)]
    {
        let header = MessageHeader { channel_id, sequence: 0, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, &number(value)).unwrap();
        if value == 9.0 {
            writer.flush().unwrap();
        }
    }
    writer.finish().unwrap();
    assert_eq!(numbers(&mut McapReader::open(&path).unwrap()), [0.0, 1.0, 1.5, 1.75, 3.0, 5.0, 7.0, 9.0]);
}

#[test]
fn missing_empty_and_foreign_files_each_say_what_to_do() {
    let missing = McapReader::open(&scratch("nowhere.mcap")).err().unwrap().to_string();
    assert!(missing.contains("nowhere.mcap") && missing.contains("check the path"), "{missing}");

    let path = scratch("empty.mcap");
    fs::write(&path, []).unwrap();
    assert!(matches!(McapReader::open(&path), Err(OpenError::Empty { .. })));
    fs::write(&path, b"SQLite format 3\0 and more").unwrap();
    assert!(matches!(McapReader::open(&path), Err(OpenError::NotMcap { .. })));
    fs::write(&path, &mcap::MAGIC[..5]).unwrap();
    assert!(matches!(McapReader::open(&path), Err(OpenError::NotMcap { .. })));
    fs::write(&path, mcap::MAGIC).unwrap();
    let nothing = McapReader::open(&path).err().unwrap().to_string();
    assert!(nothing.contains("breaks off at byte 8"), "{nothing}");
    let folder = McapReader::open(Path::new(env!("CARGO_TARGET_TMPDIR"))).err().unwrap().to_string();
    assert!(folder.contains("cannot read"), "{folder}");
}

#[test]
fn a_truncated_file_gives_everything_that_was_flushed() {
    let path = scratch("truncated.mcap");
    write_numbers(&path, 40, WriteOptions::new());
    let whole = fs::read(&path).unwrap();
    let mut counts = Vec::new();
    for length in (100..whole.len()).step_by(37) {
        fs::write(&path, &whole[..length]).unwrap();
        if let Ok(mut reader) = McapReader::open(&path) {
            let found = numbers(&mut reader);
            assert_eq!(found, (0..found.len()).map(|index| index as f64).collect::<Vec<_>>());
            assert!(matches!(reader.summary().damage[..], [Damage::Truncated { .. }]));
            counts.push(found.len());
        }
    }
    assert_eq!(counts.iter().max(), Some(&40));
    assert!(counts.iter().all(|count| count % 10 == 0), "chunks come whole: {counts:?}");
}

#[test]
fn a_damaged_chunk_costs_itself_and_is_counted() {
    let path = scratch("one_bad_chunk.mcap");
    write_numbers(&path, 40, WriteOptions::new().compression(None));
    let whole = fs::read(&path).unwrap();
    // The first chunk also declares the channel; the index at the end of the file must replace it.
    for (value, lost) in [(3.0, 0..10), (25.0, 20..30)] {
        let needle = number(value);
        let at = whole.windows(needle.len()).position(|window| window == needle).unwrap();
        let mut damaged = whole.clone();
        damaged[at + 9] ^= 0x10;
        fs::write(&path, &damaged).unwrap();
        let mut reader = McapReader::open(&path).unwrap();
        let expected: Vec<f64> = (0..40).filter(|index| !lost.contains(index)).map(f64::from).collect();
        assert_eq!(numbers(&mut reader), expected);
        assert_eq!(reader.refusals().of(RefusalReason::DamagedChunk), 10);
        assert!(is_complete(&reader, 30));
        assert!(matches!(reader.summary().damage[..], [Damage::Chunk { .. }, Damage::DataSection]));
    }
}

#[test]
fn a_damaged_length_does_not_hide_what_follows() {
    let path = scratch("bad_length.mcap");
    write_numbers(&path, 40, WriteOptions::new());
    let whole = fs::read(&path).unwrap();
    let summary = mcap::Summary::read(&whole).unwrap().unwrap();
    let second_chunk = summary.chunk_indexes[1].chunk_start_offset as usize;
    for byte in 1..9 {
        let mut damaged = whole.clone();
        damaged[second_chunk + byte] ^= 0x41;
        fs::write(&path, &damaged).unwrap();
        let mut reader = McapReader::open(&path).unwrap();
        let found = numbers(&mut reader);
        assert!(found.len() >= 30, "byte {byte}: only {} messages", found.len());
        assert!(!reader.summary().damage.is_empty());
    }
}

#[test]
fn random_damage_never_panics_and_never_invents_a_number() {
    let path = scratch("random_damage.mcap");
    let mut random = Pcg64::new(20_240_611, 7);
    for compression in [None, Some(Compression::Lz4), Some(Compression::Zstd)] {
        write_numbers(&path, 60, WriteOptions::new().compression(compression));
        let whole = fs::read(&path).unwrap();
        for _ in 0..200 {
            let mut damaged = whole.clone();
            for _ in 0..random.random_range(1..4) {
                let at = random.random_range(0..damaged.len());
                damaged[at] ^= 1 << random.random_range(0..8);
            }
            if random.random_range(0..4) == 0 {
                damaged.truncate(random.random_range(0..whole.len()));
            }
            fs::write(&path, &damaged).unwrap();
            let Ok(mut reader) = McapReader::open(&path) else { continue };
            let mut handed_out = 0;
            while let Some(message) = reader.next_message() {
                handed_out += 1;
                // A changed content is caught by the chunk's checksum.
                if let RecordedKind::Number(number) = message.kind {
                    assert!(number.data.fract() == 0.0 && (0.0..60.0).contains(&number.data), "{number:?}");
                }
            }
            assert!(is_complete(&reader, handed_out));
        }
    }
}

/// Changes one random byte of the recording at a time: it is refused, or every message is handed out or counted.
fn survives_changed_bytes(path: &Path, rounds: usize, random: &mut Pcg64) {
    let whole = fs::read(path).unwrap();
    for _ in 0..rounds {
        let mut damaged = whole.clone();
        let at = random.random_range(0..damaged.len());
        damaged[at] = random.random();
        fs::write(path, &damaged).unwrap();
        let Ok(mut reader) = McapReader::open(path) else { continue };
        let handed_out = reader.by_ref().count();
        assert!(is_complete(&reader, handed_out));
    }
}

#[test]
fn random_damage_of_a_whole_stacks_recording_never_panics() {
    let path = scratch("random_damage_stack.mcap");
    write_sample(&path);
    let mut random = Pcg64::new(99, 7);
    survives_changed_bytes(&path, 150, &mut random);
}

#[test]
fn unchecked_damage_inside_a_chunk_never_panics() {
    let path = scratch("unchecked_damage.mcap");
    let mut random = Pcg64::new(5, 7);
    for compression in [None, Some(Compression::Zstd)] {
        let options = WriteOptions::new().compression(compression).calculate_chunk_crcs(false);
        write_numbers(&path, 30, options);
        survives_changed_bytes(&path, 200, &mut random);
    }
}

#[test]
fn every_kind_of_bad_message_is_refused_by_name_and_the_good_ones_pass() {
    let path = scratch("refusals.mcap");
    let mut writer = WriteOptions::new().create(fs::File::create(&path).unwrap()).unwrap();
    let definition = Float64::definition();
    let mut put = |topic: &str, encoding: &str, type_name: &str, definition: &str, data: &[u8]| {
        let is_wire = encoding == recording::WIRE_ENCODING;
        let schema =
            if is_wire { 0 } else { writer.add_schema(type_name, "ros2msg", definition.as_bytes()).unwrap() };
        let notes = [(recording::WIRE_TYPE_NOTE.to_owned(), type_name.to_owned())].into();
        let channel_id = writer.add_channel(schema, topic, encoding, &notes).unwrap();
        let header = MessageHeader { channel_id, sequence: 0, log_time: 1, publish_time: 1 };
        writer.write_to_known_channel(&header, data).unwrap();
    };
    let good = number(4.0);
    put("/good", "cdr", "std_msgs/msg/Float64", &definition, &good);
    put("/nan", "cdr", "std_msgs/msg/Float64", &definition, &number(f64::NAN));
    put("/short", "cdr", "std_msgs/msg/Float64", &definition, &good[..7]);
    put("/long", "cdr", "std_msgs/msg/Float64", &definition, &[good.clone(), vec![0; 8]].concat());
    put("/scan", "cdr", "sensor_msgs/msg/LaserScan", "float32 angle_min\n", &good);
    put("/json", "json", "std_msgs/msg/Float64", &definition, b"{\"data\": 4.0}");
    let old = PoseStamped::definition().replace("string frame_id\n", "string frame_id\nuint32 seq\n");
    put("/old", "cdr", "geometry_msgs/msg/PoseStamped", &old, &good);
    put("/wire", "cncbf-wire", "cncbf/RobotState/v0", "", &good);
    put("/wire_size", "cncbf-wire", "cncbf/RobotState/v1", "", &good);
    writer.finish().unwrap();

    let mut reader = McapReader::open(&path).unwrap();
    let topics: Vec<_> = reader.by_ref().map(|message| message.topic.to_string()).collect();
    assert_eq!(topics, ["/good", "/nan"]);
    let refused: Vec<_> = reader.refusals().iter().collect();
    assert_eq!(
        refused,
        [
            (RefusalReason::UnknownSchema, 1),
            (RefusalReason::ForeignDefinition, 1),
            (RefusalReason::UnsupportedEncoding, 1),
            (RefusalReason::Undecodable, 2),
            (RefusalReason::WireSize, 1),
            (RefusalReason::WireVersion, 1),
        ]
    );
}
