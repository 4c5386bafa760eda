//! One tracked obstacle: its state o and the approximation of ȯ by backward differences.
//!
//! Lives here: the arithmetic of paper eq. o_dot_approx for one obstacle; what a Kalman filter makes of it is in `filtered`.
//! Which detection belongs to which track is in `association`, the life of tracks in `estimator`.

mod filtered;

use dynamics::wrap_angle;
use messages::{Detection, DetectionFlags, Obstacle, ObstacleClass, ObstacleQuality};
use settings::{EstimatorKind, EstimatorSettings};

/// Farthest a position may lie from the origin, m. Anything beyond is garbage, and would overflow when squared.
const MAX_COORDINATE_M: f64 = 1e6;

/// How much of the motion is known, in the order in which sightings reveal it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Knowledge {
    Position,
    Velocity,
    Rates,
}

/// Where a filtered track has its newest velocity from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Source {
    Models,
    Differences,
}

/// What a new sighting did to a track.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Update {
    /// The motion was carried on.
    Continued,
    /// Too long since the last sighting: the velocity begins anew.
    Interrupted,
    /// Too far from the last sighting: everything begins anew.
    Teleported,
}

/// Positions and velocities in `odom`, times on the stack clock.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Track {
    pub(crate) id: u64,
    /// Whether perception gives this obstacle no identity.
    pub(crate) anonymous: bool,
    /// Whether the newest frame showed it.
    pub(crate) seen: bool,
    pub(crate) measured_at_ns: u64,
    /// Where its belief is kept; unused without a filter.
    pub(crate) place: usize,
    /// Which of the newest frames showed it, the newest one in the lowest bit.
    sightings: u8,
    source: Source,
    position_m: [f64; 2],
    velocity_mps: [f64; 2],
    acceleration_mps2: [f64; 2],
    heading_rad: f64,
    /// Whether `heading_rad` stems from a speed at which a direction can be told.
    heading_is_clear: bool,
    heading_rate_radps: f64,
    speed_rate_mps2: f64,
    radius_m: f64,
    class: u32,
    knowledge: Knowledge,
}

/// Whether position and radius can be those of an obstacle.
pub(crate) fn is_sound(detection: &Detection) -> bool {
    detection.position_in_odom_m.iter().all(|coordinate| coordinate.abs() <= MAX_COORDINATE_M)
        && detection.radius_m.is_finite()
        && detection.radius_m > 0.0
}

/// The velocity perception measured, if the settings want it, the detection has it, and something could move so, m/s.
pub(crate) fn provided_velocity(detection: &Detection, settings: &EstimatorSettings) -> Option<[f64; 2]> {
    match settings.kind {
        EstimatorKind::BackwardDifference | EstimatorKind::Kalman | EstimatorKind::Imm => None,
        EstimatorKind::Provided => {
            let [vx, vy] = detection.velocity_in_odom_mps;
            let present = detection.flags & DetectionFlags::HAS_VELOCITY != 0;
            // A NaN fails the comparison.
            (present && vx.hypot(vy) <= settings.teleport_speed_mps).then_some([vx, vy])
        }
    }
}

impl Track {
    /// A first sighting: no velocity unless perception provides it.
    pub(crate) fn new(
        id: u64,
        detection: &Detection,
        measured_at_ns: u64,
        settings: &EstimatorSettings,
    ) -> Self {
        let mut track = Self {
            id,
            anonymous: detection.track_id == 0,
            seen: true,
            measured_at_ns,
            place: 0,
            sightings: 1,
            source: Source::Models,
            position_m: detection.position_in_odom_m,
            velocity_mps: [0.0, 0.0],
            acceleration_mps2: [0.0, 0.0],
            heading_rad: 0.0,
            heading_is_clear: false,
            heading_rate_radps: 0.0,
            speed_rate_mps2: 0.0,
            radius_m: detection.radius_m,
            class: known_class(detection.class),
            knowledge: Knowledge::Position,
        };
        if let Some(velocity_mps) = provided_velocity(detection, settings) {
            track.begin_motion(velocity_mps, settings);
        }
        track
    }

    /// Nobody is seen yet in a new frame.
    pub(crate) fn begin_frame(&mut self) {
        self.seen = false;
        self.sightings <<= 1;
    }

    /// Takes a sighting at `measured_at_ns`, later than the last one.
    pub(crate) fn update(
        &mut self,
        detection: &Detection,
        measured_at_ns: u64,
        settings: &EstimatorSettings,
    ) -> Update {
        let interval_ns = measured_at_ns - self.measured_at_ns;
        let interval_s = interval_ns as f64 * 1e-9;
        let difference_mps = self.mean_velocity_to_mps(detection.position_in_odom_m, interval_s);
        if difference_mps[0].hypot(difference_mps[1]) > settings.teleport_speed_mps {
            *self = Self::new(self.id, detection, measured_at_ns, settings);
            return Update::Teleported;
        }
        self.seen = true;
        self.measured_at_ns = measured_at_ns;
        self.position_m = detection.position_in_odom_m;
        self.radius_m = detection.radius_m;
        self.class = known_class(detection.class);

        let provided_mps = provided_velocity(detection, settings);
        if interval_ns > settings.max_difference_interval_ms.saturating_mul(1_000_000) {
            self.forget_motion();
            if let Some(velocity_mps) = provided_mps {
                self.begin_motion(velocity_mps, settings);
            }
            return Update::Interrupted;
        }
        let velocity_mps = provided_mps.unwrap_or(difference_mps);
        match self.knowledge {
            Knowledge::Position => self.begin_motion(velocity_mps, settings),
            Knowledge::Velocity | Knowledge::Rates => {
                self.continue_motion(velocity_mps, interval_s, settings);
            }
        }
        Update::Continued
    }

