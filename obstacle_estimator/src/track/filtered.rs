//! A track whose motion a Kalman filter follows.

use messages::{Detection, Obstacle};
use settings::EstimatorSettings;

use super::{Knowledge, Source, Track, Update, known_class};
use crate::beliefs::{Beliefs, worst_sd_m};
use crate::motion::{Forecast, Sighting};

/// How far two sightings may err together before their distance counts as motion, in standard deviations of a position.
const ERRING_SDS: f64 = 4.0;
/// A track is confirmed once this many of the newest [`RECENT_FRAMES`] frames showed it.
const CONFIRMING_SIGHTINGS: u32 = 3;
const RECENT_FRAMES: u32 = 5;

impl Track {
    /// Takes a sighting at `measured_at_ns`, later than the last one, into the belief.
    ///
    /// As without a filter, a jump that nothing makes begins everything anew; what noise makes of somebody who stands is no
    /// jump. A belief older than `coast_ms` is not carried on.
    pub(crate) fn follow(
        &mut self,
        detection: &Detection,
        measured_at_ns: u64,
        settings: &EstimatorSettings,
        beliefs: &mut Beliefs,
    ) -> Update {
        let interval_ns = measured_at_ns - self.measured_at_ns;
        let interval_s = interval_ns as f64 * 1e-9;
        if !self.could_reach(&beliefs.doubtful_sighting(detection), interval_s, settings, beliefs) {
            self.begin_anew(detection, measured_at_ns, settings, beliefs);
            return Update::Teleported;
        }
        if interval_ns > settings.coast_ms.saturating_mul(1_000_000) {
            self.begin_anew(detection, measured_at_ns, settings, beliefs);
            return Update::Interrupted;
        }
        self.seen = true;
        self.sightings |= 1;
        self.measured_at_ns = measured_at_ns;
        self.radius_m = detection.radius_m;
        self.class = known_class(detection.class);
        match beliefs.update(self.place, interval_s, detection) {
            Some(velocity_mps) => self.differ(detection, velocity_mps, interval_s, settings),
            None => self.read(&beliefs.forecast(self.place, 0.0), settings),
        }
        Update::Continued
    }

    /// Whether something that moves at most at the teleporting speed can have been seen there, `elapsed_s` after it was
    /// last seen, s.
    pub(crate) fn could_reach(
        &self,
        sighting: &Sighting,
        elapsed_s: f64,
        settings: &EstimatorSettings,
        beliefs: &Beliefs,
    ) -> bool {
        let last = beliefs.forecast(self.place, 0.0);
        let distance_m = (sighting.position_m - last.position_m()).norm();
        let erring_m = ERRING_SDS * worst_sd_m(&(last.position_covariance_m2 + sighting.covariance_m2));
        distance_m <= settings.teleport_speed_mps * elapsed_s + erring_m
    }

    /// What is believed of `time_ns`, or of the last sighting if that is later.
    pub(crate) fn forecast(&self, time_ns: u64, beliefs: &Beliefs) -> Forecast {
        beliefs.forecast(self.place, time_ns.saturating_sub(self.measured_at_ns) as f64 * 1e-9)
    }

    fn begin_anew(
        &mut self,
        detection: &Detection,
        measured_at_ns: u64,
        settings: &EstimatorSettings,
        beliefs: &mut Beliefs,
    ) {
        let place = self.place;
        *self = Self { place, ..Self::new(self.id, detection, measured_at_ns, settings) };
        beliefs.begin(place, detection);
    }

    /// What two exact sightings tell, as if there were no filter. Rates need two such velocities.
    fn differ(
        &mut self,
        detection: &Detection,
        velocity_mps: [f64; 2],
        interval_s: f64,
        settings: &EstimatorSettings,
    ) {
        self.position_m = detection.position_in_odom_m;
        let velocity_mps = slowed(velocity_mps, settings.teleport_speed_mps);
        if self.source == Source::Differences {
            self.continue_motion(velocity_mps, interval_s, settings);
        } else {
            self.forget_motion();
            self.begin_motion(velocity_mps, settings);
            self.source = Source::Differences;
        }
    }

    /// What the obstacle models need of the belief, within the bounds of the settings.
    fn read(&mut self, belief: &Forecast, settings: &EstimatorSettings) {
        self.source = Source::Models;
        let [[x, y, vx, vy, ax, ay]] = belief.mean.data.0;
        self.position_m = [x, y];
        let speed_mps = vx.hypot(vy);
        self.set_velocity(slowed([vx, vy], settings.teleport_speed_mps), settings);

        let (max_rate_mps2, max_radps) = (settings.max_speed_rate_mps2, settings.max_heading_rate_radps);
        self.acceleration_mps2 = [ax, ay].map(|component| component.clamp(-max_rate_mps2, max_rate_mps2));
        // v̇ = v·a/|v| and θ̇ = v×a/|v|², where a direction can be told.
        (self.speed_rate_mps2, self.heading_rate_radps) = if self.heading_is_clear {
            (
                ((vx * ax + vy * ay) / speed_mps).clamp(-max_rate_mps2, max_rate_mps2),
                ((vx * ay - vy * ax) / (speed_mps * speed_mps)).clamp(-max_radps, max_radps),
            )
        } else {
            (0.0, 0.0)
        };
        let recent = self.sightings & ((1 << RECENT_FRAMES) - 1);
        let confirmed = self.knowledge == Knowledge::Rates || recent.count_ones() >= CONFIRMING_SIGHTINGS;
        self.knowledge = if confirmed { Knowledge::Rates } else { Knowledge::Velocity };
    }

    /// The track as a message: predicted to `time_ns` if that is later than its last sighting, with the uncertainty that its
    /// position has at `used_at_ns`, when the answer is published.
    ///
    /// The radius is where uncertainty has a place: the share of it that the settings ask for is added there.
    pub(crate) fn uncertain_obstacle_at(&self, time_ns: u64, used_at_ns: u64, beliefs: &Beliefs) -> Obstacle {
        let mut obstacle = self.obstacle_at(time_ns);
        if beliefs.radius_sds() > 0.0 {
            let forecast = self.forecast(used_at_ns.max(time_ns), beliefs);
            obstacle.radius_m += beliefs.radius_sds() * worst_sd_m(&forecast.position_covariance_m2);
        }
        obstacle
    }
}

/// The same direction, no faster than `most_mps`.
fn slowed(velocity_mps: [f64; 2], most_mps: f64) -> [f64; 2] {
    let speed_mps = velocity_mps[0].hypot(velocity_mps[1]);
    if speed_mps > most_mps {
        velocity_mps.map(|component| component * (most_mps / speed_mps))
    } else {
        velocity_mps
    }
}
