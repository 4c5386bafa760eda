//! Obstacles drawn as shapes for a viewer: what has been drawn so far and still holds.
//!
//! Cylinders, spheres and cubes are obstacles; arrows, lines, texts and meshes are not. A shape stays until it is drawn anew,
//! deleted, or its lifetime is over, as in a viewer; it stays where it was in `odom`, also if its frame moves on. Meshes and lists
//! of shapes might be people: they are counted as refused, so that somebody hears of it.

use std::collections::BTreeMap;

use messages::{Detection, Reason};
use recording::ros2::{Marker, MarkerArray};

use crate::decode::{self, RadiusRule};
use crate::obstacle_frames::Place;

/// More shapes than any robot sees; what draws ever new ones is broken.
const MOST_SHAPES: usize = 4096;

/// Shapes by namespace and number.
#[derive(Debug, Clone, Default)]
pub(crate) struct Markers {
    shapes: BTreeMap<(String, i32), Shape>,
}

#[derive(Debug, Clone)]
struct Shape {
    detection: Detection,
    /// When its lifetime is over, ns.
    until_ns: u64,
}

impl Markers {
    /// Whether a marker draws something that is an obstacle.
    pub(crate) fn shows(marker: &Marker) -> bool {
        let is_solid = [Marker::CUBE, Marker::SPHERE, Marker::CYLINDER].contains(&marker.r#type);
        marker.action == Marker::ADD && is_solid
    }

    /// Whether a marker may be somebody drawn in a way that is not read: lists of shapes and of points, meshes.
    fn may_hide(marker: &Marker) -> bool {
        (Marker::CUBE_LIST..=Marker::POINTS).contains(&marker.r#type)
            || (Marker::MESH_RESOURCE..=Marker::TRIANGLE_LIST).contains(&marker.r#type)
    }

    /// Takes in what is drawn and deleted, in order. Returns how many shapes were refused.
    ///
    /// # Errors
    /// Why the whole message is refused: the frame of a shape is unknown. What came before it in the message has been taken.
    pub(crate) fn take(
        &mut self,
        message: &MarkerArray,
        place: &mut Place<'_>,
        radius: RadiusRule,
        arrival_ns: u64,
    ) -> Result<u64, Reason> {
        let mut refused = 0;
        self.shapes.retain(|_, shape| shape.until_ns > arrival_ns);
        for marker in &message.markers {
            let name = (marker.ns.clone(), marker.id);
            if marker.action == Marker::DELETE_ALL {
                // Of one namespace, if it names one.
                self.shapes.retain(|(namespace, _), _| !marker.ns.is_empty() && *namespace != marker.ns);
            } else if marker.action == Marker::DELETE {
                self.shapes.remove(&name);
            } else if Self::shows(marker) {
                let odom_from_frame = place(&marker.header)?;
                let has_room = self.shapes.len() < MOST_SHAPES || self.shapes.contains_key(&name);
                match decode::marker(marker, &odom_from_frame, radius) {
                    Ok(detection) if has_room => {
                        let until_ns = arrival_ns.saturating_add(lifetime_ns(marker));
                        self.shapes.insert(name, Shape { detection, until_ns });
                    }
                    Ok(_) | Err(_) => refused += 1,
                }
            } else if marker.action == Marker::ADD && Self::may_hide(marker) {
                refused += 1;
            }
        }
        Ok(refused)
    }

    /// What holds at `now_ns`.
    pub(crate) fn alive(&self, now_ns: u64) -> impl Iterator<Item = Detection> {
        self.shapes.values().filter(move |shape| shape.until_ns > now_ns).map(|shape| shape.detection)
    }

    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.shapes.clear();
    }
}

/// How long a shape holds, ns; zero and what makes no sense mean for ever.
fn lifetime_ns(marker: &Marker) -> u64 {
    let seconds = u64::try_from(marker.lifetime.sec).unwrap_or(0);
    let lifetime_ns = seconds * 1_000_000_000 + u64::from(marker.lifetime.nanosec);
    if lifetime_ns == 0 { u64::MAX } else { lifetime_ns }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Isometry3;
    use recording::ros2::{Duration, Quaternion, Vector3};

    const RULE: RadiusRule = RadiusRule { default_m: 0.35, smallest_m: 0.1, largest_m: 1.5 };
    const S: u64 = 1_000_000_000;

    fn shape(ns: &str, id: i32, kind: i32, x: f64) -> Marker {
        let mut marker = Marker { ns: ns.to_owned(), id, r#type: kind, ..Marker::default() };
        marker.pose.position.x = x;
        marker.pose.orientation = Quaternion::from_heading(0.0);
        marker.scale = Vector3 { x: 0.6, y: 0.4, z: 1.8 };
        marker
    }

    fn take(markers: &mut Markers, shapes: Vec<Marker>, now_ns: u64) -> Result<Vec<f64>, Reason> {
        let message = MarkerArray { markers: shapes };
        markers.take(&message, &mut |_| Ok(Isometry3::identity()), RULE, now_ns)?;
        Ok(markers.alive(now_ns).map(|detection| detection.position_in_odom_m[0]).collect())
    }

    #[test]
    fn solids_are_obstacles_and_all_else_is_decoration() {
        let mut markers = Markers::default();
        let kinds = [Marker::CUBE, Marker::SPHERE, Marker::CYLINDER, Marker::ARROW, 4, 9, 10];
        let shapes = (0..).zip(kinds).map(|(at, kind)| shape("a", at, kind, f64::from(at)));
        assert_eq!(take(&mut markers, shapes.collect(), S), Ok(vec![0.0, 1.0, 2.0]));
        let found: Vec<_> = markers.alive(S).collect();
        assert_eq!(found[0].radius_m, 0.3, "half of the longer edge");
        assert!(found.iter().all(|shape| shape.track_id != 0));
        assert_ne!(found[0].track_id, found[1].track_id);
    }

    #[test]
    fn a_shape_holds_until_it_is_drawn_anew_deleted_or_over() {
        let mut markers = Markers::default();
        let mut brief = shape("b", 1, Marker::SPHERE, 7.0);
        brief.lifetime = Duration { sec: 0, nanosec: 500_000_000 };
        assert_eq!(take(&mut markers, vec![shape("a", 1, Marker::CUBE, 1.0), brief], S), Ok(vec![1.0, 7.0]));
        assert_eq!(take(&mut markers, vec![shape("a", 1, Marker::CUBE, 2.0)], S + S / 4), Ok(vec![2.0, 7.0]));
        assert_eq!(take(&mut markers, Vec::new(), 2 * S), Ok(vec![2.0]), "its lifetime is over");
        let mut gone = shape("a", 1, Marker::CUBE, 2.0);
        gone.action = Marker::DELETE;
        let other = shape("c", 1, Marker::CYLINDER, 3.0);
        assert_eq!(take(&mut markers, vec![gone, other], 3 * S), Ok(vec![3.0]));
        let clear = Marker { action: Marker::DELETE_ALL, ..Marker::default() };
        let drawn = shape("a", 5, Marker::CUBE, 9.0);
        assert_eq!(take(&mut markers, vec![clear, drawn], 4 * S), Ok(vec![9.0]), "in order");
        let clear = Marker { action: Marker::DELETE_ALL, ns: "a".to_owned(), ..Marker::default() };
        let other = shape("b", 5, Marker::CUBE, 8.0);
        assert_eq!(take(&mut markers, vec![other, clear], 5 * S), Ok(vec![8.0]), "of one namespace");
    }

    #[test]
    fn ever_new_and_unsound_shapes_are_refused_and_counted() {
        let mut markers = Markers::default();
        let shapes = (0..).take(MOST_SHAPES + 3).map(|id| shape("", id, Marker::CUBE, 0.0)).collect();
        let refused = |markers: &mut Markers, shapes| {
            let mut place = |_: &_| Ok(Isometry3::identity());
            markers.take(&MarkerArray { markers: shapes }, &mut place, RULE, S)
        };
        assert_eq!(refused(&mut markers, shapes), Ok(3));
        assert_eq!(refused(&mut markers, vec![shape("", 0, Marker::CUBE, f64::NAN)]), Ok(1));
        let kinds = [Marker::ARROW, 4, 5, 6, 7, 8, 9, 10, 11].map(|kind| shape("", 0, kind, 0.0));
        assert_eq!(
            refused(&mut markers, kinds.to_vec()),
            Ok(5),
            "lists of shapes, and meshes, may be somebody"
        );
        let nowhere = markers.take(
            &MarkerArray { markers: vec![shape("", 1, 1, 0.0)] },
            &mut |_| Err(Reason::NoTransform),
            RULE,
            S,
        );
        assert_eq!(nowhere, Err(Reason::NoTransform));
    }
}
