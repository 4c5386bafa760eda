//! From live messages to the bridge's events: times, frames and order checked, each refusal with its reason.
//!
//! Knows neither DDS nor threads: messages and their arrival are passed in.

use bytemuck::Zeroable;
use messages::{
    ControlKind, Controller, Detection, Detections, Goal, Intent, MAX_OBSTACLES, NominalCommand, Reason,
    RobotState, Stamp,
};
use recording::ros2::{Clock, Header, Odometry, Path, PoseStamped, TFMessage, Time, TransformStamped, Twist};
use settings::{Ros2Settings, Settings};

use super::arrival::{Arrival, Measured};
use super::path::{Route, Waypoint};
use super::timebase::{RosTime, Timebase};
use crate::decode::{self, RadiusRule};
use crate::frames::{Frames, plain};
use crate::markers::Markers;
use crate::nearest::by_distance;
use crate::obstacle_frames::{ObstacleFrame, Scene};
use crate::source::BridgeEvent;

const NS_PER_MS: u64 = 1_000_000;
/// Transforms are kept this long; older stamps are refused anyway, ns.
const MEMORY_NS: u64 = 11_000 * NS_PER_MS;
/// Two clocks read one after the other show equal stamps this far apart, ns.
const CLOCK_JITTER_NS: u64 = 100_000;

/// Messages that are told apart by order and by number.
#[derive(Debug, Clone, Copy)]
enum Stream {
    RobotStates,
    Detections,
    Upstream,
    Goals,
}

/// A path as it was sent: the name of its frame, its points.
type Sent = (String, Vec<[f64; 2]>);

/// What has been taken in so far.
pub(super) struct Intake {
    odom_frame: String,
    radius: RadiusRule,
    frames: Frames,
    /// The robot's frame while only odometry tells where it is.
    placed_by_odometry: Option<String>,
    time: Timebase,
    markers: Markers,
    /// Validity of the newest message of each stream that has an order, ns.
    newest_ns: [u64; 4],
    /// Of each stream.
    sequences: [u64; 4],
    /// The newest one, while there is one of the present time.
    robot: Option<RobotState>,
    /// Where the robot was last seen, m.
    robot_m: [f64; 2],
    /// The frame whose motion odometry tells.
    robot_frame: String,
    /// The path that is followed, as it was sent.
    route: Option<(Route, Sent)>,
    /// Whether the robot shall stay where it is as soon as that is known: there is no path any more.
    halts: bool,
    lookahead_m: f64,
    upstream_silence_ns: u64,
    /// The slowest that the filter can let the robot drive, m/s.
    slowest_mps: f64,
    people: Vec<Detection>,
    order: Vec<usize>,
    refused_detections: u64,
}

impl Intake {
    /// Nothing taken in yet.
    pub(super) fn new(settings: &Settings) -> Self {
        let [smallest_m, largest_m] = settings.source.radius_range_m;
        let ros2 = settings.source.ros2.clone().unwrap_or_else(Ros2Settings::customary);
        Self {
            odom_frame: settings.source.odom_frame.clone(),
            radius: RadiusRule { default_m: settings.obstacle.radius_m, smallest_m, largest_m },
            frames: Frames::new(settings.source.max_transform_age_ms * NS_PER_MS),
            placed_by_odometry: None,
            time: Timebase::new(ros2.uses_sim_time()),
            markers: Markers::default(),
            newest_ns: [0; 4],
            sequences: [0; 4],
            robot: None,
            robot_m: [0.0; 2],
            robot_frame: String::new(),
            route: None,
            halts: false,
            lookahead_m: ros2.lookahead_m(),
            slowest_mps: settings.robot.control_min[0],
            upstream_silence_ns: settings.filter.nominal_max_silence_ms * NS_PER_MS,
            people: Vec::new(),
            order: Vec::new(),
            refused_detections: 0,
        }
    }

    /// Single detections refused within frames that were used.
    pub(super) const fn refused_detections(&self) -> u64 {
        self.refused_detections
    }

    /// What messages of this stack are to be stamped with.
    pub(super) fn ros_time(&self) -> RosTime {
        self.time.ros_time()
    }

    /// Takes in what a simulation's clock shows.
    ///
    /// # Errors
    /// Why it is refused. After [`Reason::ClockJump`] everything begins anew.
    pub(super) fn clock(&mut self, message: &Clock, arrival: Arrival) -> Result<(), Reason> {
        let taken = self.time.take_clock(message, arrival);
        if taken == Err(Reason::ClockJump) {
            self.begin_anew();
        }
        taken
    }

    /// When a message was measured. After a jump of the date everything begins anew.
    fn measured(&mut self, stamp: &Time, arrival: Arrival) -> Result<Measured, Reason> {
        if let Err(reason) = self.time.watch_date(arrival) {
            self.begin_anew();
            return Err(reason);
        }
        self.time.measured(stamp, arrival)
    }

