//! Scenarios from a recording: its people as tracks, and for the robot a straight way across the busiest place.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;

use crowd_sim::{Motion, Person, Rectangle, RobotStart, Scenario, ScenarioError};
use settings::{ClassName, Settings};

use super::SourceError;
use super::load;
use super::playlist::Playlist;

const S_PER_NS: f64 = 1e-9;
/// People who are not seen for longer than this come back as somebody else, s.
const LONGEST_GAP_S: f64 = 0.5;
/// Who is seen within this time after another sighting is taken for the same one seen twice, s.
const LEAST_GAP_S: f64 = 1e-3;
/// Directions tried for the way, over half a turn.
const DIRECTIONS: u32 = 12;
/// Radius of the place whose people are counted, m.
const PLACE_M: f64 = 2.0;
/// Distance within which somebody counts as met on the way, m.
const MET_M: f64 = 1.0;

/// How scenarios are cut out of a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordedCrowd {
    /// Time between the starts of two scenarios, s.
    pub every_s: f64,
    /// Length of the robot's way, m.
    pub way_m: f64,
    /// Time that the robot is expected to take, s. The busiest place is the one of this time, and no scenario begins later than
    /// this before the end of the recording.
    pub crossing_s: f64,
    /// Time after which a run has failed, s. People stay only as long as they were recorded.
    pub time_limit_s: f64,
    /// Nobody is closer to the robot's start than this in the beginning (centre to centre), m.
    pub clear_of_start_m: f64,
    /// Distance from the goal at which it counts as reached, m.
    pub goal_tolerance_m: f64,
}

/// Why a recording gives no scenarios.
#[derive(Debug, thiserror::Error)]
pub enum RecordedCrowdError {
    /// The recording cannot be used at all.
    #[error(transparent)]
    Recording(#[from] SourceError),
    /// A number of the request is not finite or not positive.
    #[error("{field} is {value}; give a finite number greater than zero")]
    BadNumber {
        /// Its name.
        field: &'static str,
        /// Its value.
        value: f64,
    },
    /// Nobody can be followed for as long as a crossing takes, or nowhere is room for a start.
    #[error(
        "{}: no scenario in {length_s:.0} s with {tracks} tracks; ask for a shorter `crossing_s`, a shorter way or a smaller \
         `clear_of_start_m`",
        path.display()
    )]
    NoScenario {
        /// The recording.
        path: std::path::PathBuf,
        /// Its length, s.
        length_s: f64,
        /// People with an identity who were seen at least twice.
        tracks: usize,
    },
    /// What was recorded makes no valid scenario.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
}

impl RecordedCrowd {
    /// Every five seconds a way of 15 m, crossed at 1 m/s and some more time.
    pub const EVERY_5_S: Self = Self {
        every_s: 5.0,
        way_m: 15.0,
        crossing_s: 20.0,
        time_limit_s: 60.0,
        clear_of_start_m: 2.0,
        goal_tolerance_m: 0.3,
    };

    fn validate(&self) -> Result<(), RecordedCrowdError> {
        let numbers = [
            ("every_s", self.every_s),
            ("way_m", self.way_m),
            ("crossing_s", self.crossing_s),
            ("time_limit_s", self.time_limit_s),
            ("clear_of_start_m", self.clear_of_start_m),
            ("goal_tolerance_m", self.goal_tolerance_m),
        ];
        // Shorter steps than the sensors' tell nothing apart.
        match numbers.into_iter().find(|(_, value)| !(value.is_finite() && *value >= 1e-2)) {
            Some((field, value)) => Err(RecordedCrowdError::BadNumber { field, value }),
            None => Ok(()),
        }
    }
}

