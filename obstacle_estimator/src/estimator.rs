//! The estimator proper: frames of detections in, obstacles with their derivatives out.
//!
//! Lives here: the life of tracks and the order in which a frame is worked through. Pure: no clock, no port, and no
//! allocation after construction.

use bytemuck::Zeroable;
use messages::{Detections, MAX_OBSTACLES, Obstacles, Reason, Stamp};
use settings::{EstimatorKind, EstimatorSettings};

use crate::association::Association;
use crate::beliefs::Beliefs;
use crate::counts::{EstimatorCounts, FrameRefusal};
use crate::track::{Track, Update, is_sound, provided_velocity};

/// First identity given to obstacles that perception leaves anonymous. Perception rarely counts that far; if it does, the
/// identities in use are skipped.
pub const FIRST_ANONYMOUS_ID: u64 = 1 << 63;

/// A frame that claims to be this much newer than now is refused, ns: believing it would make every honest frame after
/// it look out of order.
pub const FUTURE_TOLERANCE_NS: u64 = 100_000_000;

/// Tracks obstacles and approximates ȯ: by backward differences over the measured interval (paper eq. o_dot_approx), by
/// what perception measured, or by a Kalman filter.
#[derive(Debug)]
pub struct Estimator {
    settings: EstimatorSettings,
    tracks: Vec<Track>,
    /// What a filter believes of each track; `None` without a filter.
    beliefs: Option<Beliefs>,
    next_anonymous_id: u64,
    association: Association,
    /// Entries of the frame at hand: named ones already met, without a track yet, and anonymous ones.
    named_ids: Vec<u64>,
    untracked: Vec<usize>,
    anonymous: Vec<usize>,
    has_frame: bool,
    output: Box<Obstacles>,
    counts: EstimatorCounts,
    last_reason: Reason,
}

impl Estimator {
    /// An estimator that has seen nothing yet. `settings` are validated when they are read.
    pub fn new(settings: EstimatorSettings) -> Self {
        Self {
            beliefs: Beliefs::new(&settings),
            settings,
            tracks: Vec::with_capacity(MAX_OBSTACLES),
            next_anonymous_id: FIRST_ANONYMOUS_ID,
            association: Association::new(),
            named_ids: Vec::with_capacity(MAX_OBSTACLES),
            untracked: Vec::with_capacity(MAX_OBSTACLES),
            anonymous: Vec::with_capacity(MAX_OBSTACLES),
            has_frame: false,
            output: Box::new(Obstacles::zeroed()),
            counts: EstimatorCounts::default(),
            last_reason: Reason::None,
        }
    }

    /// Takes a frame of detections, received at `now_ns` (stack clock), and returns what is believed now.
    ///
    /// Everything in the answer holds for the frame's time: what the frame shows as measured, the rest predicted. A
    /// frame from the past, from the future, or with the time of the newest one is refused whole and counted; the answer
    /// is then that of [`Estimator::heartbeat`]. A malformed or repeated detection is refused alone and counted.
    pub fn step(&mut self, frame: &Detections, now_ns: u64) -> &Obstacles {
        if let Err(refusal) = self.admit(frame, now_ns) {
            self.last_reason = refusal.reason();
            return self.heartbeat(now_ns);
        }
        let time_ns = frame.stamp.valid_at_ns;
        self.has_frame = true;
        self.counts.frames_used += 1;
        if let Some(beliefs) = &mut self.beliefs {
            beliefs.begin_frame(time_ns);
        }
        self.sort_detections(frame);
        self.update_named(frame);
        self.update_anonymous(frame);
        self.drop_vanished(time_ns);
        let evicted = self.start_tracks(frame);

        self.output.stamp = Stamp { sequence: self.output.stamp.sequence, ..frame.stamp };
        self.output.bridge_published_ns = frame.stamp.published_ns;
        self.output.received_ns = now_ns;
        self.output.left_out = frame.left_out.saturating_add(evicted);
        self.write(now_ns, |_| time_ns)
    }

