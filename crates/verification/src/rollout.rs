//! Closed loop of one pair, many at once: the obstacle moves, the CBF-QP answers, once per filter period.
//!
//! Not here: where the rollouts start and what is concluded (`scenario`).

use barrier::{CbfQp, MAX_OBSTACLES, QpError};
use rand::RngExt;
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

use crate::game::{Disturbance, Game};
use crate::scenario::ScenarioSettings;
use crate::subject::{Judge, Subject};

/// Most rollouts that advance together: one batch of the kernel.
pub(crate) const BATCH: usize = MAX_OBSTACLES;

/// What the robot would do alone, in relative coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NominalPolicy {
    /// Drives at the obstacle.
    TowardObstacle,
    /// The corner of the control box that lowers h fastest.
    LowersBarrier,
    /// Uniform in the control box, held for [`HOLD_S`].
    Random,
}

/// What the obstacle does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DisturbancePolicy {
    /// `argmin_d ∇h·ζ` at every cycle: the worst by the model's own gradient.
    LowersBarrier,
    /// Uniform in the disturbance box, held for [`HOLD_S`].
    Random,
    /// The admissible disturbance nearest to zero.
    Zero,
}

/// How long random inputs are held, s.
pub const HOLD_S: f64 = 0.5;

/// How one rollout went.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rollout {
    /// State at the start.
    pub(crate) start: [f64; 4],
    /// `h` at the start, m.
    pub(crate) start_h_m: f64,
    /// Smallest distance of the centres minus the radius, m.
    pub(crate) clearance_m: f64,
    /// Depth of contact that is forgiven, m.
    tolerance_m: f64,
    /// Whether the pair left the trained box at some time.
    pub(crate) left_box: bool,
    /// Whether it had left it before contact.
    pub(crate) left_before_contact: bool,
    /// Whether the QP had no finite answer at some cycle; counts as a failure.
    pub(crate) broken: bool,
}

impl Rollout {
    /// Returns whether the failure set was entered, or nothing sensible came out.
    pub(crate) fn failed(&self) -> bool {
        self.broken || self.in_contact()
    }

    fn in_contact(&self) -> bool {
        let kept_clear = self.clearance_m >= -self.tolerance_m; // false for a NaN
        !kept_clear
    }
}

/// Inputs of one rollout that live from cycle to cycle.
#[derive(Clone, Copy)]
struct Held {
    nominal: [f64; 2],
    disturbance: Disturbance,
    /// What the filter takes the obstacle's rate from: the last cycle's disturbance, as a backward difference would give.
    known: Disturbance,
}

/// Buffers of a batch of rollouts; advancing allocates nothing.
pub(crate) struct Pairs {
    states: Vec<[f64; 4]>,
    rollouts: Vec<Rollout>,
    held: Vec<Held>,
    qp: CbfQp<2>,
    tolerance_m: f64,
    cycles: usize,
    hold_cycles: usize,
}

impl Pairs {
    /// Sets up for the settings' filter.
    pub(crate) fn new(subject: &Subject<'_>, settings: &ScenarioSettings) -> Result<Self, QpError> {
        Ok(Self {
            states: Vec::with_capacity(BATCH),
            rollouts: Vec::with_capacity(BATCH),
            held: Vec::with_capacity(BATCH),
            qp: CbfQp::new(*subject.game().control_box(), settings.slack_weight)?,
            tolerance_m: settings.tolerance_m,
            cycles: (settings.horizon_s / settings.period_s).ceil() as usize,
            hold_cycles: ((HOLD_S / settings.period_s).round() as usize).max(1),
        })
    }

    /// Plays all pairs that start at `starts` (state and `h`) to the horizon.
    pub(crate) fn play(
        &mut self,
        subject: &Subject<'_>,
        settings: &ScenarioSettings,
        judge: &mut Judge,
        starts: &[([f64; 4], f64)],
    ) -> &[Rollout] {
        self.begin(subject, starts);
        for cycle in 0..self.cycles {
            self.step(subject, settings, judge, cycle);
        }
        &self.rollouts
    }

    fn begin(&mut self, subject: &Subject<'_>, starts: &[([f64; 4], f64)]) {
        self.states.clear();
        self.states.extend(starts.iter().map(|(z, _)| z));
        self.rollouts.clear();
        self.rollouts.extend(starts.iter().map(|&(start, start_h_m)| Rollout {
            start,
            start_h_m,
            clearance_m: subject.failure_m(&start),
            tolerance_m: self.tolerance_m,
            left_box: false,
            left_before_contact: false,
            broken: false,
        }));
        let nothing = Held { nominal: [0.0; 2], disturbance: [0.0; 2], known: [0.0; 2] };
        self.held.clear();
        self.held.resize(starts.len(), nothing);
    }

