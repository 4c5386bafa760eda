//! Coordinate frames over time: which lies where in which, by `/tf`, `/tf_static` and odometry.

use std::collections::HashMap;

use messages::Reason;
use nalgebra::Isometry3;

/// Longer chains than any robot has; a tree that bites its tail ends here.
const MAX_CHAIN: usize = 64;

/// More frames than any robot has; what names ever new ones is broken.
const MAX_FRAMES: usize = 1024;

/// A frame on the way up, with the transform into it unless a measurement on the way is too old.
type Ancestor<'a> = (&'a str, Option<Isometry3<f64>>);

/// A child frame in its parent.
#[derive(Debug, Clone)]
struct Edge {
    parent: String,
    is_static: bool,
    /// Times, ns, and transforms that take coordinates in the child to coordinates in the parent, in order of time.
    samples: Vec<(u64, Isometry3<f64>)>,
}

/// Transforms between frames, each with the time it was measured.
///
/// Between two measurements a transform is interpolated; before the first and after the last, the nearest one serves as
/// long as it is not too old.
#[derive(Debug, Clone)]
pub struct Frames {
    edges: HashMap<String, Edge>,
    max_age_ns: u64,
}

impl Frames {
    /// No frames yet; measurements may be used up to `max_age_ns` away from their time.
    pub fn new(max_age_ns: u64) -> Self {
        Self { edges: HashMap::new(), max_age_ns }
    }

    /// Whether the place of `child` in another frame is known at some time.
    pub fn knows(&self, child: &str) -> bool {
        self.edges.contains_key(plain(child))
    }

    /// Forgets where `child` lies in another frame.
    pub fn remove(&mut self, child: &str) {
        self.edges.remove(plain(child));
    }

    /// Forgets where moving frames were: the clock has jumped. Static ones, which nobody says again, remain.
    pub fn forget_moving(&mut self) {
        self.edges.values_mut().filter(|edge| !edge.is_static).for_each(|edge| edge.samples.clear());
    }

    /// Forgets measurements before `time_ns`, but of each frame the newest: for who listens without end.
    pub fn forget_before(&mut self, time_ns: u64) {
        for edge in self.edges.values_mut() {
            let old = edge.samples.partition_point(|(sample_ns, _)| *sample_ns < time_ns);
            edge.samples.drain(..old.min(edge.samples.len().saturating_sub(1)));
        }
    }

    /// Takes in where `child` lay in `parent` at `time_ns`; a static transform holds at any time,
    /// and one said again replaces itself. The first parent and kind of a child are kept: one stray transform must not cost
    /// all those measured before it.
    ///
    /// # Errors
    /// [`Reason::MalformedInput`] if a frame has no name or is its own parent, or if the child is known under another parent
    /// or as the other kind, static or moving. [`Reason::CapacityExceeded`] if there are more frames than any robot has.
    pub fn insert(
        &mut self,
        parent: &str,
        child: &str,
        time_ns: u64,
        parent_from_child: Isometry3<f64>,
        is_static: bool,
    ) -> Result<(), Reason> {
        let (parent, child) = (plain(parent), plain(child));
        if parent.is_empty() || child.is_empty() || parent == child {
            return Err(Reason::MalformedInput);
        }
        if self.edges.len() >= MAX_FRAMES && !self.edges.contains_key(child) {
            return Err(Reason::CapacityExceeded);
        }
        let edge = self.edges.entry(child.to_owned()).or_insert_with(|| Edge {
            parent: parent.to_owned(),
            is_static,
            samples: Vec::new(),
        });
        if edge.parent != parent || edge.is_static != is_static {
            return Err(Reason::MalformedInput);
        }
        if is_static {
            edge.samples.clear();
        }
        let at = edge.samples.partition_point(|(sample_ns, _)| *sample_ns <= time_ns);
        edge.samples.insert(at, (time_ns, parent_from_child));
        Ok(())
    }

    /// The transform that takes coordinates in `source` to coordinates in `target` at `time_ns`.
    ///
    /// # Errors
    /// [`Reason::NoTransform`] if the two frames are not connected or a measurement on the way is too old.
    pub fn lookup(&self, target: &str, source: &str, time_ns: u64) -> Result<Isometry3<f64>, Reason> {
        let to_root = self.chain(plain(source), time_ns)?;
        let target_chain = self.chain(plain(target), time_ns)?;
        // The first frame on the source's way up that the target's way meets, too.
        for (frame, frame_from_source) in &to_root {
            if let Some((_, frame_from_target)) = target_chain.iter().find(|(other, _)| other == frame) {
                return match (frame_from_source, frame_from_target) {
                    (Some(from_source), Some(from_target)) => Ok(from_target.inverse() * from_source),
                    (None, _) | (_, None) => Err(Reason::NoTransform),
                };
            }
        }
        Err(Reason::NoTransform)
    }

