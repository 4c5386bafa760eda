//! How noisy positions are, learnt from the positions alone.
//!
//! Over four sightings a walk is nearly a parabola, whose third divided difference is zero: what is left of it is white
//! noise. Statistics calls that difference-based variance estimation. No motion model takes part in it.

use settings::LearnedNoiseSettings;

use crate::recent::{Recent, Residuals};

/// Newest residuals that count.
const WINDOW: usize = 512;
/// Fewer residuals than this change no belief.
const ENOUGH: usize = 64;
/// About as many are taken of a frame. One bad frame, an odometry that jumps, is in four residuals of everybody: so it stays
/// below the tenth that the quantile leaves out.
const A_FRAME: usize = 12;
/// The share of residuals that is meant to lie below [`QUANTILE_SDS`] σ. Nine tenths rather than half: where noise is not
/// the same everywhere, say grows with the distance, the worse part counts unless it is rare.
const SHARE: f64 = 0.9;
/// The quantile of |N(0, 1)| at [`SHARE`].
const QUANTILE_SDS: f64 = 1.644_853_626_951_472_7;
/// Frames that teach nothing for so long, ns, leave nothing learnt: eyes that see more rarely see differently.
const FORGET_AFTER_NS: u64 = 5_000_000_000;
/// Nobody changes an acceleration faster from one interval to the next, m/s².
const MOST_STEP_MPS2: f64 = 15.0;
/// A residual beyond this is no noise of the usual kind, in standard deviations.
const OUTLIER_SDS: f64 = 3.0;

/// The standard deviation that positions are believed to have, common to all obstacles.
#[derive(Debug)]
pub(crate) struct NoiseLevel {
    settings: LearnedNoiseSettings,
    /// Believed until there is more to go by, m.
    first_sd_m: f64,
    /// What the residuals show, whatever may be believed; `None` until they are enough, m.
    shown_m: Option<f64>,
    /// Whether `shown_m` is what the residuals below show.
    settled: bool,
    /// Magnitudes of the newest residuals, in no order of time once the ring is full, m.
    residuals_m: Box<[f64; WINDOW]>,
    count: usize,
    next: usize,
    /// Residuals that the frame at hand has had, and of how many one is taken.
    offered: usize,
    one_of: usize,
    /// Frames so far: they take turns in whose residuals they take.
    turn: usize,
    frame_ns: u64,
    taught_at_ns: u64,
}

impl NoiseLevel {
    /// `first_sd_m` is believed until there are sightings enough.
    pub(crate) fn new(settings: LearnedNoiseSettings, first_sd_m: f64) -> Self {
        Self {
            settings,
            first_sd_m,
            shown_m: None,
            settled: true,
            residuals_m: Box::new([0.0; WINDOW]),
            count: 0,
            next: 0,
            offered: 0,
            one_of: 1,
            turn: 0,
            frame_ns: 0,
            taught_at_ns: 0,
        }
    }

    /// What is believed, m.
    pub(crate) fn sd_m(&self) -> f64 {
        let LearnedNoiseSettings { least_sd_m, most_sd_m, .. } = self.settings;
        self.shown_m.map_or(self.first_sd_m, |shown_m| shown_m.clamp(least_sd_m, most_sd_m))
    }

    /// Believes of the frame of `time_ns` what the frames before it have shown.
    pub(crate) fn begin_frame(&mut self, time_ns: u64) {
        if self.offered > 0 {
            self.taught_at_ns = self.frame_ns;
        }
        self.frame_ns = time_ns;
        self.one_of = self.offered.div_ceil(A_FRAME).max(1);
        self.offered = 0;
        self.turn = self.turn.wrapping_add(1);
        if time_ns.saturating_sub(self.taught_at_ns) > FORGET_AFTER_NS {
            self.count = 0;
            self.next = 0;
            self.settled = false;
        }
        self.settle();
    }

    /// Evaluates the residuals, which takes a few µs: better between two frames than while one waits. A frame does it if nobody has.
    pub(crate) fn settle(&mut self) {
        if self.settled {
            return;
        }
        self.settled = true;
        self.shown_m = (self.count >= ENOUGH).then(|| {
            let mut ordered = *self.residuals_m;
            let known = &mut ordered[..self.count];
            let place = (SHARE * self.count as f64) as usize;
            let (_, quantile_m, _) = known.select_nth_unstable_by(place, f64::total_cmp);
            *quantile_m / QUANTILE_SDS
        });
    }

    /// Takes what the newest sightings of one obstacle tell.
    pub(crate) fn take(&mut self, residuals: &Residuals) {
        for residual_m in residuals.along_m.into_iter().flatten() {
            self.offered += 1;
            if (self.turn + self.offered).is_multiple_of(self.one_of) {
                self.settled = false;
                self.residuals_m[self.next] = residual_m.abs();
                self.next = (self.next + 1) % WINDOW;
                self.count = WINDOW.min(self.count + 1);
            }
        }
    }

    /// How far the newest sighting may be off, m, if its residuals are neither noise as usual nor what people do.
    pub(crate) fn outlier_m(&self, residuals: &Residuals) -> Option<f64> {
        let outlier = residuals.step_mps2 > MOST_STEP_MPS2 && residuals.largest_m > OUTLIER_SDS * self.sd_m();
        outlier.then_some(residuals.largest_m * residuals.newest_m_per_m)
    }

    /// Whether the velocity between the two newest sightings is exact enough to go before the models.
    pub(crate) fn lets_differ(&self, recent: &Recent, residuals: &Residuals) -> bool {
        let least_s = recent.shortest_interval_s();
        let exact = |shown_m| shown_m * std::f64::consts::SQRT_2 / least_s <= self.settings.difference_sd_mps;
        self.shown_m.is_some_and(exact) && residuals.step_mps2 <= MOST_STEP_MPS2
    }
}
