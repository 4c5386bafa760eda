//! How fast people are known to walk.
//!
//! Quick to believe that somebody walks faster, slow to forget it: who stops to turn goes on at the old pace.

use barrier::BarrierObstacle;
use messages::MAX_OBSTACLES;

/// A faster pace is believed within this time, s: longer than one wrong velocity lasts.
const LEARNING_S: f64 = 0.5;
/// A pace is forgotten within this time, s.
const FORGETTING_S: f64 = 10.0;

/// Paces of those seen last. Allocates nothing after construction.
pub(crate) struct Paces {
    most_mps: f64,
    known: Vec<(u64, f64)>,
    /// Of the obstacles of the newest call, in their order, m/s.
    paces_mps: Vec<f64>,
}

impl Paces {
    /// Nobody known yet; nobody walks faster than `most_mps`.
    pub(crate) fn new(most_mps: f64) -> Self {
        Self {
            most_mps,
            known: Vec::with_capacity(MAX_OBSTACLES),
            paces_mps: Vec::with_capacity(MAX_OBSTACLES),
        }
    }

    /// The paces of `obstacles`, whose identities are `track_ids`, m/s; the last call was `elapsed_s` ago.
    pub(crate) fn of(&mut self, track_ids: &[u64], obstacles: &[BarrierObstacle], elapsed_s: f64) -> &[f64] {
        self.paces_mps.clear();
        for (track_id, obstacle) in track_ids.iter().zip(obstacles) {
            let speed_mps = obstacle.rate[0].hypot(obstacle.rate[1]).min(self.most_mps);
            let known = self.known.iter().find(|(known_id, _)| known_id == track_id);
            let pace_mps = known.map_or(speed_mps, |&(_, pace_mps)| {
                let within_s = if speed_mps > pace_mps { LEARNING_S } else { FORGETTING_S };
                pace_mps + (speed_mps - pace_mps) * (elapsed_s / within_s).min(1.0)
            });
            self.paces_mps.push(pace_mps);
        }
        self.known.clear();
        self.known.extend(track_ids.iter().copied().zip(self.paces_mps.iter().copied()).take(MAX_OBSTACLES));
        &self.paces_mps
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walking(speed_mps: f64) -> BarrierObstacle {
        BarrierObstacle { state: [0.0; 4], rate: [speed_mps, 0.0, 0.0, 0.0], radius_m: 0.7, model: 0 }
    }

    #[test]
    fn who_stops_to_turn_is_known_to_walk_on_and_one_wild_velocity_is_not_believed() {
        let mut paces = Paces::new(1.5);
        assert_eq!(paces.of(&[7], &[walking(1.2)], 0.0), [1.2]);
        for _ in 0..10 {
            paces.of(&[7], &[walking(0.0)], 0.02);
        }
        let stopped = paces.of(&[7], &[walking(0.0)], 0.02)[0];
        assert!((1.1..1.2).contains(&stopped), "{stopped}");
        let wild = paces.of(&[7], &[walking(9.0)], 0.02)[0];
        assert!(wild < stopped + 0.02, "{wild}");
    }

    #[test]
    fn paces_follow_the_identity_not_the_place_in_the_list_and_newcomers_have_their_own() {
        let mut paces = Paces::new(1.5);
        paces.of(&[1, 2], &[walking(0.4), walking(1.0)], 0.0);
        let now = paces.of(&[3, 2, 1], &[walking(0.7), walking(1.0), walking(0.4)], 0.02);
        assert_eq!(now, [0.7, 1.0, 0.4]);
        assert!(paces.of(&[], &[], 0.02).is_empty());
        assert_eq!(paces.of(&[2], &[walking(0.1)], 0.02), [0.1], "who was out of sight is new");
    }
}
