//! From a recording's messages to the playlist: times aligned, frames resolved, everything else counted as refused.

use std::path::Path;

use messages::{Detection, DetectionFlags, Goal, Reason, RobotState, Stamp};
use nalgebra::Isometry3;
use recording::ros2::Header;
use recording::{McapReader, RecordedKind, RecordedMessage, WireMessage};
use settings::{Settings, SourceSettings};

use super::IntakeReport;
use super::clock::ClockOffset;
use super::error::SourceError;
use super::playlist::{Content, Entry, Playlist};
use super::topics::Topics;
use crate::decode::{self, RadiusRule};
use crate::frames::Frames;
use crate::markers::Markers;
use crate::obstacle_frames::{ObstacleFrame, Scene, recorded};
use crate::plausible::plausible;

const NS_PER_MS: u64 = 1_000_000;

/// Reads a recording completely.
pub(super) fn load(path: &Path, settings: &Settings) -> Result<(Playlist, IntakeReport), SourceError> {
    let mut reader = McapReader::open(path)?;
    let topics = Topics::choose(&reader, &settings.source)?;
    let mut report = IntakeReport::default();
    let mut messages = Vec::new();
    while let Some(message) = reader.next_message() {
        let is_transform = topics.transforms.iter().any(|topic| **topic == *message.topic);
        let is_needed = [&topics.odometry, &topics.detections].into_iter().chain(&topics.goal);
        if is_transform || is_needed.into_iter().any(|topic| **topic == *message.topic) {
            messages.push(message);
        } else {
            report.not_needed += 1;
        }
    }
    report.found = reader.summary().messages;
    report.unreadable = *reader.refusals();

    decode_all(&messages, path, settings, report)
}

/// Decodes the messages of the chosen topics, given in log-time order.
pub(super) fn decode_all(
    messages: &[RecordedMessage],
    path: &Path,
    settings: &Settings,
    report: IntakeReport,
) -> Result<(Playlist, IntakeReport), SourceError> {
    let clock = ClockOffset::estimate(messages.iter().filter_map(|message| {
        let header = header(&message.kind)?;
        Some((message.log_time_ns, header.stamp.to_ns()?))
    }));
    let mut intake = Intake::new(settings, clock, report);
    let has_transforms = messages.iter().any(|message| matches!(message.kind, RecordedKind::Transforms(_)));
    intake.may_assume_odom = settings.source.assume_odom_frame && !has_transforms;
    intake.take_frames(messages);
    for message in messages {
        match intake.take(message) {
            Ok(()) => intake.report.used += 1,
            Err(reason) => *intake.report.refused.entry(reason).or_default() += 1,
        }
    }
    intake.finish(path)
}

fn header(kind: &RecordedKind) -> Option<&Header> {
    match kind {
        RecordedKind::Odometry(message) => Some(&message.header),
        RecordedKind::Pose(message) => Some(&message.header),
        other => recorded(other)?.header(),
    }
}

/// What has been taken in so far.
struct Intake<'a> {
    settings: &'a SourceSettings,
    radius: RadiusRule,
    clock: ClockOffset,
    frames: Frames,
    markers: Markers,
    /// Whether frames of which nothing is known are taken for `odom`.
    may_assume_odom: bool,
    report: IntakeReport,
    entries: Vec<Entry>,
    states: Vec<RobotState>,
    people: Vec<Detection>,
    goals: Vec<Goal>,
    /// Validity of the newest robot state and of the newest frame, ns.
    newest_ns: [u64; 2],
}

/// When a message was received, held, and was stamped, ns.
#[derive(Clone, Copy)]
#[expect(clippy::struct_field_names, reason = "the unit belongs to the name")]
struct Times {
    due_ns: u64,
    valid_ns: u64,
    source_ns: u64,
}

impl<'a> Intake<'a> {
    fn new(settings: &'a Settings, clock: ClockOffset, report: IntakeReport) -> Self {
        let [smallest_m, largest_m] = settings.source.radius_range_m;
        Self {
            settings: &settings.source,
            radius: RadiusRule { default_m: settings.obstacle.radius_m, smallest_m, largest_m },
            clock,
            frames: Frames::new(settings.source.max_transform_age_ms * NS_PER_MS),
            markers: Markers::default(),
            may_assume_odom: false,
            report,
            entries: Vec::new(),
            states: Vec::new(),
            people: Vec::new(),
            goals: Vec::new(),
            newest_ns: [0; 2],
        }
    }

