//! What is believed of one obstacle's motion, and how sightings change it: a Kalman filter, or several side by side.
//!
//! Lives here: the interacting multiple models (IMM) over linear models, of which a single Kalman filter is the case of
//! one model. Every model has the state `[x, y, vx, vy, ax, ay]` in `odom`, m, m/s, m/s². Not here: which sighting
//! belongs to whom, and what of a belief reaches the filter.

mod hypothesis;
mod model;

use nalgebra::{Matrix2, Matrix6, Vector2, Vector6};
use settings::{EstimatorKind, EstimatorSettings, ImmSettings, KalmanSettings, NoiseSettings};

use hypothesis::Hypothesis;
pub use model::MotionModel;
use model::Stride;

/// Most models side by side.
pub const MAX_MODELS: usize = 3;

/// A measured position with its covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// `[x, y]` in `odom`, m.
    pub position_m: Vector2<f64>,
    /// Covariance, m². Positive definite.
    pub covariance_m2: Matrix2<f64>,
}

/// Mean and covariance of position, velocity and acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// `[x, y, vx, vy, ax, ay]`, m, m/s, m/s².
    pub mean: Vector6<f64>,
    /// Covariance of `mean`, in its units.
    pub covariance: Matrix6<f64>,
}

/// What a belief says of the time ahead: the mean, and how uncertain the position is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Forecast {
    /// `[x, y, vx, vy, ax, ay]`, m, m/s, m/s².
    pub mean: Vector6<f64>,
    /// Covariance of the position, m².
    pub position_covariance_m2: Matrix2<f64>,
}

impl Forecast {
    /// The predicted position, m.
    pub fn position_m(&self) -> Vector2<f64> {
        self.mean.fixed_rows::<2>(0).into_owned()
    }

    /// Squared Mahalanobis distance of `sighting` from the prediction, and the logarithm of the determinant of the
    /// covariance that it refers to; twice the negative log-likelihood is their sum, but for a constant.
    pub fn surprise(&self, sighting: &Sighting) -> (f64, f64) {
        let innovation = sighting.position_m - self.position_m();
        hypothesis::surprise(&innovation, &(self.position_covariance_m2 + sighting.covariance_m2))
    }
}

/// What is believed of one obstacle at its newest sighting. Without meaning apart from its [`MotionFilter`].
#[derive(Debug, Clone, Copy)]
pub struct Belief {
    hypotheses: [Hypothesis; MAX_MODELS],
    probabilities: [f64; MAX_MODELS],
}

impl Belief {
    /// How probable each model is; zero beyond the models in use.
    pub fn probabilities(&self) -> &[f64; MAX_MODELS] {
        &self.probabilities
    }
}

/// The models and how one follows another. Shared by all obstacles; allocates nothing.
#[derive(Debug, Clone)]
pub struct MotionFilter {
    models: [MotionModel; MAX_MODELS],
    count: usize,
    mean_stay_s: f64,
    initial_speed_variance_m2ps2: f64,
}

impl MotionFilter {
    /// The filter that `settings` ask for; `None` if they ask for none. Settings are validated when they are read.
    pub fn new(settings: &EstimatorSettings) -> Option<Self> {
        let noise = settings.noise.as_ref()?;
        match settings.kind {
            EstimatorKind::BackwardDifference | EstimatorKind::Provided => None,
            EstimatorKind::Kalman => settings.kalman.as_ref().map(|kalman| Self::kalman(kalman, noise)),
            EstimatorKind::Imm => settings.imm.as_ref().map(|imm| Self::imm(imm, noise)),
        }
    }

    /// One Kalman filter of constant velocity.
    pub fn kalman(kalman: &KalmanSettings, noise: &NoiseSettings) -> Self {
        let model = MotionModel::ConstantVelocity { acceleration_sd_mps2: kalman.acceleration_sd_mps2 };
        Self {
            models: [model; MAX_MODELS],
            count: 1,
            mean_stay_s: f64::INFINITY,
            initial_speed_variance_m2ps2: noise.initial_speed_sd_mps.powi(2),
        }
    }

    /// Interacting multiple models: calm, lively and, if the settings have one, a manoeuvre.
    pub fn imm(imm: &ImmSettings, noise: &NoiseSettings) -> Self {
        let walk = |acceleration_sd_mps2| MotionModel::ConstantVelocity { acceleration_sd_mps2 };
        let lively = walk(imm.lively_acceleration_sd_mps2);
        let third = imm.manoeuvre.map(|manoeuvre| MotionModel::Manoeuvre {
            acceleration_sd_mps2: manoeuvre.acceleration_sd_mps2,
            time_constant_s: manoeuvre.time_constant_s,
        });
        Self {
            models: [walk(imm.calm_acceleration_sd_mps2), lively, third.unwrap_or(lively)],
            count: 2 + usize::from(third.is_some()),
            mean_stay_s: imm.mean_stay_s,
            initial_speed_variance_m2ps2: noise.initial_speed_sd_mps.powi(2),
        }
    }