    /// Whether `child` moves in `frame`: whether that one lies above it, with a transform between them that is not static.
    pub fn moves_in(&self, child: &str, frame: &str) -> bool {
        let (mut at, mut moves) = (plain(child), false);
        for _ in 0..MAX_CHAIN {
            let Some(edge) = self.edges.get(at) else { return false };
            moves |= !edge.is_static;
            at = &edge.parent;
            if at == plain(frame) {
                return moves;
            }
        }
        false
    }

    /// Every frame from `frame` up to its root.
    fn chain<'a>(&'a self, frame: &'a str, time_ns: u64) -> Result<Vec<Ancestor<'a>>, Reason> {
        let mut chain = vec![(frame, Some(Isometry3::identity()))];
        let (mut at, mut at_from_frame) = (frame, Some(Isometry3::identity()));
        while let Some(edge) = self.edges.get(at) {
            if chain.len() > MAX_CHAIN {
                return Err(Reason::NoTransform);
            }
            at_from_frame = edge
                .at(time_ns, self.max_age_ns)
                .zip(at_from_frame)
                .map(|(parent_from_child, child_from_frame)| parent_from_child * child_from_frame);
            at = &edge.parent;
            chain.push((at, at_from_frame));
        }
        Ok(chain)
    }
}

impl Edge {
    /// Transform at `time_ns`; `None` if the nearest measurement is too far away.
    fn at(&self, time_ns: u64, max_age_ns: u64) -> Option<Isometry3<f64>> {
        let next = self.samples.partition_point(|(sample_ns, _)| *sample_ns <= time_ns);
        let before = next.checked_sub(1).and_then(|index| self.samples.get(index));
        let near =
            |sample: &&(u64, Isometry3<f64>)| self.is_static || sample.0.abs_diff(time_ns) <= max_age_ns;
        match (before.filter(near), self.samples.get(next).filter(near)) {
            (Some((before_ns, before)), Some((after_ns, after))) => {
                let share = (time_ns - before_ns) as f64 / (after_ns - before_ns) as f64;
                // Half a turn between two measurements has no shortest way; the nearer one then serves.
                let nearer = if share < 0.5 { before } else { after };
                Some(before.try_lerp_slerp(after, share, 1e-9).unwrap_or(*nearer))
            }
            (Some((_, only)), None) | (None, Some((_, only))) => Some(*only),
            (None, None) => None,
        }
    }
}

