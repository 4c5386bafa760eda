//! Where the obstacles will be, step by step: what a demand is held against.

use optimal_control::{ConstraintRow, StageConstraints};

use super::{Demand, Passing, Point, Row};
use crate::surroundings::Seen;

/// What a row without an obstacle holds by. Finite, as the quadratic program wants it.
const ABSENT: f64 = 100.0;

/// The demands of one method, for up to a fixed number of obstacles that keep their velocities.
pub(crate) struct Avoidance<R> {
    pub(crate) demand: R,
    step_s: f64,
    rows_per_step: usize,
    /// The obstacles at the start of the plan, in its frame.
    obstacles: Vec<Seen>,
    /// The same during one step, and their rows.
    passing: Vec<Passing>,
    scratch: Vec<Row>,
}

impl<R: Demand> Avoidance<R> {
    /// Begins with typical obstacles, by which the quadratic program is scaled.
    pub(crate) fn new(demand: R, step_s: f64, rows_per_step: usize, typical: Seen) -> Self {
        Self {
            demand,
            step_s,
            rows_per_step,
            obstacles: vec![typical; rows_per_step],
            passing: Vec::with_capacity(rows_per_step),
            scratch: vec![ConstraintRow::constant(ABSENT); rows_per_step],
        }
    }

    /// Replaces the obstacles by the first of `seen`; `origin_m` of `odom` is the origin of the plan.
    pub(crate) fn place(&mut self, seen: &[Seen], origin_m: [f64; 2]) {
        self.obstacles.clear();
        self.obstacles.extend(seen.iter().take(self.rows_per_step).map(|obstacle| {
            let position_m = std::array::from_fn(|i| obstacle.position_m[i] - origin_m[i]);
            Seen { position_m, ..*obstacle }
        }));
    }

    fn pass(&mut self, step: usize) {
        let at = |obstacle: &Seen, step: usize| {
            let elapsed_s = step as f64 * self.step_s;
            std::array::from_fn(|i| obstacle.position_m[i] + elapsed_s * obstacle.velocity_mps[i])
        };
        self.passing.clear();
        self.passing.extend(self.obstacles.iter().map(|obstacle| Passing {
            position_m: at(obstacle, step),
            next_position_m: at(obstacle, step + 1),
            velocity_mps: obstacle.velocity_mps,
            heading_rad: obstacle.heading_rad,
            speed_mps: obstacle.speed_mps,
            contact_m: obstacle.contact_m,
        }));
    }
}

impl<R: Demand> StageConstraints<3, 2> for Avoidance<R> {
    fn rows_per_step(&self) -> usize {
        self.rows_per_step
    }

    fn values(&mut self, point: &Point, values: &mut [f64]) {
        self.pass(point.step);
        let count = self.passing.len();
        self.demand.fill(point, &self.passing, &mut self.scratch[..count]);
        values.fill(ABSENT);
        for (value, row) in values.iter_mut().zip(&self.scratch[..count]) {
            *value = row.value;
        }
    }

    fn linearise(&mut self, point: &Point, rows: &mut [Row]) {
        self.pass(point.step);
        let (present, absent) = rows.split_at_mut(self.passing.len());
        self.demand.fill(point, &self.passing, present);
        absent.fill(ConstraintRow::constant(ABSENT));
    }

    fn sparsity(&self) -> Row {
        self.demand.sparsity()
    }
}
