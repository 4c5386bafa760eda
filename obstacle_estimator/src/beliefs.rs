//! The beliefs of all tracks, and what detections mean to them.
//!
//! A belief is a kilobyte, so it does not travel with its track but keeps a place of its own, which the track names.

use messages::{Detection, DetectionFlags, MAX_OBSTACLES};
use nalgebra::{Matrix2, Vector2};
use settings::{EstimatorSettings, NoiseSettings};

use crate::motion::{Belief, Forecast, MotionFilter, Sighting};
use crate::noise_level::NoiseLevel;
use crate::recent::Recent;

/// Sightings within the ellipse that holds this share of them belong to the track: χ² of two degrees of freedom at 99 %.
pub(crate) const GATE_DISTANCE2: f64 = 9.210_340_371_976_184;

/// While the noise is learnt, sightings may be off by so many times what is believed, or was at first, and still belong to their
/// track: noise that sees to it that it is not seen would never be learnt.
const DOUBT: f64 = 2.0;

/// Standard deviations that a measured covariance may have, m. Anything else is a slip of perception.
const PLAUSIBLE_SD_M: std::ops::RangeInclusive<f64> = 1e-3..=10.0;

/// One belief for each track that there is room for.
#[derive(Debug)]
pub(crate) struct Beliefs {
    pub(crate) filter: MotionFilter,
    noise: NoiseSettings,
    /// What the noise is learnt to be; `None` if it is known.
    level: Option<NoiseLevel>,
    places: Vec<Belief>,
    /// The newest sightings of each place's track.
    recent: Vec<Recent>,
    /// One bit a place, set while nobody has it.
    free: u64,
}

const _: () = assert!(MAX_OBSTACLES == u64::BITS as usize, "one bit for each place");

impl Beliefs {
    /// `None` if `settings` ask for no filter.
    pub(crate) fn new(settings: &EstimatorSettings) -> Option<Self> {
        let filter = MotionFilter::new(settings)?;
        let noise = settings.noise?;
        let nobody =
            Sighting { position_m: Vector2::zeros(), covariance_m2: usual_covariance(noise.position_sd_m) };
        let places = vec![filter.begin(&nobody); MAX_OBSTACLES];
        let recent = vec![Recent::NOTHING; MAX_OBSTACLES];
        let level = noise.learned.map(|learned| NoiseLevel::new(learned, noise.position_sd_m));
        Some(Self { filter, noise, level, places, recent, free: u64::MAX })
    }

    /// Takes a place for a track that `detection` begins. There are as many places as tracks.
    pub(crate) fn take(&mut self, detection: &Detection) -> usize {
        let place = (self.free.trailing_zeros() as usize).min(MAX_OBSTACLES - 1);
        self.free &= !(1 << place);
        self.begin(place, detection);
        place
    }

    /// Gives the place of a track that has ended back.
    pub(crate) fn release(&mut self, place: usize) {
        self.free |= 1 << place;
    }

    /// Believes nothing at `place` but `detection`.
    pub(crate) fn begin(&mut self, place: usize, detection: &Detection) {
        self.places[place] = self.filter.begin(&self.sighting(detection));
        self.recent[place] = Recent::NOTHING;
        if measured_covariance(detection).is_none() {
            self.recent[place].take(0.0, detection.position_in_odom_m);
        }
    }

    /// What was learnt of the noise up to now holds for the sightings of the frame of `time_ns`.
    pub(crate) fn begin_frame(&mut self, time_ns: u64) {
        if let Some(level) = &mut self.level {
            level.begin_frame(time_ns);
        }
    }

    /// Standard deviation that positions are believed to have, m.
    pub(crate) fn position_sd_m(&self) -> f64 {
        self.level.as_ref().map_or(self.noise.position_sd_m, NoiseLevel::sd_m)
    }