    /// First of all the frames: a message may need a transform that was recorded after it.
    fn take_frames(&mut self, messages: &[RecordedMessage]) {
        for message in messages {
            if let RecordedKind::Transforms(transforms) = &message.kind {
                let is_static = message.topic.ends_with("tf_static");
                for transform in &transforms.transforms {
                    let time_ns =
                        self.clock.measured_at(message.log_time_ns, transform.header.stamp.to_ns()).time_ns;
                    let inserted = decode::transform_isometry(&transform.transform).and_then(|isometry| {
                        let (parent, child) = (&transform.header.frame_id, &transform.child_frame_id);
                        self.frames.insert(parent, child, time_ns, isometry, is_static)
                    });
                    if let Err(reason) = inserted {
                        *self.report.refused_transforms.entry(reason).or_default() += 1;
                    }
                }
            }
        }
        // Odometry is a transform, too; where /tf carries it, that one rules.
        let mut from_odometry = Vec::new();
        for message in messages {
            if let RecordedKind::Odometry(odometry) = &message.kind
                && !self.frames.knows(&odometry.child_frame_id)
                && let Ok(isometry) = decode::pose_isometry(&odometry.pose.pose)
            {
                let time_ns =
                    self.clock.measured_at(message.log_time_ns, odometry.header.stamp.to_ns()).time_ns;
                from_odometry.push((odometry, time_ns, isometry));
            }
        }
        for (odometry, time_ns, isometry) in from_odometry {
            let (parent, child) = (&odometry.header.frame_id, &odometry.child_frame_id);
            // A nameless frame only means that nothing can refer to it.
            let is_named = !parent.is_empty() && !child.is_empty();
            if is_named && let Err(reason) = self.frames.insert(parent, child, time_ns, isometry, false) {
                *self.report.refused_transforms.entry(reason).or_default() += 1;
            }
        }
    }

    fn take(&mut self, message: &RecordedMessage) -> Result<(), Reason> {
        match &message.kind {
            RecordedKind::Odometry(odometry) => {
                let times = self.times(message.log_time_ns, &odometry.header);
                let odom_from_frame = self.odom_from(&odometry.header, times)?;
                self.take_state(times, decode::odometry(odometry, &odom_from_frame)?)
            }
            RecordedKind::Pose(pose) => {
                let times = self.times(message.log_time_ns, &pose.header);
                let odom_from_frame = self.odom_from(&pose.header, times)?;
                self.take_goal(times, decode::goal(pose, &odom_from_frame)?);
                Ok(())
            }
            RecordedKind::Wire(wire) => self.take_wire(message.log_time_ns, wire),
            RecordedKind::Transforms(_) => Ok(()),
            // No topic of another type is ever chosen.
            other => self.take_frame(message.log_time_ns, recorded(other).ok_or(Reason::MalformedInput)?),
        }
    }

    fn take_frame(&mut self, log_time_ns: u64, frame: &dyn ObstacleFrame) -> Result<(), Reason> {
        let unstamped = Header::default();
        let times = self.times(log_time_ns, frame.header().unwrap_or(&unstamped));
        let mut markers = std::mem::take(&mut self.markers);
        let mut people = Vec::new();
        let mut scene = Scene {
            radius: self.radius,
            place: &mut |header| self.odom_from(header, times),
            markers: &mut markers,
            arrival_ns: log_time_ns,
            people: &mut people,
            refused: 0,
        };
        let decoded = frame.decode(&mut scene);
        self.report.refused_detections += scene.refused;
        self.markers = markers;
        decoded?;
        self.take_people(times, people.into_iter().map(Ok), 0)
    }

    fn take_wire(&mut self, log_time_ns: u64, wire: &WireMessage) -> Result<(), Reason> {
        match wire {
            WireMessage::RobotState(state) if state.is_finite() => {
                let times = self.wire_times(log_time_ns, &state.stamp)?;
                self.take_state(times, *state)
            }
            WireMessage::RobotState(_) => Err(Reason::NonFiniteRobotState),
            WireMessage::Detections(frame) => {
                let times = self.wire_times(log_time_ns, &frame.stamp)?;
                let people = frame.as_slice().iter().map(|detection| sound(*detection));
                self.take_people(times, people, frame.left_out)
            }
            WireMessage::Goal(goal) if goal.is_finite() => {
                let times = self.wire_times(log_time_ns, &goal.stamp)?;
                self.take_goal(times, *goal);
                Ok(())
            }
            WireMessage::Goal(_)
            | WireMessage::Obstacles(_)
            | WireMessage::NominalCommand(_)
            | WireMessage::SafeCommand(_)
            | WireMessage::SourceStatus(_)
            | WireMessage::Health(_)
            | WireMessage::Cycle(_) => Err(Reason::MalformedInput),
        }
    }

