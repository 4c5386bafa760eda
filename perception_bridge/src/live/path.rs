//! Following a path: the next point to drive to, a stretch ahead of where the robot is on it.
//!
//! The robot's progress only grows, so that a path that crosses itself is followed the way it was meant.

/// The point ahead is said again once it has moved this far along the path, m.
const STEP_M: f64 = 0.05;
/// Progress is looked for this many lookaheads beyond the last one.
const REACH: f64 = 2.0;

/// A place to drive to: `[x, y]`, m, and the heading there, rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Waypoint {
    pub(super) position_m: [f64; 2],
    pub(super) heading_rad: f64,
}

/// A path that is followed, all in one frame.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Route {
    /// No two neighbours are equal; at least one point.
    points_m: Vec<[f64; 2]>,
    /// Length of the path up to each point, m.
    along_m: Vec<f64>,
    /// Heading at the end, rad, if it was given.
    last_heading_rad: Option<f64>,
    /// How far the robot has come, m; unknown before it was seen.
    progress_m: Option<f64>,
    /// How far along the path the point lies that was said last, m.
    said_m: Option<f64>,
}

impl Route {
    /// A path through these points, m, none of which may be missing a number; `None` if there are none.
    pub(super) fn through(points_m: &[[f64; 2]], last_heading_rad: Option<f64>) -> Option<Self> {
        let mut route = Self {
            points_m: vec![*points_m.first()?],
            along_m: vec![0.0],
            last_heading_rad,
            progress_m: None,
            said_m: None,
        };
        for point in points_m {
            let length_m = route.last_point().map_or(0.0, |last| distance_m(last, *point));
            if length_m > 0.0 {
                route.along_m.push(route.length_m() + length_m);
                route.points_m.push(*point);
            }
        }
        Some(route)
    }

    /// The same way from the beginning: nothing is known of the robot any more.
    pub(super) fn begin_anew(&mut self) {
        (self.progress_m, self.said_m) = (None, None);
    }

    /// Where to drive from `robot_m`, if that has changed since the last time. At the end the heading is the one given, or the
    /// path's own, or `heading_rad` where it has none.
    pub(super) fn follow(
        &mut self,
        robot_m: [f64; 2],
        heading_rad: f64,
        lookahead_m: f64,
    ) -> Option<Waypoint> {
        let (from_m, to_m) = match self.progress_m {
            None => (0.0, self.length_m()),
            Some(progress_m) => (progress_m, progress_m + REACH * lookahead_m),
        };
        let progress_m = self.nearest_m(robot_m, from_m, to_m);
        self.progress_m = Some(progress_m);
        let ahead_m = (progress_m + lookahead_m).min(self.length_m());
        let is_news = match self.said_m {
            None => true,
            Some(said_m) => ahead_m - said_m >= STEP_M || (ahead_m >= self.length_m() && said_m < ahead_m),
        };
        is_news.then(|| {
            self.said_m = Some(ahead_m);
            self.at(ahead_m, heading_rad)
        })
    }

    /// Length of the way to the point on it that is nearest to `robot_m`, among those from `from_m` to `to_m`, m.
    fn nearest_m(&self, robot_m: [f64; 2], from_m: f64, to_m: f64) -> f64 {
        let mut nearest = (f64::INFINITY, from_m);
        for (points, along) in self.points_m.windows(2).zip(self.along_m.windows(2)) {
            let (&[a, b], &[begin_m, end_m]) = (points, along) else { continue };
            if end_m < from_m || begin_m > to_m {
                continue;
            }
            let length_m = end_m - begin_m;
            let direction = [(b[0] - a[0]) / length_m, (b[1] - a[1]) / length_m];
            let reach_m = (robot_m[0] - a[0]) * direction[0] + (robot_m[1] - a[1]) * direction[1];
            let share_m = (begin_m + reach_m).clamp(begin_m.max(from_m), end_m.min(to_m)) - begin_m;
            let place = [a[0] + share_m * direction[0], a[1] + share_m * direction[1]];
            let off_m = distance_m(robot_m, place);
            if off_m < nearest.0 {
                nearest = (off_m, begin_m + share_m);
            }
        }
        nearest.1
    }