/// Cuts scenarios out of a recording: every `request.every_s` one in which the people repeat what they did from then on, and
/// the robot starts at the end of a straight way through the place where most of them were and along which it would meet most.
///
/// Start times at which no end of any way is free are left out. Detections without identity are, too. Names begin with `name`
/// and end in the start time.
///
/// # Errors
/// [`RecordedCrowdError`] if the recording cannot be read, or gives no scenario.
pub fn scenarios_of_recording(
    path: &Path,
    name: &str,
    settings: &Settings,
    request: &RecordedCrowd,
) -> Result<Vec<Scenario>, RecordedCrowdError> {
    request.validate()?;
    let (playlist, _) = load::load(path, settings)?;
    let tracks = tracks(&playlist);
    let length_s = playlist.length_ns as f64 * S_PER_NS;
    let mut scenarios = Vec::new();
    let starts = (0..).map(|k| f64::from(k) * request.every_s);
    for start_s in starts.take_while(|start_s| start_s + request.crossing_s <= length_s) {
        let Some(way) = Way::find(&tracks, start_s, request) else { continue };
        let people = tracks
            .iter()
            .filter_map(|track| track.from(start_s, start_s + request.time_limit_s))
            .zip(1..)
            .map(|(person, id)| Person { id, ..person });
        let scenario = Scenario {
            name: format!("{name}-{start_s:06.2}s"),
            seed: 0,
            start: RobotStart { position_m: way.start_m, heading_rad: way.heading_rad },
            goal_m: way.goal_m,
            goal_heading_rad: way.heading_rad,
            goal_tolerance_m: request.goal_tolerance_m,
            time_limit_s: request.time_limit_s,
            robot_radius_m: settings.robot.radius_m,
            robot_limits: None,
            arena: around(&tracks, &way),
            people: people.collect(),
        };
        scenario.validate()?;
        scenarios.push(scenario);
    }
    if scenarios.is_empty() {
        return Err(RecordedCrowdError::NoScenario { path: path.to_owned(), length_s, tracks: tracks.len() });
    }
    Ok(scenarios)
}

/// Where one person was, without longer gaps.
#[derive(Debug, Clone, Default)]
struct RecordedTrack {
    times_s: Vec<f64>,
    positions_m: Vec<[f64; 2]>,
    radius_m: f64,
}

impl RecordedTrack {
    /// The part from `begin_s` to `end_s` with one more point on either side, its times counted from `begin_s`, as a person yet
    /// without identity; `None` if there are no two points of it.
    fn from(&self, begin_s: f64, end_s: f64) -> Option<Person> {
        let first = self.times_s.partition_point(|time_s| *time_s <= begin_s).saturating_sub(1);
        let last = self.times_s.partition_point(|time_s| *time_s <= end_s).min(self.times_s.len() - 1);
        let is_over = self.times_s.last().is_none_or(|last_s| *last_s <= begin_s);
        if is_over || last <= first {
            return None;
        }
        let motion = Motion::Track {
            times_s: self.times_s[first..=last].iter().map(|time_s| time_s - begin_s).collect(),
            positions_m: self.positions_m[first..=last].to_vec(),
        };
        Some(Person { id: 0, radius_m: self.radius_m, class: ClassName::Pedestrian, motion })
    }

    /// Positions from `begin_s` to `end_s`, with their times.
    fn between(&self, begin_s: f64, end_s: f64) -> impl Iterator<Item = (f64, [f64; 2])> {
        let points = self.times_s.iter().copied().zip(self.positions_m.iter().copied());
        points.filter(move |(time_s, _)| (begin_s..=end_s).contains(time_s))
    }
}

/// Everybody with an identity who was seen at least twice, in order of identity and time.
fn tracks(playlist: &Playlist) -> Vec<RecordedTrack> {
    let mut by_id: BTreeMap<u64, Vec<RecordedTrack>> = BTreeMap::new();
    for &frame in &playlist.frames {
        let entry = &playlist.entries[frame as usize];
        let time_s = entry.valid_ns as f64 * S_PER_NS;
        for person in playlist.people_of(entry).iter().filter(|person| person.track_id != 0) {
            let tracks = by_id.entry(person.track_id).or_default();
            let since_s = tracks.last().and_then(|track| track.times_s.last()).map(|last_s| time_s - last_s);
            if since_s.is_none_or(|since_s| since_s > LONGEST_GAP_S) {
                tracks.push(RecordedTrack { radius_m: person.radius_m, ..RecordedTrack::default() });
            } else if since_s.is_some_and(|since_s| since_s < LEAST_GAP_S) {
                continue;
            }
            if let Some(track) = tracks.last_mut() {
                track.times_s.push(time_s);
                track.positions_m.push(person.position_in_odom_m);
            }
        }
    }
    by_id.into_values().flatten().filter(|track| track.times_s.len() >= 2).collect()
}