    /// Velocity that takes the track from its last sighting to `position_m` in `interval_s`, m/s.
    pub(crate) fn mean_velocity_to_mps(&self, position_m: [f64; 2], interval_s: f64) -> [f64; 2] {
        std::array::from_fn(|k| (position_m[k] - self.position_m[k]) / interval_s)
    }

    /// Where the obstacle is at `time_ns` if it keeps its velocity, m.
    pub(crate) fn position_at_m(&self, time_ns: u64) -> [f64; 2] {
        let ahead_s = time_ns.saturating_sub(self.measured_at_ns) as f64 * 1e-9;
        std::array::from_fn(|k| self.position_m[k] + self.velocity_mps[k] * ahead_s)
    }

    fn forget_motion(&mut self) {
        self.velocity_mps = [0.0, 0.0];
        self.acceleration_mps2 = [0.0, 0.0];
        self.heading_is_clear = false;
        self.heading_rate_radps = 0.0;
        self.speed_rate_mps2 = 0.0;
        self.knowledge = Knowledge::Position;
    }

    fn begin_motion(&mut self, velocity_mps: [f64; 2], settings: &EstimatorSettings) {
        self.set_velocity(velocity_mps, settings);
        self.knowledge = Knowledge::Velocity;
    }

    /// Paper eq. o_dot_approx for the parts of o that are velocities: (o(t) − o(t − δt))/δt, clipped to the bounds.
    fn continue_motion(&mut self, velocity_mps: [f64; 2], interval_s: f64, settings: &EstimatorSettings) {
        let before_mps = self.velocity_mps;
        let (heading_before_rad, heading_was_clear) = (self.heading_rad, self.heading_is_clear);
        self.set_velocity(velocity_mps, settings);

        let max_rate_mps2 = settings.max_speed_rate_mps2;
        let rate =
            |after: f64, before: f64| ((after - before) / interval_s).clamp(-max_rate_mps2, max_rate_mps2);
        self.acceleration_mps2 = std::array::from_fn(|k| rate(velocity_mps[k], before_mps[k]));
        self.speed_rate_mps2 =
            rate(velocity_mps[0].hypot(velocity_mps[1]), before_mps[0].hypot(before_mps[1]));
        self.heading_rate_radps = if self.heading_is_clear && heading_was_clear {
            let max_radps = settings.max_heading_rate_radps;
            (wrap_angle(self.heading_rad - heading_before_rad) / interval_s).clamp(-max_radps, max_radps)
        } else {
            0.0
        };
        self.knowledge = Knowledge::Rates;
    }

    /// Below the holding speed the direction of motion is mostly noise: the last clear heading stays.
    fn set_velocity(&mut self, velocity_mps: [f64; 2], settings: &EstimatorSettings) {
        self.velocity_mps = velocity_mps;
        let [vx, vy] = velocity_mps;
        self.heading_is_clear = vx.hypot(vy) >= settings.heading_hold_speed_mps && (vx, vy) != (0.0, 0.0);
        if self.heading_is_clear {
            self.heading_rad = wrap_angle(vy.atan2(vx));
        }
    }

    /// The track as a message, predicted to `time_ns` if that is later than its last sighting.
    pub(crate) fn obstacle_at(&self, time_ns: u64) -> Obstacle {
        // While a track coasts, its velocity is taken for constant, so its rates are zero.
        let known = if self.seen { 1.0 } else { 0.0 };
        let quality = match (self.seen, self.knowledge) {
            (false, _) => ObstacleQuality::Coasting,
            (true, Knowledge::Position) => ObstacleQuality::PositionOnly,
            (true, Knowledge::Velocity) => ObstacleQuality::Velocity,
            (true, Knowledge::Rates) => ObstacleQuality::Full,
        };
        let [vx, vy] = self.velocity_mps;
        Obstacle {
            track_id: self.id,
            measured_at_ns: self.measured_at_ns,
            valid_at_ns: time_ns.max(self.measured_at_ns),
            position_in_odom_m: self.position_at_m(time_ns),
            velocity_in_odom_mps: self.velocity_mps,
            acceleration_in_odom_mps2: self.acceleration_mps2.map(|component| known * component),
            heading_rad: self.heading_rad,
            heading_rate_radps: known * self.heading_rate_radps,
            speed_mps: vx.hypot(vy),
            speed_rate_mps2: known * self.speed_rate_mps2,
            radius_m: self.radius_m,
            class: self.class,
            quality: quality.code(),
        }
    }
}

/// A class that this version does not know is passed on as unknown.
fn known_class(code: u32) -> u32 {
    ObstacleClass::try_from(code).unwrap_or(ObstacleClass::Unknown).code()
}