    /// Forgets what holds for another time: where frames were, what was drawn, in which order messages came. The goal and the
    /// path, which are places, remain.
    fn begin_anew(&mut self) {
        self.frames.forget_moving();
        self.markers.clear();
        self.newest_ns = [0; 4];
        self.robot = None;
        if let Some((route, _)) = &mut self.route {
            route.begin_anew();
        }
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
            if is_static { arrival.stack_ns } else { self.measured(&one.header.stamp, arrival)?.valid_at_ns };
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
        let measured = self.measured(&message.header.stamp, arrival)?;
        let measured = self.in_order(Stream::RobotStates, measured)?;
        self.place_robot(message, measured)?;
        let odom_from_frame =
            self.frames.lookup(&self.odom_frame, &message.header.frame_id, measured.valid_at_ns)?;
        let state = decode::odometry(message, &odom_from_frame)?;
        let state = RobotState { stamp: self.stamp(Stream::RobotStates, measured, arrival), ..state };
        if self.robot_frame != message.child_frame_id {
            self.robot_frame.clone_from(&message.child_frame_id);
        }
        self.robot_m = state.position_in_odom_m;
        self.robot = Some(state);
        Ok(BridgeEvent::RobotState(state))
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

    /// Takes in obstacles.
    ///
    /// # Errors
    /// Why the whole frame is refused.
    pub(super) fn obstacles(
        &mut self,
        message: &dyn ObstacleFrame,
        arrival: Arrival,
    ) -> Result<BridgeEvent, Reason> {
        let unstamped = Time::default();
        let measured = self.measured(message.header().map_or(&unstamped, |header| &header.stamp), arrival)?;
        let measured = self.in_order(Stream::Detections, measured)?;
        self.people.clear();
        let mut scene = Scene {
            place: &mut |header: &Header| {
                let valid_at_ns = self.time.measured(&header.stamp, arrival)?.valid_at_ns;
                self.frames.lookup(&self.odom_frame, &header.frame_id, valid_at_ns)
            },
            radius: self.radius,
            markers: &mut self.markers,
            arrival_ns: arrival.stack_ns,
            people: &mut self.people,
            refused: 0,
        };
        let decoded = message.decode(&mut scene);
        self.refused_detections += scene.refused;
        decoded?;
        let stamp = self.stamp(Stream::Detections, measured, arrival);
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
    /// then lies in `odom`. A path is no longer followed.
    ///
    /// # Errors
    /// Why it is refused; the path is then followed on.
    pub(super) fn goal(&mut self, message: &PoseStamped, arrival: Arrival) -> Result<BridgeEvent, Reason> {
        let odom_from_frame =
            self.frames.lookup(&self.odom_frame, &message.header.frame_id, arrival.stack_ns)?;
        let goal = decode::goal(message, &odom_from_frame)?;
        (self.route, self.halts) = (None, false);
        let place = Waypoint { position_m: goal.position_in_odom_m, heading_rad: goal.heading_rad };
        Ok(self.goal_event(place, message.header.stamp.to_ns(), arrival))
    }

    /// Takes in a path to follow, in place of goal and path before. The same one again is followed on. An empty one sends the
    /// robot where it is: planners say so that they have none.
    ///
    /// # Errors
    /// Why it is refused; what was followed before is then followed on.
    pub(super) fn path(&mut self, message: &Path, arrival: Arrival) -> Result<Option<BridgeEvent>, Reason> {
        let places = message.poses.iter().map(|pose| &pose.pose.position);
        let as_sent = (
            message.header.frame_id.clone(),
            places.clone().map(|place| [place.x, place.y]).collect::<Vec<_>>(),
        );
        if self.route.as_ref().is_some_and(|(_, before)| *before == as_sent) {
            return Ok(None);
        }
        let frame = &message.header.frame_id;
        let odom_from_frame = self.frames.lookup(&self.odom_frame, frame, arrival.stack_ns)?;
        let points_m: Vec<_> = places.map(|place| decode::place(place, &odom_from_frame)).collect();
        if !points_m.as_flattened().iter().all(|value| value.is_finite()) {
            return Err(Reason::MalformedInput);
        }
        let last_heading_rad = message
            .poses
            .last()
            .and_then(|last| Some(decode::goal(last, &odom_from_frame).ok()?.heading_rad));
        self.route = Route::through(&points_m, last_heading_rad).map(|route| (route, as_sent));
        self.halts = self.route.is_none();
        Ok(self.next_waypoint(arrival))
    }

    /// Where the path leads from the newest robot state, if that has changed; where the robot is, once there is no path any more.
    pub(super) fn next_waypoint(&mut self, arrival: Arrival) -> Option<BridgeEvent> {
        let robot = self.robot?;
        if std::mem::take(&mut self.halts) {
            let RobotState { position_in_odom_m: position_m, heading_rad, .. } = robot;
            return Some(self.goal_event(Waypoint { position_m, heading_rad }, None, arrival));
        }
        let (route, _) = self.route.as_mut()?;
        let place = route.follow(robot.position_in_odom_m, robot.heading_rad, self.lookahead_m)?;
        Some(self.goal_event(place, None, arrival))
    }

    fn goal_event(&mut self, place: Waypoint, source_ns: Option<u64>, arrival: Arrival) -> BridgeEvent {
        let source_ns = source_ns.unwrap_or(arrival.wall_ns);
        let measured = Measured { valid_at_ns: arrival.stack_ns, source_ns };
        let Waypoint { position_m, heading_rad } = place;
        let stamp = self.stamp(Stream::Goals, measured, arrival);
        BridgeEvent::Goal(Goal { stamp, position_in_odom_m: position_m, heading_rad })
    }

    /// Takes in what the robot's own controller commands. Sideways speed is left out: this robot cannot. Nothing but zeros means to
    /// stop, whatever the robot could do to get out of somebody's way. Where the robot can only drive forwards, slower than its
    /// slowest means that, too: the filter would make it faster than anybody asked.
    ///
    /// # Errors
    /// Why it is refused: [`Reason::NoRobotState`] while there is nothing that it could answer, [`Reason::NoTransform`] if it is
    /// meant in a frame in which the robot moves, [`Reason::NonFiniteNominalCommand`], [`Reason::StaleNominalCommand`] if its
    /// stamp is older than the filter lets a nominal controller be silent.
    pub(super) fn upstream(
        &mut self,
        twist: &Twist,
        header: Option<&Header>,
        arrival: Arrival,
    ) -> Result<BridgeEvent, Reason> {
        let unstamped = Time::default();
        let measured = self.measured(header.map_or(&unstamped, |header| &header.stamp), arrival)?;
        let measured = self.in_order(Stream::Upstream, measured)?;
        if arrival.stack_ns.saturating_sub(measured.valid_at_ns) > self.upstream_silence_ns {
            return Err(Reason::StaleNominalCommand);
        }
        let robot = self.robot.ok_or(Reason::NoRobotState)?;
        if header.is_some_and(|header| self.is_outside(&header.frame_id)) {
            return Err(Reason::NoTransform);
        }
        let control = [twist.linear.x, twist.angular.z];
        if !control.iter().all(|value| value.is_finite()) {
            return Err(Reason::NonFiniteNominalCommand);
        }
        let is_too_slow = self.slowest_mps > 0.0 && twist.linear.x < self.slowest_mps;
        let is_halt = is_too_slow || control == [0.0; 2];
        let intent = if is_halt { Intent::Stop } else { Intent::Drive };
        let answered = Measured { valid_at_ns: robot.stamp.valid_at_ns, source_ns: robot.stamp.source_ns };
        let stamp = self.stamp(Stream::Upstream, answered, arrival);
        Ok(BridgeEvent::NominalCommand(NominalCommand {
            stamp: Stamp { ingress_ns: robot.stamp.ingress_ns, ..stamp },
            received_ns: arrival.stack_ns,
            control,
            control_kind: ControlKind::Unicycle.code(),
            intent: intent.code(),
            controller: Controller::Upstream.code(),
            ..NominalCommand::zeroed()
        }))
    }

    /// Whether a velocity in `frame` is not one in the robot's axes, as far as is known. An empty name means them.
    fn is_outside(&self, frame: &str) -> bool {
        plain(frame) == plain(&self.odom_frame) || self.frames.moves_in(&self.robot_frame, frame)
    }

    /// Refuses what is older than its predecessor.
    fn in_order(&mut self, stream: Stream, measured: Measured) -> Result<Measured, Reason> {
        let newest_ns = self.newest_ns[stream as usize];
        if measured.valid_at_ns + CLOCK_JITTER_NS < newest_ns {
            return Err(Reason::BackwardStamp);
        }
        let valid_at_ns = measured.valid_at_ns.max(newest_ns);
        self.newest_ns[stream as usize] = valid_at_ns;
        Ok(Measured { valid_at_ns, ..measured })
    }

    fn stamp(&mut self, stream: Stream, measured: Measured, arrival: Arrival) -> Stamp {
        self.sequences[stream as usize] += 1;
        let Measured { valid_at_ns, source_ns } = measured;
        let sequence = self.sequences[stream as usize];
        Stamp { sequence, source_ns, valid_at_ns, ingress_ns: arrival.stack_ns, published_ns: 0 }
    }
}

#[cfg(test)]
mod tests;