    /// The point after `along_m` metres.
    fn at(&self, along_m: f64, heading_rad: f64) -> Waypoint {
        let next = self.along_m.partition_point(|length_m| *length_m < along_m).max(1);
        let ends = self.points_m.get(next - 1).zip(self.points_m.get(next));
        let Some((&[ax, ay], &[bx, by])) = ends else {
            let position_m = self.last_point().unwrap_or_default();
            return Waypoint { position_m, heading_rad: self.last_heading_rad.unwrap_or(heading_rad) };
        };
        let along_rad = (by - ay).atan2(bx - ax);
        let share = (along_m - self.along_m[next - 1]) / (self.along_m[next] - self.along_m[next - 1]);
        let position_m = [ax + share * (bx - ax), ay + share * (by - ay)];
        let is_end = along_m >= self.length_m();
        let heading_rad = if is_end { self.last_heading_rad.unwrap_or(along_rad) } else { along_rad };
        Waypoint { position_m, heading_rad }
    }

    fn length_m(&self) -> f64 {
        self.along_m.last().copied().unwrap_or(0.0)
    }

    fn last_point(&self) -> Option<[f64; 2]> {
        self.points_m.last().copied()
    }
}

fn distance_m([ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> f64 {
    (ax - bx).hypot(ay - by)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn follow(route: &mut Route, x: f64, y: f64) -> Option<Waypoint> {
        route.follow([x, y], 0.3, 1.5)
    }

    #[test]
    fn the_point_ahead_moves_with_the_robot_to_the_end_and_its_heading() {
        // With a point twice in a row, as planners send them.
        let mut route =
            Route::through(&[[0.0, 0.0], [4.0, 0.0], [4.0, 0.0], [4.0, 3.0]], Some(1.0)).expect("points");
        let first = follow(&mut route, 0.2, 0.4).expect("news");
        assert_eq!(first, Waypoint { position_m: [1.7, 0.0], heading_rad: 0.0 });
        assert_eq!(follow(&mut route, 0.21, 0.4), None, "hardly moved");
        assert_eq!(follow(&mut route, 0.1, 0.4), None, "never back");
        assert!(follow(&mut route, 2.5, 0.1).is_some());
        let around = follow(&mut route, 3.5, 0.1).expect("news");
        assert_eq!(around, Waypoint { position_m: [4.0, 1.0], heading_rad: FRAC_PI_2 });
        let end = follow(&mut route, 4.0, 2.0).expect("news");
        assert_eq!(end, Waypoint { position_m: [4.0, 3.0], heading_rad: 1.0 });
        assert_eq!(follow(&mut route, 4.0, 2.9), None, "the end stays the end");
    }

    #[test]
    fn a_path_that_crosses_itself_is_followed_the_way_it_was_meant() {
        let eight = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 4.0], [2.0, -4.0]];
        let mut route = Route::through(&eight, None).expect("points");
        follow(&mut route, 1.0, 0.0);
        // The crossing at (2, 0) belongs to the first stretch now, and to the last one later.
        assert_eq!(follow(&mut route, 2.0, 0.0).map(|point| point.position_m), Some([3.5, 0.0]));
        for (x, y) in [(4.0, 0.0), (4.0, 2.5), (3.5, 4.0), (2.0, 3.5), (2.0, 1.5)] {
            assert!(follow(&mut route, x, y).is_some());
        }
        assert_eq!(follow(&mut route, 2.0, 0.0).map(|point| point.position_m), Some([2.0, -1.5]));
    }

    #[test]
    fn a_robot_that_joins_a_path_midway_is_not_sent_back() {
        let mut route = Route::through(&[[0.0, 0.0], [10.0, 0.0]], None).expect("points");
        assert_eq!(follow(&mut route, 6.0, 0.5).map(|point| point.position_m), Some([7.5, 0.0]));
        route.begin_anew();
        assert_eq!(follow(&mut route, 1.0, 0.0).map(|point| point.position_m), Some([2.5, 0.0]));
    }

    #[test]
    fn one_point_is_a_path_and_none_is_not() {
        let mut route = Route::through(&[[2.0, 1.0]], None).expect("a point");
        assert_eq!(follow(&mut route, 0.0, 0.0), Some(Waypoint { position_m: [2.0, 1.0], heading_rad: 0.3 }));
        assert_eq!(follow(&mut route, 1.0, 0.0), None);
        assert_eq!(Route::through(&[], None), None);
    }
}
