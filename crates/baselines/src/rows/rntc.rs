//! RNTC-MPC: the signed distance on the way, a value function at the end.

use barrier::{Kernel, KernelError, Model, RelativeBarrier, RelativeObstacle, RelativeSample};
use dynamics::{RobotObstaclePair, UnicyclePair};
use optimal_control::ConstraintRow;

use super::sdf::sdf_row;
use super::{Demand, Passing, Point, Row};

/// `‖p_j − x_{k+1}‖ − R_j ≥ 0` before the last state, `h̄_Θ(z_j(x_N, o_N)) ≥ margin` there. In what this differs from the
/// published method, [`crate::RntcParameters`] says.
pub(crate) struct RntcRows {
    value_function: RelativeBarrier,
    pair: UnicyclePair,
    last_step: usize,
    terminal_margin_m: f64,
    /// The obstacles at the end of the plan and what the network says of them.
    relative: Vec<RelativeObstacle>,
    samples: Vec<RelativeSample>,
}

impl RntcRows {
    pub(crate) fn new(
        model: &Model,
        kernel: Kernel,
        pair: UnicyclePair,
        last_step: usize,
        terminal_margin_m: f64,
    ) -> Result<Self, KernelError> {
        Ok(Self {
            value_function: RelativeBarrier::new(model, kernel)?,
            pair,
            last_step,
            terminal_margin_m,
            relative: Vec::with_capacity(barrier::MAX_OBSTACLES),
            samples: Vec::with_capacity(barrier::MAX_OBSTACLES),
        })
    }
}

impl Demand for RntcRows {
    fn demands_at_start(&self) -> bool {
        true
    }

    fn sparsity(&self) -> Row {
        Row { by_next: [1.0; 3], ..ConstraintRow::constant(1.0) }
    }

    fn fill(&mut self, point: &Point, obstacles: &[Passing], rows: &mut [Row]) {
        if point.step != self.last_step {
            for (row, obstacle) in rows.iter_mut().zip(obstacles) {
                *row = sdf_row(point, obstacle);
            }
            return;
        }
        let frame = self.pair.robot_frame(&point.next);
        self.relative.clear();
        self.relative.extend(obstacles.iter().map(|obstacle| {
            let [x, y] = obstacle.next_position_m;
            let state = [x, y, obstacle.heading_rad, obstacle.speed_mps];
            RelativeObstacle { z: self.pair.relative_state_in(&frame, &state), radius_m: obstacle.contact_m }
        }));
        self.samples.resize(obstacles.len(), RelativeSample::default());
        self.value_function.evaluate(&self.relative, &mut self.samples);
        for ((row, sample), obstacle) in rows.iter_mut().zip(&self.samples).zip(&self.relative) {
            let by_robot = self.pair.relative_state_by_robot(&frame, &obstacle.z);
            *row = Row {
                by_next: std::array::from_fn(|j| (0..4).map(|i| sample.gradient[i] * by_robot[i][j]).sum()),
                ..ConstraintRow::constant(sample.h_bar - self.terminal_margin_m)
            };
        }
    }
}
