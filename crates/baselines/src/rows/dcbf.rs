//! DCBF-MPC: the distance as a discrete-time control barrier function.

use optimal_control::ConstraintRow;

use super::sdf::signed_distance;
use super::{Demand, Passing, Point, Row};

/// `h_{k+1} ≥ (1 − γ) h_k` with `h = ‖p_j − x‖ − R_j`, after Zeng, Zhang and Sreenath.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DcbfRows {
    /// `γ`.
    pub(crate) gamma: f64,
}

impl Demand for DcbfRows {
    fn demands_at_start(&self) -> bool {
        false
    }

    fn sparsity(&self) -> Row {
        Row { by_state: [1.0, 1.0, 0.0], by_next: [1.0, 1.0, 0.0], ..ConstraintRow::constant(1.0) }
    }

    fn fill(&mut self, point: &Point, obstacles: &[Passing], rows: &mut [Row]) {
        let kept = 1.0 - self.gamma;
        for (row, obstacle) in rows.iter_mut().zip(obstacles) {
            let (now, by_now) = signed_distance(&point.state, obstacle.position_m, obstacle.contact_m);
            let (next, by_next) = signed_distance(&point.next, obstacle.next_position_m, obstacle.contact_m);
            *row = Row {
                by_state: [-kept * by_now[0], -kept * by_now[1], 0.0],
                by_next: [by_next[0], by_next[1], 0.0],
                ..ConstraintRow::constant(next - kept * now)
            };
        }
    }
}
