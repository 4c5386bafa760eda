//! Every ROS 2 message that says where obstacles are, in one table.
//!
//! A new one is a line in `for_each_obstacle_message!`, its variant in `settings::ObstacleMessage` and in
//! `recording::RecordedKind`, and the decoding of one of its items in [`crate::decode`]. Live topics and recordings both go
//! through [`ObstacleFrame`].

use messages::{Detection, Reason};
use nalgebra::Isometry3;
use recording::RecordedKind;
use recording::ros2::{self, Header};

use crate::decode::{self, RadiusRule};
use crate::markers::Markers;

/// Calls a macro with the whole table: the name in the settings, the message, its variant among recorded ones. What knows
/// velocities comes before what knows identities, that before mere positions; shapes for viewers come last.
macro_rules! for_each_obstacle_message {
    ($callback:ident) => {
        $callback! {
            TrackedObjects, recording::ros2::TrackedObjects, Tracked;
            DerivedObjects, recording::ros2::ObjectArray, Objects;
            People, recording::ros2::People, People;
            Agents, recording::ros2::Agents, Agents;
            AgentsOfHunav1, recording::ros2::hunav1::Agents, AgentsOfHunav1;
            DynamicObstacles, recording::ros2::ObstacleArray, DynamicObstacles;
            Detection3DArray, recording::ros2::Detection3DArray, Detections;
            PoseArray, recording::ros2::PoseArray, Poses;
            MarkerArray, recording::ros2::MarkerArray, Markers
        }
    };
}
pub(crate) use for_each_obstacle_message;

/// Finds where a header's frame lies in `odom` at the time of its stamp.
pub(crate) type Place<'a> = dyn FnMut(&Header) -> Result<Isometry3<f64>, Reason> + 'a;

/// What a frame is decoded with, and into.
pub(crate) struct Scene<'a> {
    /// Where frames lie.
    pub(crate) place: &'a mut Place<'a>,
    /// How extents become radii.
    pub(crate) radius: RadiusRule,
    /// What was drawn before and still holds.
    pub(crate) markers: &'a mut Markers,
    /// When the message arrived, ns on any clock that runs forwards.
    pub(crate) arrival_ns: u64,
    /// Where the obstacles go.
    pub(crate) people: &'a mut Vec<Detection>,
    /// Items refused so far.
    pub(crate) refused: u64,
}

impl Scene<'_> {
    /// Decodes items of one header.
    fn take<T>(
        &mut self,
        header: &Header,
        items: &[T],
        decode: impl Fn(&T, &Isometry3<f64>, RadiusRule) -> Result<Detection, Reason>,
    ) -> Result<(), Reason> {
        let odom_from_frame = (self.place)(header)?;
        for item in items {
            self.note(decode(item, &odom_from_frame, self.radius));
        }
        Ok(())
    }

    /// Keeps what is sound and counts what is not.
    fn note(&mut self, decoded: Result<Detection, Reason>) {
        match decoded {
            Ok(detection) => self.people.push(detection),
            Err(_) => self.refused += 1,
        }
    }
}

/// A message that says where obstacles are at one moment.
pub(crate) trait ObstacleFrame {
    /// When, and in which frame; `None` if it does not say.
    fn header(&self) -> Option<&Header>;

    /// Appends the obstacles to the scene.
    ///
    /// # Errors
    /// Why the whole frame is refused.
    fn decode(&self, scene: &mut Scene<'_>) -> Result<(), Reason>;
}

macro_rules! frames_with_one_header {
    ($($message:ty: $items:ident by $decode:path;)+) => {$(
        impl ObstacleFrame for $message {
            fn header(&self) -> Option<&Header> {
                Some(&self.header)
            }
            fn decode(&self, scene: &mut Scene<'_>) -> Result<(), Reason> {
                scene.take(&self.header, &self.$items, $decode)
            }
        }
    )+};
}

frames_with_one_header! {
    ros2::TrackedObjects: objects by decode::tracked;
    ros2::People: people by decode::person;
    ros2::Agents: agents by decode::agent;
    ros2::hunav1::Agents: agents by decode::agent_of_hunav1;
    ros2::ObstacleArray: obstacles by decode::dynamic_obstacle;
    ros2::Detection3DArray: detections by decode::detection;
    ros2::PoseArray: poses by decode::anonymous;
}

impl ObstacleFrame for ros2::ObjectArray {
    fn header(&self) -> Option<&Header> {
        Some(&self.header)
    }

    /// Objects may lie in frames of their own; those that name none lie in the array's.
    fn decode(&self, scene: &mut Scene<'_>) -> Result<(), Reason> {
        let odom_from_array = (scene.place)(&self.header);
        for object in &self.objects {
            let is_own = !object.header.frame_id.is_empty() && object.header.frame_id != self.header.frame_id;
            let odom_from_frame = if is_own { (scene.place)(&object.header) } else { odom_from_array };
            // A frame of which nothing is known costs the whole message, as with the others: the obstacle is there.
            scene.note(decode::object(object, &odom_from_frame?, scene.radius));
        }
        odom_from_array.map(|_| ())
    }
}

impl ObstacleFrame for ros2::MarkerArray {
    /// That of the newest marker that shows something.
    fn header(&self) -> Option<&Header> {
        let shown = self.markers.iter().filter(|marker| Markers::shows(marker));
        shown.map(|marker| &marker.header).max_by_key(|header| (header.stamp.sec, header.stamp.nanosec))
    }

    fn decode(&self, scene: &mut Scene<'_>) -> Result<(), Reason> {
        scene.refused += scene.markers.take(self, scene.place, scene.radius, scene.arrival_ns)?;
        scene.people.extend(scene.markers.alive(scene.arrival_ns));
        Ok(())
    }
}

macro_rules! recorded_frames {
    ($($name:ident, $message:ty, $variant:ident);+) => {
        /// A recorded message as a frame of obstacles, if it is one.
        pub(crate) fn recorded(kind: &RecordedKind) -> Option<&dyn ObstacleFrame> {
            match kind {
                $(RecordedKind::$variant(message) => Some(&**message),)+
                _ => None,
            }
        }

        /// Names of the messages as recordings carry them, old style and new, best first.
        pub(crate) fn recorded_types() -> Vec<[String; 2]> {
            vec![$([<$message as ros2::Ros2Message>::type_name(), <$message as ros2::Ros2Message>::NAME.to_owned()]),+]
        }
    };
}
for_each_obstacle_message!(recorded_frames);
