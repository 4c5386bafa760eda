//! Adam (Kingma and Ba), the paper's optimiser, with a warm-up and a cosine decay of the learning rate.

/// Decay of the first moment.
const BETA_1: f32 = 0.9;
/// Decay of the second moment.
const BETA_2: f32 = 0.999;
/// Keeps the step finite where a gradient vanishes.
const EPSILON: f32 = 1e-8;

/// State of the optimiser for one parameter vector.
#[derive(Debug, Clone)]
pub(crate) struct Adam {
    pub(crate) first: Vec<f32>,
    pub(crate) second: Vec<f32>,
    /// β₁ᵗ and β₂ᵗ, in double precision: they underflow slowly.
    pub(crate) powers: [f64; 2],
}

impl Adam {
    /// Moments at zero.
    pub(crate) fn new(parameters: usize) -> Self {
        Self { first: vec![0.0; parameters], second: vec![0.0; parameters], powers: [1.0; 2] }
    }

    /// One step against `gradient`.
    pub(crate) fn step(&mut self, parameters: &mut [f32], gradient: &[f32], learning_rate: f64) {
        self.powers[0] *= f64::from(BETA_1);
        self.powers[1] *= f64::from(BETA_2);
        let rate = (learning_rate / (1.0 - self.powers[0])) as f32;
        let correction = (1.0 / (1.0 - self.powers[1])) as f32;
        let moments = self.first.iter_mut().zip(&mut self.second);
        for ((p, &g), (m, v)) in parameters.iter_mut().zip(gradient).zip(moments) {
            *m = BETA_1 * *m + (1.0 - BETA_1) * g;
            *v = BETA_2 * *v + (1.0 - BETA_2) * g * g;
            *p -= rate * *m / ((*v * correction).sqrt() + EPSILON);
        }
    }
}

/// Learning rate over a run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Schedule {
    /// Highest rate.
    pub(crate) peak: f64,
    /// Rate of the last step.
    pub(crate) last: f64,
    /// Steps over which the rate rises from 0.
    pub(crate) warm_up: u64,
    /// All steps.
    pub(crate) steps: u64,
}

impl Schedule {
    /// Rate of step `step`, from 0.
    pub(crate) fn rate(&self, step: u64) -> f64 {
        if step < self.warm_up {
            return self.peak * (step + 1) as f64 / self.warm_up as f64;
        }
        let decaying = (self.steps - self.warm_up).max(2) - 1;
        let progress = (step - self.warm_up) as f64 / decaying as f64;
        self.last
            + (self.peak - self.last) * 0.5 * (1.0 + libm::cos(core::f64::consts::PI * progress.min(1.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_step_has_the_size_of_the_learning_rate() {
        let mut adam = Adam::new(2);
        let mut parameters = [1.0, 1.0];
        adam.step(&mut parameters, &[3.0, -0.01], 0.1);
        assert!((parameters[0] - 0.9).abs() < 1e-5 && (parameters[1] - 1.1).abs() < 1e-5);
    }

    #[test]
    fn schedule_rises_then_falls_to_its_last_rate() {
        let schedule = Schedule { peak: 1.0, last: 0.01, warm_up: 10, steps: 110 };
        assert!((schedule.rate(9) - 1.0).abs() < 1e-12);
        assert!((1..10).all(|s| schedule.rate(s) > schedule.rate(s - 1)));
        assert!((11..110).all(|s| schedule.rate(s) < schedule.rate(s - 1)));
        assert!((schedule.rate(109) - 0.01).abs() < 1e-12);
    }
}