/// A straight way.
#[derive(Debug, Clone, Copy)]
struct Way {
    start_m: [f64; 2],
    goal_m: [f64; 2],
    heading_rad: f64,
    /// People who come close to it while the robot is expected there.
    met: usize,
}

impl Way {
    fn find(tracks: &[RecordedTrack], start_s: f64, request: &RecordedCrowd) -> Option<Self> {
        let centre_m = busiest_place(tracks, start_s, start_s + request.crossing_s)?;
        // Both ends of each line may be the start.
        let headings = (0..2 * DIRECTIONS).map(|k| {
            let (line, turned) = (k % DIRECTIONS, k / DIRECTIONS);
            PI * (f64::from(line) / f64::from(DIRECTIONS) - f64::from(turned))
        });
        let ways = headings.map(|heading_rad| {
            let (sin, cos) = heading_rad.sin_cos();
            let half_m = 0.5 * request.way_m;
            let start_m = [centre_m[0] - half_m * cos, centre_m[1] - half_m * sin];
            let goal_m = [centre_m[0] + half_m * cos, centre_m[1] + half_m * sin];
            let met = tracks.iter().filter(|track| {
                track
                    .between(start_s, start_s + request.crossing_s)
                    .any(|(_, at_m)| distance_to_way_m(at_m, start_m, goal_m) <= MET_M)
            });
            Self { start_m, goal_m, heading_rad, met: met.count() }
        });
        let is_free = |way: &Self| {
            tracks.iter().all(|track| {
                let mut beginning = track.between(start_s, start_s + LONGEST_GAP_S);
                beginning.all(|(_, at_m)| distance_m(at_m, way.start_m) >= request.clear_of_start_m)
            })
        };
        // The first of the best.
        ways.filter(is_free).fold(None, |best: Option<Self>, way| match best {
            Some(best) if best.met >= way.met => Some(best),
            _ => Some(way),
        })
    }
}

/// Where most people are within a small circle, summed over a sighting a second of each; `None` without anybody.
fn busiest_place(tracks: &[RecordedTrack], begin_s: f64, end_s: f64) -> Option<[f64; 2]> {
    let mut seen: Vec<[f64; 2]> = Vec::new();
    for track in tracks {
        let mut next_s = begin_s;
        for (time_s, at_m) in track.between(begin_s, end_s) {
            if time_s >= next_s {
                seen.push(at_m);
                next_s = time_s + 1.0;
            }
        }
    }
    let around =
        |centre_m: &[f64; 2]| seen.iter().filter(|at_m| distance_m(**at_m, *centre_m) <= PLACE_M).count();
    // Of equally busy places the first.
    seen.iter().rev().max_by_key(|centre_m| around(centre_m)).copied()
}

fn distance_m(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn distance_to_way_m(at_m: [f64; 2], start_m: [f64; 2], goal_m: [f64; 2]) -> f64 {
    let way = [goal_m[0] - start_m[0], goal_m[1] - start_m[1]];
    let along = (at_m[0] - start_m[0]) * way[0] + (at_m[1] - start_m[1]) * way[1];
    let share = (along / (way[0] * way[0] + way[1] * way[1])).clamp(0.0, 1.0);
    distance_m(at_m, [start_m[0] + share * way[0], start_m[1] + share * way[1]])
}

/// The rectangle that holds the way and everybody at any time.
fn around(tracks: &[RecordedTrack], way: &Way) -> Rectangle {
    let mut arena = Rectangle { x_m: [f64::INFINITY, -f64::INFINITY], y_m: [f64::INFINITY, -f64::INFINITY] };
    let positions_m = tracks.iter().flat_map(|track| &track.positions_m);
    for [x, y] in positions_m.chain([&way.start_m, &way.goal_m]) {
        arena.x_m = [arena.x_m[0].min(*x), arena.x_m[1].max(*x)];
        arena.y_m = [arena.y_m[0].min(*y), arena.y_m[1].max(*y)];
    }
    // A way along an axis, and nobody beside it.
    let widened = |[low, high]: [f64; 2]| if low < high { [low, high] } else { [low - 1.0, high + 1.0] };
    Rectangle { x_m: widened(arena.x_m), y_m: widened(arena.y_m) }
}