    /// One filter period of every pair.
    fn step(&mut self, subject: &Subject<'_>, settings: &ScenarioSettings, judge: &mut Judge, cycle: usize) {
        let game = subject.game();
        let renew = cycle.is_multiple_of(self.hold_cycles);
        if renew {
            self.draw(game, settings, &mut judge.rng);
        }
        let samples = judge.evaluate(&self.states);
        for (index, sample) in samples.iter().enumerate() {
            let (z, held, rollout) =
                (&mut self.states[index], &mut self.held[index], &mut self.rollouts[index]);
            if settings.disturbance == DisturbancePolicy::LowersBarrier {
                held.disturbance = game.worst_disturbance(z, &sample.gradient);
            }
            if cycle == 0 {
                // The obstacle has been seen before.
                held.known = held.disturbance;
            }
            let nominal = match settings.nominal {
                NominalPolicy::TowardObstacle => game.pursuit(z),
                NominalPolicy::LowersBarrier => game.worst_control(z, &sample.gradient),
                NominalPolicy::Random => held.nominal,
            };
            rollout.left_box |= sample.outside_domain;
            if !rollout.in_contact() {
                rollout.left_before_contact = rollout.left_box;
            }
            let row = game.row(z, sample.h_bar, &sample.gradient, &held.known, settings.alpha_per_s);
            match self.qp.solve(&nominal, Some(&row)) {
                Ok(solution) => {
                    let next = integrate(game, z, &solution.u, &held.disturbance, settings.period_s);
                    rollout.clearance_m = rollout.clearance_m.min(closest_m(z, &next) - subject.radius_m());
                    *z = next;
                }
                Err(_) => rollout.broken = true,
            }
            held.known = held.disturbance;
        }
    }

    /// Draws the held inputs anew; the nearest disturbance to zero where nothing is drawn.
    fn draw(&mut self, game: &Game, settings: &ScenarioSettings, rng: &mut Pcg64) {
        let (control, (low, high)) = (game.control_box(), game.disturbance_ends());
        for held in &mut self.held {
            if settings.nominal == NominalPolicy::Random {
                held.nominal = uniform(&control.min, &control.max, rng);
            }
            match settings.disturbance {
                DisturbancePolicy::LowersBarrier => {}
                DisturbancePolicy::Random => held.disturbance = uniform(&low, &high, rng),
                DisturbancePolicy::Zero => {
                    held.disturbance = std::array::from_fn(|k| 0.0_f64.clamp(low[k], high[k]));
                }
            }
        }
    }
}

fn uniform(low: &[f64; 2], high: &[f64; 2], rng: &mut Pcg64) -> [f64; 2] {
    std::array::from_fn(|k| rng.random_range(low[k]..=high[k]))
}

/// One step of the classical Runge–Kutta method with both inputs held. Exact for double integrators; for a unicycle the error
/// of a 4 ms step is below 1e-12 m.
fn integrate(game: &Game, z: &[f64; 4], u: &[f64; 2], d: &Disturbance, period_s: f64) -> [f64; 4] {
    let ahead = |k: &[f64; 4], s: f64| std::array::from_fn(|i| z[i] + s * k[i]);
    let k1 = game.flow(z, u, d);
    let k2 = game.flow(&ahead(&k1, 0.5 * period_s), u, d);
    let k3 = game.flow(&ahead(&k2, 0.5 * period_s), u, d);
    let k4 = game.flow(&ahead(&k3, period_s), u, d);
    std::array::from_fn(|i| z[i] + period_s / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
}

/// Smallest distance from the origin to the segment between two relative positions, m: contact between two cycles counts.
fn closest_m(from: &[f64; 4], to: &[f64; 4]) -> f64 {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let squared = dx * dx + dy * dy;
    let along = if squared > 0.0 { (-(from[0] * dx + from[1] * dy) / squared).clamp(0.0, 1.0) } else { 0.0 };
    let (x, y) = (from[0] + along * dx, from[1] + along * dy);
    (x * x + y * y).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use dynamics::{DoubleIntegratorPair, InputBox};

    #[test]
    fn contact_between_two_cycles_is_seen() {
        assert_eq!(closest_m(&[-1.0, 0.5, 0.0, 0.0], &[1.0, 0.5, 0.0, 0.0]), 0.5);
        assert_eq!(closest_m(&[3.0, 4.0, 0.0, 0.0], &[6.0, 8.0, 0.0, 0.0]), 5.0);
        assert_eq!(closest_m(&[3.0, 4.0, 0.0, 0.0], &[3.0, 4.0, 1.0, 1.0]), 5.0);
    }

    #[test]
    fn double_integrators_follow_their_parabola() {
        let any = InputBox::new([-2.0; 2], [2.0; 2]).unwrap();
        let game = Game::DoubleIntegrator(DoubleIntegratorPair { control: any, disturbance: any });
        let z = integrate(&game, &[1.0, 2.0, 0.5, -0.5], &[1.0, 0.0], &[0.0, 2.0], 0.1);
        let expected = [1.0 + 0.05 - 0.005, 2.0 - 0.05 + 0.01, 0.4, -0.3];
        for i in 0..4 {
            assert!((z[i] - expected[i]).abs() < 1e-15, "{z:?}");
        }
    }
}