    /// Returns what is believed at `now_ns` (stack clock) without news from perception.
    ///
    /// Every track is predicted to `now_ns` at constant velocity, at most `coast_ms` beyond its last sighting. Silence
    /// drops nobody: only a frame can say that somebody is gone. The stamp still tells when perception last spoke.
    pub fn heartbeat(&mut self, now_ns: u64) -> &Obstacles {
        if let Some(beliefs) = &mut self.beliefs {
            beliefs.settle();
        }
        let coast_ns = self.settings.coast_ms.saturating_mul(1_000_000);
        self.write(now_ns, |track| now_ns.min(track.measured_at_ns.saturating_add(coast_ns)))
    }

    /// What was met so far.
    pub fn counts(&self) -> &EstimatorCounts {
        &self.counts
    }

    /// Standard deviation that positions are believed to have along each axis, m; `None` if nothing asks for it.
    pub fn position_sd_m(&self) -> Option<f64> {
        self.beliefs.as_ref().map(Beliefs::position_sd_m)
    }

    /// The last thing that went wrong; [`Reason::None`] if nothing did.
    pub fn last_reason(&self) -> Reason {
        self.last_reason
    }

    fn admit(&mut self, frame: &Detections, now_ns: u64) -> Result<(), FrameRefusal> {
        let (time_ns, newest_ns) = (frame.stamp.valid_at_ns, self.output.stamp.valid_at_ns);
        if time_ns > now_ns.saturating_add(FUTURE_TOLERANCE_NS) {
            self.counts.frames_from_future += 1;
            Err(FrameRefusal::FromFuture)
        } else if self.has_frame && time_ns < newest_ns {
            self.counts.frames_out_of_order += 1;
            Err(FrameRefusal::OutOfOrder)
        } else if self.has_frame && time_ns == newest_ns {
            self.counts.frames_duplicate += 1;
            Err(FrameRefusal::Duplicate)
        } else {
            Ok(())
        }
    }

    /// Refuses what cannot be an obstacle or occurs twice, and tells named from anonymous detections.
    fn sort_detections(&mut self, frame: &Detections) {
        self.named_ids.clear();
        self.untracked.clear();
        self.anonymous.clear();
        for (index, detection) in frame.as_slice().iter().enumerate() {
            if !is_sound(detection) {
                self.counts.detections_malformed += 1;
                self.last_reason = Reason::MalformedInput;
            } else if detection.track_id == 0 {
                self.anonymous.push(index);
            } else if self.named_ids.contains(&detection.track_id) {
                self.counts.detections_duplicate += 1;
                self.last_reason = Reason::Duplicate;
            } else {
                self.named_ids.push(detection.track_id);
                self.untracked.push(index);
            }
        }
        for &index in self.untracked.iter().chain(&self.anonymous) {
            let provided = provided_velocity(&frame.items[index], &self.settings);
            self.counts.detections_used += 1;
            self.counts.velocities_missing +=
                u64::from(self.settings.kind == EstimatorKind::Provided && provided.is_none());
        }
        self.tracks.iter_mut().for_each(Track::begin_frame);
    }

    /// Updates tracks by identity; what has no track yet stays in `untracked`.
    fn update_named(&mut self, frame: &Detections) {
        let mut kept = 0;
        for k in 0..self.untracked.len() {
            let index = self.untracked[k];
            let id = frame.items[index].track_id;
            if let Some(track) = self.tracks.iter().position(|track| track.id == id) {
                // Perception now knows by name whom it saw: nobody anonymous may take the track over.
                self.tracks[track].anonymous = false;
                self.update_track(track, frame, index);
            } else {
                self.untracked[kept] = index;
                kept += 1;
            }
        }
        self.untracked.truncate(kept);
    }

    fn update_anonymous(&mut self, frame: &Detections) {
        let time_ns = frame.stamp.valid_at_ns;
        let (tracks, settings) = (&self.tracks, &self.settings);
        match &self.beliefs {
            None => self.association.nearest(tracks, &frame.items, &self.anonymous, time_ns, settings),
            Some(beliefs) => {
                self.association.likeliest(tracks, beliefs, &frame.items, &self.anonymous, time_ns, settings);
            }
        }
        for k in 0..self.anonymous.len() {
            let index = self.anonymous[k];
            match self.association.track_of(index) {
                Some(track) => self.update_track(track, frame, index),
                None => self.untracked.push(index),
            }
        }
    }