    /// Evaluates what the sightings so far have shown of the noise, while no frame waits for it.
    pub(crate) fn settle(&mut self) {
        if let Some(level) = &mut self.level {
            level.settle();
        }
    }

    /// Takes a detection `elapsed_s` after the last one, s, and learns from it, unless perception itself says how noisy it is.
    /// Returns the velocity between the two newest sightings, m/s, if they are known to be exact enough to go before the belief.
    pub(crate) fn update(&mut self, place: usize, elapsed_s: f64, detection: &Detection) -> Option<[f64; 2]> {
        let mut sighting = self.sighting(detection);
        let mut exact_mps = None;
        let recent = &mut self.recent[place];
        if measured_covariance(detection).is_some() {
            *recent = Recent::NOTHING;
        } else {
            recent.take(elapsed_s, detection.position_in_odom_m);
            if let (Some(level), Some(residuals)) = (&mut self.level, recent.residuals()) {
                level.take(&residuals);
                let off_m = level.outlier_m(&residuals).unwrap_or(0.0);
                sighting.covariance_m2 += Matrix2::from_diagonal_element(off_m.powi(2));
                exact_mps = level.lets_differ(recent, &residuals).then(|| recent.difference_mps());
            }
        }
        self.filter.update(&mut self.places[place], elapsed_s, &sighting);
        exact_mps
    }

    /// What is believed `elapsed_s` after the last sighting, s.
    pub(crate) fn forecast(&self, place: usize, elapsed_s: f64) -> Forecast {
        self.filter.forecast(&self.places[place], elapsed_s)
    }

    /// The position and how uncertain it is: as measured where perception says so, else as believed.
    fn sighting(&self, detection: &Detection) -> Sighting {
        sighting_of(detection, self.position_sd_m())
    }

    /// The same, as uncertain as it may be and still belong to a track.
    pub(crate) fn doubtful_sighting(&self, detection: &Detection) -> Sighting {
        let believed_m = self.position_sd_m();
        let doubtful_m = match self.level {
            Some(_) => DOUBT * believed_m.max(self.noise.position_sd_m),
            None => believed_m,
        };
        sighting_of(detection, doubtful_m)
    }

    /// Share of the position's standard deviation that goes into the radius.
    pub(crate) fn radius_sds(&self) -> f64 {
        self.noise.radius_sds
    }
}

/// A sighting of `position_sd_m` unless perception says how uncertain it is.
fn sighting_of(detection: &Detection, position_sd_m: f64) -> Sighting {
    Sighting {
        position_m: detection.position_in_odom_m.into(),
        covariance_m2: measured_covariance(detection).unwrap_or_else(|| usual_covariance(position_sd_m)),
    }
}

fn usual_covariance(position_sd_m: f64) -> Matrix2<f64> {
    Matrix2::from_diagonal_element(position_sd_m.powi(2))
}

/// The detection's own covariance, if it has one that can be.
fn measured_covariance(detection: &Detection) -> Option<Matrix2<f64>> {
    let [xx, xy, yy] = detection.position_covariance_m2;
    let present = detection.flags & DetectionFlags::HAS_COVARIANCE != 0;
    let [least, most] = variances([xx, xy, yy]);
    let plausible = |variance_m2: f64| PLAUSIBLE_SD_M.contains(&variance_m2.sqrt());
    // A NaN is in no range.
    (present && plausible(least) && plausible(most)).then(|| Matrix2::new(xx, xy, xy, yy))
}

/// Variances of `[xx, xy, yy]` along its axes, the smaller one first.
fn variances([xx, xy, yy]: [f64; 3]) -> [f64; 2] {
    let (middle, half_width) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
    [middle - half_width, middle + half_width]
}

/// Standard deviation along the worst direction, m.
pub(crate) fn worst_sd_m(covariance_m2: &Matrix2<f64>) -> f64 {
    let [_, most] = variances([covariance_m2.m11, covariance_m2.m12, covariance_m2.m22]);
    most.sqrt()
}
