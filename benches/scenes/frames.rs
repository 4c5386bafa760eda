//! The estimator at 20 frames a second.

use bytemuck::Zeroable;
use messages::{Detection, Detections, Obstacles};
use obstacle_estimator::Estimator;
use settings::EstimatorKind;

use super::{NS_PER_MS, START_NS, person};

/// The shipped estimator and the published one, and what tables call them.
pub const ESTIMATORS: [(&str, EstimatorKind); 2] =
    [("imm", EstimatorKind::Imm), ("difference", EstimatorKind::BackwardDifference)];

const FRAME_PERIOD_NS: u64 = 50 * NS_PER_MS;

/// `Estimator::step` on frames of people who walk, named or anonymous.
pub struct EstimatorStep {
    estimator: Estimator,
    frame: Box<Detections>,
    frames: u64,
    named: bool,
}

impl EstimatorStep {
    pub fn new(kind: EstimatorKind, people: usize, named: bool) -> Self {
        let estimator = Estimator::new(settings::EstimatorSettings { kind, ..super::settings().estimator });
        let mut frame = Box::new(Detections::zeroed());
        frame.count = people as u32;
        let mut step = Self { estimator, frame, frames: 0, named };
        for _ in 0..3 {
            step.perceive();
            step.step();
        }
        step
    }

    /// Writes the next frame: everybody walks to and fro, so that nobody leaves however long it lasts.
    pub fn perceive(&mut self) {
        self.frames += 1;
        let now_ns = START_NS + self.frames * FRAME_PERIOD_NS;
        let way_s = (now_ns as f64 * 1e-9).sin();
        self.frame.stamp = super::stamp(now_ns);
        let count = self.frame.count as usize;
        for (index, detection) in self.frame.items.iter_mut().take(count).enumerate() {
            let person = person(index);
            let ([x, y], [vx, vy]) = (person.position_in_odom_m, person.velocity_in_odom_mps);
            *detection = Detection {
                track_id: if self.named { person.track_id } else { 0 },
                position_in_odom_m: [x + vx * way_s, y + vy * way_s],
                radius_m: person.radius_m,
                class: 1,
                ..Detection::zeroed()
            };
        }
    }

    pub fn step(&mut self) -> &Obstacles {
        self.estimator.step(&self.frame, self.frame.stamp.valid_at_ns)
    }
}
