//! From live messages to the bridge's events: times, frames and order checked, each refusal with its reason.
//!
//! Knows neither DDS nor threads: messages and their arrival are passed in.

use bytemuck::Zeroable;
use messages::{Detection, Detections, Goal, MAX_OBSTACLES, Reason, RobotState, Stamp};
use recording::ros2::{
    Detection3DArray, Header, Odometry, PoseArray, PoseStamped, TFMessage, TrackedObjects, TransformStamped,
};
use settings::Settings;

use super::arrival::{Arrival, Measured};
use crate::decode::{self, RadiusRule};
use crate::frames::{Frames, plain};
use crate::nearest::by_distance;
use crate::source::BridgeEvent;

const NS_PER_MS: u64 = 1_000_000;
/// Transforms are kept this long; older stamps are refused anyway, ns.
const MEMORY_NS: u64 = 11_000 * NS_PER_MS;
/// Two clocks read one after the other show equal stamps this far apart, ns.
const CLOCK_JITTER_NS: u64 = 100_000;

/// What has been taken in so far.
pub(super) struct Intake {
    odom_frame: String,
    radius: RadiusRule,
    frames: Frames,
    /// The robot's frame while only odometry tells where it is.
    placed_by_odometry: Option<String>,
    /// Validity of the newest robot state and of the newest frame of obstacles, ns.
    newest_ns: [u64; 2],
    /// Of robot states, frames of obstacles, goals.
    sequences: [u64; 3],
    robot_m: [f64; 2],
    people: Vec<Detection>,
    order: Vec<usize>,
    refused_detections: u64,
}

impl Intake {
    /// Nothing taken in yet.
    pub(super) fn new(settings: &Settings) -> Self {
        let [smallest_m, largest_m] = settings.source.radius_range_m;
        Self {
            odom_frame: settings.source.odom_frame.clone(),
            radius: RadiusRule { default_m: settings.obstacle.radius_m, smallest_m, largest_m },
            frames: Frames::new(settings.source.max_transform_age_ms * NS_PER_MS),
            placed_by_odometry: None,
            newest_ns: [0; 2],
            sequences: [0; 3],
            robot_m: [0.0; 2],
            people: Vec::new(),
            order: Vec::new(),
            refused_detections: 0,
        }
    }

    /// Single detections refused within frames that were used.
    pub(super) const fn refused_detections(&self) -> u64 {
        self.refused_detections
    }

    /// Forgets what no message can need any more.
    pub(super) fn forget(&mut self, now_ns: u64) {
        self.frames.forget_before(now_ns.saturating_sub(MEMORY_NS));
    }

    /// Takes in transforms. Those that are sound are used even where others beside them are not.
    ///
    /// # Errors
    /// The reason of the last one refused.
    pub(super) fn transforms(
        &mut self,
        message: &TFMessage,
        is_static: bool,
        arrival: Arrival,
    ) -> Result<(), Reason> {
        let refusals =
            message.transforms.iter().filter_map(|one| self.transform(one, is_static, arrival).err());
        refusals.last().map_or(Ok(()), Err)
    }

    fn transform(&mut self, one: &TransformStamped, is_static: bool, arrival: Arrival) -> Result<(), Reason> {
        let time_ns =
            if is_static { arrival.stack_ns } else { arrival.measured(&one.header.stamp)?.valid_at_ns };
        let isometry = decode::transform_isometry(&one.transform)?;
        let child = plain(&one.child_frame_id);
        if self.placed_by_odometry.as_deref() == Some(child) {
            // Where /tf says where the robot is, that rules.
            self.frames.remove(child);
            self.placed_by_odometry = None;
        }
        self.frames.insert(&one.header.frame_id, child, time_ns, isometry, is_static)
    }

    /// Takes in where the robot is.
    ///
    /// # Errors
    /// Why it is refused.
    pub(super) fn odometry(&mut self, message: &Odometry, arrival: Arrival) -> Result<BridgeEvent, Reason> {
        let measured = self.in_order(0, arrival.measured(&message.header.stamp)?)?;
        self.place_robot(message, measured)?;
        let odom_from_frame =
            self.frames.lookup(&self.odom_frame, &message.header.frame_id, measured.valid_at_ns)?;
        let state = decode::odometry(message, &odom_from_frame)?;
        self.robot_m = state.position_in_odom_m;
        Ok(BridgeEvent::RobotState(RobotState { stamp: self.stamp(0, measured, arrival), ..state }))
    }

