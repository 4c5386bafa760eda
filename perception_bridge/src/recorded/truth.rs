//! What really happened between the robot and the recorded people: clearance, contacts, path length.

use messages::Detection;

use super::playlist::Playlist;

/// People are not interpolated over longer gaps between two frames; behind the last frame they are gone after this, ns.
const LONGEST_GAP_NS: u64 = 500_000_000;

/// Running figures. People between two frames are taken to walk straight from one to the other.
#[derive(Debug, Clone)]
pub(super) struct Truth {
    robot_radius_m: f64,
    clearance_m: f64,
    min_clearance_m: f64,
    collisions: u32,
    path_length_m: f64,
    last_position_m: [f64; 2],
    /// Index into the playlist's frames: the first one that is not behind the robot's time.
    next_frame: usize,
    /// Identities in contact; all without identity count as one.
    touching: Vec<u64>,
    touching_before: Vec<u64>,
}

impl Truth {
    pub(super) fn new(robot_radius_m: f64, position_m: [f64; 2]) -> Self {
        Self {
            robot_radius_m,
            clearance_m: f64::INFINITY,
            min_clearance_m: f64::INFINITY,
            collisions: 0,
            path_length_m: 0.0,
            last_position_m: position_m,
            next_frame: 0,
            touching: Vec::with_capacity(64),
            touching_before: Vec::with_capacity(64),
        }
    }

    /// Notes where the robot is at recording time `at_ns`; times do not run backwards.
    pub(super) fn note(&mut self, playlist: &Playlist, at_ns: u64, position_m: [f64; 2]) {
        let [dx, dy] = [position_m[0] - self.last_position_m[0], position_m[1] - self.last_position_m[1]];
        self.path_length_m += dx.hypot(dy);
        self.last_position_m = position_m;

        let frame = |index: usize| playlist.frames.get(index).map(|entry| &playlist.entries[*entry as usize]);
        while frame(self.next_frame).is_some_and(|next| next.valid_ns <= at_ns) {
            self.next_frame += 1;
        }
        std::mem::swap(&mut self.touching, &mut self.touching_before);
        self.touching.clear();
        self.clearance_m = f64::INFINITY;
        let Some(before) = self.next_frame.checked_sub(1).and_then(frame) else { return };
        let age_ns = at_ns.saturating_sub(before.valid_ns);
        let after = frame(self.next_frame)
            .filter(|after| after.valid_ns.saturating_sub(before.valid_ns) <= LONGEST_GAP_NS);
        if after.is_none() && age_ns > LONGEST_GAP_NS {
            return;
        }
        for person in playlist.people_of(before) {
            let later = after.and_then(|after| {
                let same = |other: &&Detection| person.track_id != 0 && other.track_id == person.track_id;
                let share = age_ns as f64 / after.valid_ns.saturating_sub(before.valid_ns) as f64;
                playlist.people_of(after).iter().find(same).map(|later| (later.position_in_odom_m, share))
            });
            let mut at_m = person.position_in_odom_m;
            if let Some((later_m, share)) = later {
                for axis in 0..2 {
                    at_m[axis] += share * (later_m[axis] - at_m[axis]);
                }
            }
            let distance_m = (at_m[0] - position_m[0]).hypot(at_m[1] - position_m[1]);
            self.note_person(person.track_id, distance_m - person.radius_m - self.robot_radius_m);
        }
        self.min_clearance_m = self.min_clearance_m.min(self.clearance_m);
    }

    fn note_person(&mut self, track_id: u64, clearance_m: f64) {
        self.clearance_m = self.clearance_m.min(clearance_m);
        if clearance_m < 0.0 && !self.touching.contains(&track_id) {
            self.touching.push(track_id);
            self.collisions += u32::from(!self.touching_before.contains(&track_id));
        }
    }

    /// Distance between the discs of the robot and the nearest person now, m; `+∞` with nobody.
    pub(super) fn clearance_m(&self) -> f64 {
        self.clearance_m
    }

    /// Smallest such distance so far, m.
    pub(super) fn min_clearance_m(&self) -> f64 {
        self.min_clearance_m
    }

    /// Contacts so far; each counts once, when it begins.
    pub(super) fn collisions(&self) -> u32 {
        self.collisions
    }

    /// Length of the robot's way so far, m.
    pub(super) fn path_length_m(&self) -> f64 {
        self.path_length_m
    }
}