/// A frame's name without the leading slash of ROS 1.
pub(crate) fn plain(frame: &str) -> &str {
    frame.strip_prefix('/').unwrap_or(frame)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Translation3, UnitQuaternion, Vector3};

    const MS: u64 = 1_000_000;

    fn at(x: f64, y: f64, heading_rad: f64) -> Isometry3<f64> {
        let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), heading_rad);
        Isometry3::from_parts(Translation3::new(x, y, 0.0), rotation)
    }

    fn tree() -> Frames {
        let mut frames = Frames::new(100 * MS);
        let mut insert = |parent: &str, child: &str, time_ns: u64, transform, is_static| {
            frames.insert(parent, child, time_ns, transform, is_static).expect("well-formed");
        };
        insert("map", "odom", 1_000 * MS, at(5.0, 0.0, 0.0), true);
        insert("odom", "base_link", 1_100 * MS, at(2.0, 0.0, 1.0), false);
        insert("odom", "base_link", 1_000 * MS, at(1.0, 0.0, 0.0), false);
        insert("base_link", "/laser", 0, at(0.5, 0.0, 0.0), true);
        frames
    }

    fn place(frames: &Frames, target: &str, source: &str, time_ns: u64) -> Result<[f64; 2], Reason> {
        let found = frames.lookup(target, source, time_ns)?;
        Ok([found.translation.x, found.translation.y])
    }

    #[test]
    fn a_frame_moves_in_those_above_it_beyond_a_transform_that_moves() {
        let frames = tree();
        assert!(frames.moves_in("base_link", "odom") && frames.moves_in("laser", "/map"));
        for (child, frame) in
            [("laser", "base_link"), ("base_link", "base_link"), ("odom", "map"), ("base_link", "radar")]
        {
            assert!(!frames.moves_in(child, frame), "{child} in {frame}");
        }
    }

    #[test]
    fn chains_go_up_and_down_and_transforms_are_interpolated() {
        let frames = tree();
        assert_eq!(
            place(&frames, "odom", "odom", 7),
            Ok([0.0, 0.0]),
            "a frame needs nothing to be in itself"
        );
        assert_eq!(place(&frames, "odom", "laser", 1_000 * MS), Ok([1.5, 0.0]));
        assert_eq!(place(&frames, "odom", "map", 1_000 * MS), Ok([-5.0, 0.0]));
        let [x, y] = place(&frames, "map", "laser", 1_050 * MS).expect("known");
        assert!((x - (6.5 + 0.5 * 0.5_f64.cos())).abs() < 1e-12 && (y - 0.5 * 0.5_f64.sin()).abs() < 1e-12);
    }

    #[test]
    fn old_and_unknown_transforms_are_refused() {
        let frames = tree();
        assert_eq!(place(&frames, "odom", "laser", 1_200 * MS).map(|_| ()), Ok(()));
        assert_eq!(place(&frames, "odom", "laser", 1_201 * MS), Err(Reason::NoTransform));
        assert_eq!(place(&frames, "odom", "laser", 899 * MS), Err(Reason::NoTransform));
        assert_eq!(place(&frames, "odom", "camera", 1_000 * MS), Err(Reason::NoTransform));
        assert_eq!(
            place(&frames, "base_link", "laser", 9_000 * MS),
            Ok([0.5, 0.0]),
            "the old part is not needed"
        );
    }

    #[test]
    fn one_deviating_transform_is_refused_and_costs_nothing() {
        let mut frames = tree();
        let other = at(9.0, 9.0, 0.0);
        let malformed = Err(Reason::MalformedInput);
        assert_eq!(frames.insert("map", "base_link", 1_050 * MS, other, false), malformed, "parent");
        assert_eq!(frames.insert("odom", "base_link", 1_050 * MS, other, true), malformed, "kind");
        assert_eq!(frames.insert("base_link", "laser", 1_050 * MS, other, false), malformed, "kind");
        assert_eq!(place(&frames, "odom", "laser", 1_000 * MS), Ok([1.5, 0.0]));
        // A static transform said again replaces itself.
        frames.insert("base_link", "laser", 5, at(0.7, 0.0, 0.0), true).expect("well-formed");
        assert_eq!(place(&frames, "odom", "laser", 1_000 * MS), Ok([1.7, 0.0]));
    }

    #[test]
    fn what_is_old_is_forgotten_but_the_newest_stays() {
        let mut frames = tree();
        frames.forget_before(1_050 * MS);
        assert_eq!(
            place(&frames, "odom", "base_link", 1_040 * MS),
            Ok([2.0, 0.0]),
            "only the later one is left"
        );
        frames.forget_before(9_000 * MS);
        assert_eq!(
            place(&frames, "odom", "map", 9_000 * MS),
            Ok([-5.0, 0.0]),
            "static frames hold at any time"
        );
        assert_eq!(place(&frames, "odom", "base_link", 1_100 * MS), Ok([2.0, 0.0]));
        frames.forget_moving();
        assert_eq!(place(&frames, "odom", "base_link", 1_100 * MS), Err(Reason::NoTransform));
        assert_eq!(place(&frames, "base_link", "laser", 1_100 * MS), Ok([0.5, 0.0]));
        frames.remove("base_link");
        assert_eq!(place(&frames, "odom", "base_link", 1_100 * MS), Err(Reason::NoTransform));
    }

    #[test]
    fn ever_new_frames_are_refused() {
        let mut frames = Frames::new(MS);
        for number in 0..MAX_FRAMES {
            frames.insert("odom", &format!("f{number}"), 0, at(0.0, 0.0, 0.0), true).expect("room");
        }
        let more = |frames: &mut Frames, name: &str| frames.insert("odom", name, 1, at(1.0, 0.0, 0.0), true);
        assert_eq!(more(&mut frames, "one_more"), Err(Reason::CapacityExceeded));
        assert_eq!(more(&mut frames, "f7"), Ok(()));
    }

    #[test]
    fn loops_and_nameless_frames_are_refused() {
        let mut frames = Frames::new(MS);
        assert!(frames.insert("a", "a", 0, at(0.0, 0.0, 0.0), true).is_err());
        assert!(frames.insert("", "a", 0, at(0.0, 0.0, 0.0), true).is_err());
        frames.insert("a", "b", 0, at(1.0, 0.0, 0.0), true).expect("well-formed");
        frames.insert("b", "a", 0, at(1.0, 0.0, 0.0), true).expect("each alone is well-formed");
        assert_eq!(place(&frames, "c", "a", 0), Err(Reason::NoTransform));
    }
}
