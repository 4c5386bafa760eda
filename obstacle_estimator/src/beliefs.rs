//! The beliefs of all tracks, and what detections mean to them.
//!
//! A belief is a kilobyte, so it does not travel with its track but keeps a place of its own, which the track names.

use messages::{Detection, DetectionFlags, MAX_OBSTACLES};
use nalgebra::{Matrix2, Vector2};
use settings::{EstimatorSettings, NoiseSettings};

use crate::motion::{Belief, Forecast, MotionFilter, Sighting};

/// Sightings within the ellipse that holds this share of them belong to the track: χ² of two degrees of freedom at 99 %.
pub(crate) const GATE_DISTANCE2: f64 = 9.210_340_371_976_184;

/// Standard deviations that a measured covariance may have, m. Anything else is a slip of perception.
const PLAUSIBLE_SD_M: std::ops::RangeInclusive<f64> = 1e-3..=10.0;

/// One belief for each track that there is room for.
#[derive(Debug)]
pub(crate) struct Beliefs {
    pub(crate) filter: MotionFilter,
    noise: NoiseSettings,
    places: Vec<Belief>,
    /// One bit a place, set while nobody has it.
    free: u64,
}

const _: () = assert!(MAX_OBSTACLES == u64::BITS as usize, "one bit for each place");

impl Beliefs {
    /// `None` if `settings` ask for no filter.
    pub(crate) fn new(settings: &EstimatorSettings) -> Option<Self> {
        let filter = MotionFilter::new(settings)?;
        let noise = settings.noise?;
        let nobody = Sighting { position_m: Vector2::zeros(), covariance_m2: usual_covariance(&noise) };
        let places = vec![filter.begin(&nobody); MAX_OBSTACLES];
        Some(Self { filter, noise, places, free: u64::MAX })
    }

    /// Takes a place for a track that `sighting` begins. There are as many places as tracks.
    pub(crate) fn take(&mut self, sighting: &Sighting) -> usize {
        let place = (self.free.trailing_zeros() as usize).min(MAX_OBSTACLES - 1);
        self.free &= !(1 << place);
        self.begin(place, sighting);
        place
    }

    /// Gives the place of a track that has ended back.
    pub(crate) fn release(&mut self, place: usize) {
        self.free |= 1 << place;
    }

    /// Believes nothing at `place` but `sighting`.
    pub(crate) fn begin(&mut self, place: usize, sighting: &Sighting) {
        self.places[place] = self.filter.begin(sighting);
    }

    /// Takes a sighting `elapsed_s` after the last one, s.
    pub(crate) fn update(&mut self, place: usize, elapsed_s: f64, sighting: &Sighting) {
        self.filter.update(&mut self.places[place], elapsed_s, sighting);
    }

    /// What is believed `elapsed_s` after the last sighting, s.
    pub(crate) fn forecast(&self, place: usize, elapsed_s: f64) -> Forecast {
        self.filter.forecast(&self.places[place], elapsed_s)
    }

    /// The position and how uncertain it is: as measured where perception says so, else as the settings do.
    pub(crate) fn sighting(&self, detection: &Detection) -> Sighting {
        Sighting {
            position_m: detection.position_in_odom_m.into(),
            covariance_m2: measured_covariance(detection).unwrap_or_else(|| usual_covariance(&self.noise)),
        }
    }

    /// Share of the position's standard deviation that goes into the radius.
    pub(crate) fn radius_sds(&self) -> f64 {
        self.noise.radius_sds
    }
}

fn usual_covariance(noise: &NoiseSettings) -> Matrix2<f64> {
    Matrix2::from_diagonal_element(noise.position_sd_m.powi(2))
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