    /// What a first sighting lets believe: the velocity is zero, give or take; every model is as likely as the others.
    pub fn begin(&self, sighting: &Sighting) -> Belief {
        let mut belief = Belief {
            hypotheses: self
                .models
                .map(|model| Hypothesis::begin(&model, sighting, self.initial_speed_variance_m2ps2)),
            probabilities: [0.0; MAX_MODELS],
        };
        belief.probabilities[..self.count].fill(1.0 / self.count as f64);
        belief
    }

    /// Takes a sighting `elapsed_s` after the last one, s, > 0: the IMM's cycle of mixing, predicting, correcting and
    /// weighing.
    pub fn update(&self, belief: &mut Belief, elapsed_s: f64, sighting: &Sighting) {
        let predicted_probabilities =
            if self.count > 1 { self.mix(belief, elapsed_s) } else { belief.probabilities };
        let mut log_likelihoods = [f64::NEG_INFINITY; MAX_MODELS];
        for j in 0..self.count {
            let hypothesis = &mut belief.hypotheses[j];
            hypothesis.predict(&self.models[j].stride(elapsed_s));
            log_likelihoods[j] = hypothesis.correct(sighting);
        }
        if self.count > 1 {
            belief.probabilities = weigh(&predicted_probabilities, &log_likelihoods);
        }
    }

    /// Mean and covariance `elapsed_s` after the newest sighting, s, moment-matched over the models.
    pub fn estimate(&self, belief: &Belief, elapsed_s: f64) -> Estimate {
        let mut hypotheses = belief.hypotheses;
        for (hypothesis, stride) in hypotheses.iter_mut().zip(self.strides(elapsed_s)) {
            hypothesis.predict(&stride);
        }
        let combined = combine(&hypotheses[..self.count], &belief.probabilities[..self.count]);
        Estimate { mean: combined.mean, covariance: combined.covariance }
    }

    /// The same without what a cycle has no use for.
    pub fn forecast(&self, belief: &Belief, elapsed_s: f64) -> Forecast {
        let strides = self.strides(elapsed_s);
        let means: [_; MAX_MODELS] =
            std::array::from_fn(|j| strides[j].mean_after(&belief.hypotheses[j].mean));
        let weights = &belief.probabilities[..self.count];
        let mean = weights.iter().zip(&means).map(|(&weight, mean)| mean * weight).sum::<Vector6<f64>>();
        let mut position_covariance_m2 = Matrix2::zeros();
        for (j, &weight) in weights.iter().enumerate() {
            let offset = (means[j] - mean).fixed_rows::<2>(0).into_owned();
            let own = belief.hypotheses[j].position_covariance_after(&strides[j]);
            position_covariance_m2 += (own + offset * offset.transpose()) * weight;
        }
        Forecast { mean, position_covariance_m2 }
    }

    fn strides(&self, elapsed_s: f64) -> [Stride; MAX_MODELS] {
        self.models.map(|model| model.stride(elapsed_s))
    }

    /// Probability that a model is still, or anew, the right one after `elapsed_s`, and that a given other one is: motions
    /// last `mean_stay_s` on average, each other one is as likely to follow, and two halves of a time do what the whole does.
    fn transition(&self, elapsed_s: f64) -> (f64, f64) {
        let n = self.count as f64;
        let change = -(-n * elapsed_s / ((n - 1.0) * self.mean_stay_s)).exp_m1();
        (1.0 - (n - 1.0) / n * change, change / n)
    }

    /// Gives every model the start that its predecessors suggest, and returns how probable each model is before the sighting.
    fn mix(&self, belief: &mut Belief, elapsed_s: f64) -> [f64; MAX_MODELS] {
        let (stay, change) = self.transition(elapsed_s);
        let before = &belief.hypotheses[..self.count];
        let mut mixed = belief.hypotheses;
        let mut predicted = [0.0; MAX_MODELS];
        for j in 0..self.count {
            let joint: [f64; MAX_MODELS] =
                std::array::from_fn(|i| belief.probabilities[i] * if i == j { stay } else { change });
            predicted[j] = joint.iter().sum();
            let weights = joint.map(|probability| probability / predicted[j]);
            mixed[j] = combine(before, &weights[..self.count]);
        }
        belief.hypotheses = mixed;
        predicted
    }
}

/// The normal distribution with the mean and covariance of the mixture.
fn combine(hypotheses: &[Hypothesis], weights: &[f64]) -> Hypothesis {
    let mean = hypotheses
        .iter()
        .zip(weights)
        .map(|(hypothesis, &weight)| hypothesis.mean * weight)
        .sum::<Vector6<f64>>();
    let mut covariance = Matrix6::zeros();
    for (hypothesis, &weight) in hypotheses.iter().zip(weights) {
        let offset = hypothesis.mean - mean;
        covariance += (hypothesis.covariance + offset * offset.transpose()) * weight;
    }
    Hypothesis { mean, covariance }
}

/// Probabilities after the sighting. Likelihoods relative to the largest, so that no surprise underflows them all.
fn weigh(predicted: &[f64; MAX_MODELS], log_likelihoods: &[f64; MAX_MODELS]) -> [f64; MAX_MODELS] {
    let largest = log_likelihoods.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let joint: [f64; MAX_MODELS] =
        std::array::from_fn(|j| predicted[j] * (log_likelihoods[j] - largest).exp());
    let total: f64 = joint.iter().sum();
    joint.map(|probability| probability / total)
}
