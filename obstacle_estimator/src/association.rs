//! Which anonymous detection belongs to which anonymous track.
//!
//! Without a filter the closest admissible pair comes first, then the closest of what is left. With one, all pairs together
//! are the likeliest ones. Not here: named detections, whose identity is perception's business.

use messages::{Detection, MAX_OBSTACLES};
use settings::EstimatorSettings;

use crate::assignment::Assignment;
use crate::beliefs::{Beliefs, GATE_DISTANCE2};
use crate::motion::Sighting;
use crate::track::Track;

/// One admissible pair.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    /// How far apart the two are: in m, or twice the negative log-likelihood that they are the same.
    cost: f64,
    track: usize,
    detection: usize,
}

/// What the least likely admissible pair gains over none, so that it is one.
const LEAST_GAIN: f64 = 1e-6;

/// Working memory of the association, allocated once.
#[derive(Debug)]
pub(crate) struct Association {
    candidates: Vec<Candidate>,
    /// What each anonymous detection says of a position; unused without a filter.
    sightings: Vec<Sighting>,
    /// The tracks that some detection is admissible for: a row of the assignment each.
    hopeful: Vec<usize>,
    assignment: Assignment,
    /// Per entry of the frame, the track it was given.
    assigned: [Option<usize>; MAX_OBSTACLES],
}

impl Association {
    pub(crate) fn new() -> Self {
        Self {
            candidates: Vec::with_capacity(MAX_OBSTACLES * MAX_OBSTACLES),
            sightings: Vec::with_capacity(MAX_OBSTACLES),
            hopeful: Vec::with_capacity(MAX_OBSTACLES),
            assignment: Assignment::new(),
            assigned: [None; MAX_OBSTACLES],
        }
    }

    /// Pairs the detections `anonymous` (indices into `frame`) with the unseen anonymous `tracks`.
    ///
    /// A pair is admissible if the detection lies within the gate of the position predicted for `time_ns` and could be
    /// reached from the last sighting without teleporting. Ties go to the earlier track, then the earlier detection.
    pub(crate) fn nearest(
        &mut self,
        tracks: &[Track],
        frame: &[Detection],
        anonymous: &[usize],
        time_ns: u64,
        settings: &EstimatorSettings,
    ) {
        self.candidates.clear();
        self.assigned = [None; MAX_OBSTACLES];
        for (track, state) in tracks.iter().enumerate().filter(|(_, state)| state.anonymous && !state.seen) {
            let [px, py] = state.position_at_m(time_ns);
            let interval_s = (time_ns - state.measured_at_ns) as f64 * 1e-9;
            for &detection in anonymous {
                let position_m = frame[detection].position_in_odom_m;
                let distance_m = (position_m[0] - px).hypot(position_m[1] - py);
                let [vx, vy] = state.mean_velocity_to_mps(position_m, interval_s);
                if distance_m <= settings.association_gate_m && vx.hypot(vy) <= settings.teleport_speed_mps {
                    self.candidates.push(Candidate { cost: distance_m, track, detection });
                }
            }
        }
        self.assign();
    }

    /// The same with beliefs: a detection is admissible if it also lies within the ellipse that holds 99 % of sightings, and
    /// all pairs together are the likeliest, not each by itself: in a crowd the nearest one may be somebody else's.
    ///
    /// A pair gains as much log-likelihood as it has beyond that of the least likely admissible one, so none is broken up for
    /// the sake of their number.
    pub(crate) fn likeliest(
        &mut self,
        tracks: &[Track],
        beliefs: &Beliefs,
        frame: &[Detection],
        anonymous: &[usize],
        time_ns: u64,
        settings: &EstimatorSettings,
    ) {
        self.candidates.clear();
        self.assigned = [None; MAX_OBSTACLES];
        self.sightings.clear();
        self.sightings.extend(anonymous.iter().map(|&index| beliefs.doubtful_sighting(&frame[index])));
        self.hopeful.clear();
        let mut flattest = f64::NEG_INFINITY;
        for (track, state) in tracks.iter().enumerate().filter(|(_, state)| state.anonymous && !state.seen) {
            let row = self.hopeful.len();
            let forecast = state.forecast(time_ns, beliefs);
            let interval_s = (time_ns - state.measured_at_ns) as f64 * 1e-9;
            for (column, sighting) in self.sightings.iter().enumerate() {
                let distance_m = (sighting.position_m - forecast.position_m()).norm();
                if distance_m > settings.association_gate_m {
                    continue;
                }
                let (distance2, log_determinant) = forecast.surprise(sighting);
                if distance2 <= GATE_DISTANCE2 && state.could_reach(sighting, interval_s, settings, beliefs) {
                    let cost = distance2 + log_determinant;
                    self.candidates.push(Candidate { cost, track: row, detection: column });
                    flattest = flattest.max(log_determinant);
                }
            }
            if self.candidates.last().is_some_and(|candidate| candidate.track == row) {
                self.hopeful.push(track);
            }
        }
        self.assignment.clear(self.hopeful.len(), anonymous.len());
        let nobody = GATE_DISTANCE2 + flattest + LEAST_GAIN;
        for candidate in &self.candidates {
            self.assignment.gain(candidate.track, candidate.detection, nobody - candidate.cost);
        }
        for (row, column) in self.assignment.solve() {
            self.assigned[anonymous[column]] = Some(self.hopeful[row]);
        }
    }

    /// Gives each track at most one detection and each detection at most one track, the cheapest candidates first.
    fn assign(&mut self) {
        self.candidates.sort_unstable_by(|a, b| {
            a.cost.total_cmp(&b.cost).then(a.track.cmp(&b.track)).then(a.detection.cmp(&b.detection))
        });
        let mut track_is_taken = [false; MAX_OBSTACLES];
        for candidate in &self.candidates {
            if !track_is_taken[candidate.track] && self.assigned[candidate.detection].is_none() {
                track_is_taken[candidate.track] = true;
                self.assigned[candidate.detection] = Some(candidate.track);
            }
        }
    }

    /// The track that entry `detection` of the frame was given.
    pub(crate) fn track_of(&self, detection: usize) -> Option<usize> {
        self.assigned[detection]
    }
}