    fn update_track(&mut self, track: usize, frame: &Detections, index: usize) {
        let time_ns = frame.stamp.valid_at_ns;
        let (track, detection) = (&mut self.tracks[track], &frame.items[index]);
        let update = match &mut self.beliefs {
            None => track.update(detection, time_ns, &self.settings),
            Some(beliefs) => track.follow(detection, time_ns, &self.settings, beliefs),
        };
        match update {
            Update::Continued => {}
            Update::Interrupted => self.counts.tracks_interrupted += 1,
            Update::Teleported => {
                self.counts.tracks_teleported += 1;
                self.last_reason = Reason::Teleport;
            }
        }
    }

    fn drop_vanished(&mut self, time_ns: u64) {
        let coast_ns = self.settings.coast_ms.saturating_mul(1_000_000);
        let before = self.tracks.len();
        let beliefs = &mut self.beliefs;
        self.tracks.retain(|track| {
            let stays = track.seen || time_ns - track.measured_at_ns <= coast_ns;
            if let (false, Some(beliefs)) = (stays, beliefs.as_mut()) {
                beliefs.release(track.place);
            }
            stays
        });
        self.counts.tracks_dropped += (before - self.tracks.len()) as u64;
        self.counts.tracks_coasted += self.tracks.iter().filter(|track| !track.seen).count() as u64;
    }

    /// Starts a track for every detection left. A frame holds at most as many as there is room for, so the only tracks
    /// that may stand in the way are coasting ones: the longest unseen goes first. Returns how many had to.
    fn start_tracks(&mut self, frame: &Detections) -> u32 {
        let mut evicted = 0;
        for k in 0..self.untracked.len() {
            let detection = &frame.items[self.untracked[k]];
            if self.tracks.len() == MAX_OBSTACLES {
                self.evict_longest_unseen();
                evicted += 1;
            }
            let id = if detection.track_id == 0 { self.anonymous_id() } else { detection.track_id };
            let mut track = Track::new(id, detection, frame.stamp.valid_at_ns, &self.settings);
            if let Some(beliefs) = &mut self.beliefs {
                track.place = beliefs.take(detection);
            }
            self.tracks.push(track);
            self.counts.tracks_started += 1;
        }
        evicted
    }

    fn evict_longest_unseen(&mut self) {
        let unseen = self.tracks.iter().enumerate().filter(|(_, track)| !track.seen);
        if let Some((index, _)) = unseen.min_by_key(|(_, track)| track.measured_at_ns) {
            let track = self.tracks.remove(index);
            if let Some(beliefs) = &mut self.beliefs {
                beliefs.release(track.place);
            }
            self.counts.tracks_evicted += 1;
            self.last_reason = Reason::CapacityExceeded;
        }
    }

    fn anonymous_id(&mut self) -> u64 {
        loop {
            let id = self.next_anonymous_id;
            self.next_anonymous_id = id.checked_add(1).unwrap_or(FIRST_ANONYMOUS_ID);
            if !self.named_ids.contains(&id) && self.tracks.iter().all(|track| track.id != id) {
                return id;
            }
        }
    }

    /// Writes all tracks, each predicted to the time that `valid_at_ns` tells for it.
    fn write(&mut self, now_ns: u64, valid_at_ns: impl Fn(&Track) -> u64) -> &Obstacles {
        let coast_ns = self.settings.coast_ms.saturating_mul(1_000_000);
        let before = self.output.count as usize;
        let items = self.output.items.iter_mut().zip(&self.tracks);
        match &self.beliefs {
            None => items.for_each(|(item, track)| *item = track.obstacle_at(valid_at_ns(track))),
            Some(beliefs) => items.for_each(|(item, track)| {
                let oldest_ns = track.measured_at_ns.saturating_add(coast_ns);
                *item = track.uncertain_obstacle_at(valid_at_ns(track), now_ns.min(oldest_ns), beliefs);
            }),
        }
        for item in self.output.items.iter_mut().take(before).skip(self.tracks.len()) {
            *item = messages::Obstacle::zeroed();
        }
        self.output.count = self.tracks.len() as u32;
        self.output.stamp.sequence += 1;
        self.output.stamp.published_ns = now_ns;
        &self.output
    }
}