    /// Odometry is a transform, too, unless /tf carries it. A nameless frame only means that nothing can refer to it.
    fn place_robot(&mut self, message: &Odometry, measured: Measured) -> Result<(), Reason> {
        let (parent, child) = (plain(&message.header.frame_id), plain(&message.child_frame_id));
        let by_odometry = self.placed_by_odometry.as_deref() == Some(child);
        if parent.is_empty() || child.is_empty() || (self.frames.knows(child) && !by_odometry) {
            return Ok(());
        }
        let isometry = decode::pose_isometry(&message.pose.pose)?;
        self.frames.insert(parent, child, measured.valid_at_ns, isometry, false)?;
        if !by_odometry {
            self.placed_by_odometry = Some(child.to_owned());
        }
        Ok(())
    }

    /// Takes in obstacles given as boxes.
    ///
    /// # Errors
    /// Why the whole frame is refused.
    pub(super) fn boxes(
        &mut self,
        message: &Detection3DArray,
        arrival: Arrival,
    ) -> Result<BridgeEvent, Reason> {
        self.frame(&message.header, &message.detections, arrival, decode::detection)
    }

    /// Takes in obstacles given as positions.
    ///
    /// # Errors
    /// As [`Self::boxes`].
    pub(super) fn poses(&mut self, message: &PoseArray, arrival: Arrival) -> Result<BridgeEvent, Reason> {
        self.frame(&message.header, &message.poses, arrival, decode::anonymous)
    }

    /// Takes in obstacles given as tracks.
    ///
    /// # Errors
    /// As [`Self::boxes`].
    pub(super) fn tracks(
        &mut self,
        message: &TrackedObjects,
        arrival: Arrival,
    ) -> Result<BridgeEvent, Reason> {
        self.frame(&message.header, &message.objects, arrival, decode::tracked)
    }

    fn frame<T>(
        &mut self,
        header: &Header,
        items: &[T],
        arrival: Arrival,
        decode: impl Fn(&T, &nalgebra::Isometry3<f64>, RadiusRule) -> Result<Detection, Reason>,
    ) -> Result<BridgeEvent, Reason> {
        let measured = self.in_order(1, arrival.measured(&header.stamp)?)?;
        let odom_from_frame = self.frames.lookup(&self.odom_frame, &header.frame_id, measured.valid_at_ns)?;
        self.people.clear();
        for item in items {
            match decode(item, &odom_from_frame, self.radius) {
                Ok(detection) => self.people.push(detection),
                Err(_) => self.refused_detections += 1,
            }
        }
        let stamp = self.stamp(1, measured, arrival);
        let people = &self.people;
        by_distance(&mut self.order, people.len(), self.robot_m, |index| people[index].position_in_odom_m);
        let kept = people.len().min(MAX_OBSTACLES);
        let mut frame = Detections { stamp, ..Detections::zeroed() };
        frame.count = kept as u32;
        frame.left_out = (people.len() - kept) as u32;
        for (item, &index) in frame.items.iter_mut().zip(&self.order) {
            *item = people[index];
        }
        Ok(BridgeEvent::Detections(frame))
    }

    /// Takes in where the robot shall go. It holds from its arrival on, however long ago somebody wished it, and stays where it
    /// then lies in `odom`.
    ///
    /// # Errors
    /// Why it is refused.
    pub(super) fn goal(&mut self, message: &PoseStamped, arrival: Arrival) -> Result<BridgeEvent, Reason> {
        let source_ns = message.header.stamp.to_ns().unwrap_or(arrival.wall_ns);
        let measured = Measured { valid_at_ns: arrival.stack_ns, source_ns };
        let odom_from_frame =
            self.frames.lookup(&self.odom_frame, &message.header.frame_id, measured.valid_at_ns)?;
        let goal = decode::goal(message, &odom_from_frame)?;
        Ok(BridgeEvent::Goal(Goal { stamp: self.stamp(2, measured, arrival), ..goal }))
    }

    /// Refuses what is older than its predecessor.
    fn in_order(&mut self, stream: usize, measured: Measured) -> Result<Measured, Reason> {
        let newest_ns = self.newest_ns[stream];
        if measured.valid_at_ns + CLOCK_JITTER_NS < newest_ns {
            return Err(Reason::BackwardStamp);
        }
        let valid_at_ns = measured.valid_at_ns.max(newest_ns);
        self.newest_ns[stream] = valid_at_ns;
        Ok(Measured { valid_at_ns, ..measured })
    }

    fn stamp(&mut self, stream: usize, measured: Measured, arrival: Arrival) -> Stamp {
        self.sequences[stream] += 1;
        let Measured { valid_at_ns, source_ns } = measured;
        let sequence = self.sequences[stream];
        Stamp { sequence, source_ns, valid_at_ns, ingress_ns: arrival.stack_ns, published_ns: 0 }
    }
}

#[cfg(test)]
mod tests;