    fn times(&mut self, log_time_ns: u64, header: &Header) -> Times {
        let stamp_ns = header.stamp.to_ns();
        let measured_at = self.clock.measured_at(log_time_ns, stamp_ns);
        self.report.restamped += u64::from(measured_at.is_log_time);
        Times {
            due_ns: log_time_ns,
            valid_ns: measured_at.time_ns,
            source_ns: stamp_ns.unwrap_or(log_time_ns),
        }
    }

    /// Times of a message of this stack: its stamps are on the recorder's clock already, so that an absurd one means that
    /// the message is broken.
    fn wire_times(&mut self, log_time_ns: u64, stamp: &Stamp) -> Result<Times, Reason> {
        let or = |time_ns: u64, fallback_ns| if time_ns > 0 { time_ns } else { fallback_ns };
        let due_ns = plausible(log_time_ns, or(stamp.published_ns, log_time_ns))?;
        let valid_ns = plausible(log_time_ns, or(stamp.valid_at_ns, due_ns))?;
        self.report.restamped += u64::from(stamp.valid_at_ns == 0);
        Ok(Times { due_ns, valid_ns, source_ns: stamp.source_ns })
    }

    /// The transform from a message's frame to `odom`.
    fn odom_from(&mut self, header: &Header, times: Times) -> Result<Isometry3<f64>, Reason> {
        let odom = &self.settings.odom_frame;
        let found = self.frames.lookup(odom, &header.frame_id, times.valid_ns);
        // A frame that is connected, only not at this time, is known not to be odom.
        if found.is_err() && self.may_assume_odom && !self.frames.knows(&header.frame_id) {
            self.report.assumed_odom += 1;
            return Ok(Isometry3::identity());
        }
        found
    }

    fn take_state(&mut self, times: Times, state: RobotState) -> Result<(), Reason> {
        self.keep_order(0, times)?;
        let index = self.states.len() as u32;
        self.states.push(state);
        self.push(times, Content::Robot(index));
        Ok(())
    }

    fn take_people(
        &mut self,
        times: Times,
        people: impl Iterator<Item = Result<Detection, Reason>>,
        left_out: u32,
    ) -> Result<(), Reason> {
        self.keep_order(1, times)?;
        let first = self.people.len();
        for detection in people {
            match detection {
                Ok(detection) => self.people.push(detection),
                Err(_) => self.report.refused_detections += 1,
            }
        }
        let count = (self.people.len() - first) as u32;
        self.push(times, Content::People { first: first as u32, count, left_out });
        Ok(())
    }

    fn take_goal(&mut self, times: Times, goal: Goal) {
        let index = self.goals.len() as u32;
        self.goals.push(goal);
        self.push(times, Content::Goal(index));
    }

    /// Refuses what is older than its predecessor.
    fn keep_order(&mut self, stream: usize, times: Times) -> Result<(), Reason> {
        if times.valid_ns < self.newest_ns[stream] {
            return Err(Reason::BackwardStamp);
        }
        self.newest_ns[stream] = times.valid_ns;
        Ok(())
    }

    fn push(&mut self, times: Times, content: Content) {
        let Times { due_ns, valid_ns, source_ns } = times;
        self.entries.push(Entry { due_ns, valid_ns, source_ns, content });
    }

    fn finish(self, path: &Path) -> Result<(Playlist, IntakeReport), SourceError> {
        let unusable = |what| {
            let reasons = self.report.refused.iter().map(|(reason, count)| format!("{count} {reason}"));
            let reasons: Vec<_> = reasons.collect();
            SourceError::NothingUsable { path: path.to_owned(), what, reasons: reasons.join(", ") }
        };
        if self.states.is_empty() {
            return Err(unusable("odometry"));
        }
        if !self.entries.iter().any(|entry| matches!(entry.content, Content::People { .. })) {
            return Err(unusable("detections"));
        }
        for (reason, count) in &self.report.refused {
            tracing::warn!(recording = %path.display(), %reason, count, "messages refused");
        }
        if self.report.assumed_odom > 0 {
            let (recording, count) = (path.display(), self.report.assumed_odom);
            tracing::warn!(%recording, count, "no transforms recorded: frames of messages taken for odom");
        }
        Ok((Playlist::new(self.entries, self.states, self.people, self.goals), self.report))
    }
}

/// A detection of a wire message, checked as any other.
fn sound(detection: Detection) -> Result<Detection, Reason> {
    let has_velocity = detection.flags & DetectionFlags::HAS_VELOCITY != 0;
    let velocity = if has_velocity { detection.velocity_in_odom_mps } else { [0.0; 2] };
    let is_finite = detection.position_in_odom_m.iter().chain(&velocity).all(|value| value.is_finite());
    let is_sound = is_finite && detection.radius_m.is_finite() && detection.radius_m > 0.0;
    if is_sound { Ok(detection) } else { Err(Reason::UnsoundObstacle) }
}
