//! Messages to CDR and back, and whole recordings.

use std::path::PathBuf;

use bytemuck::Zeroable;
use messages::Obstacles;
use recording::cdr;
use recording::ros2::{
    BoundingBox3D, Detection3D, Detection3DArray, Header, ObjectHypothesis, ObjectHypothesisWithPose,
    Odometry, Point, Pose, PoseWithCovariance, Quaternion, Ros2Message, Time, Vector3,
};
use recording::{McapReader, Recorder, RecordingInfo};

use super::{START_NS, person, stamp};

fn header() -> Header {
    Header { stamp: Time { sec: 12, nanosec: 345 }, frame_id: "odom".into() }
}

fn pose(x: f64, y: f64) -> Pose {
    Pose { position: Point { x, y, z: 0.0 }, orientation: Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 } }
}

/// One ROS 2 message with its bytes.
pub struct Ros2Coding<T> {
    message: T,
    bytes: Vec<u8>,
}

impl Ros2Coding<Odometry> {
    pub fn odometry() -> Self {
        Self::of(Odometry {
            header: header(),
            child_frame_id: "base_link".into(),
            pose: PoseWithCovariance { pose: pose(1.0, 2.0), ..PoseWithCovariance::default() },
            ..Odometry::default()
        })
    }
}

impl Ros2Coding<Detection3DArray> {
    pub fn detections(people: usize) -> Self {
        let detections = (0..people).map(|index| {
            let [x, y] = person(index).position_in_odom_m;
            let hypothesis = ObjectHypothesis { class_id: "person".into(), score: 0.9 };
            let pose_there = PoseWithCovariance { pose: pose(x, y), ..PoseWithCovariance::default() };
            Detection3D {
                header: header(),
                results: vec![ObjectHypothesisWithPose { hypothesis, pose: pose_there }],
                bbox: BoundingBox3D { center: pose(x, y), size: Vector3 { x: 0.7, y: 0.7, z: 1.8 } },
                id: index.to_string(),
            }
        });
        Self::of(Detection3DArray { header: header(), detections: detections.collect() })
    }
}

impl<T: Ros2Message> Ros2Coding<T> {
    fn of(message: T) -> Self {
        let mut bytes = Vec::new();
        cdr::encode(&message, &mut bytes).unwrap();
        Self { message, bytes }
    }

    pub fn encode(&mut self) -> usize {
        cdr::encode(&self.message, &mut self.bytes).unwrap();
        self.bytes.len()
    }

    pub fn decode(&self) -> T {
        cdr::decode(&self.bytes).unwrap()
    }
}

/// Whole files of wire messages.
pub struct Recordings {
    folder: tempfile::TempDir,
    message: Box<Obstacles>,
}

impl Recordings {
    pub const MESSAGES: usize = 1_000;

    pub fn new() -> Self {
        let mut message = Box::new(Obstacles { stamp: stamp(START_NS), count: 20, ..Obstacles::zeroed() });
        for (index, item) in message.items.iter_mut().take(20).enumerate() {
            *item = person(index);
        }
        Self { folder: tempfile::tempdir().unwrap(), message }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("recording.mcap")
    }

    /// Writes the messages, raw and as ROS 2 markers, and closes the file.
    pub fn write(&self) -> u64 {
        let mut recorder = Recorder::create(&self.path(), RecordingInfo::default()).unwrap();
        for index in 0..Self::MESSAGES {
            recorder.record_waiting(START_NS + index as u64, *self.message);
        }
        recorder.finish().unwrap().written
    }

    /// Opens the file that [`Recordings::write`] left and takes every raw message from it.
    pub fn read(&self) -> usize {
        let mut reader = McapReader::open(&self.path()).unwrap();
        std::iter::from_fn(|| reader.next_message()).count()
    }
}

impl Default for Recordings {
    fn default() -> Self {
        Self::new()
    }
}
