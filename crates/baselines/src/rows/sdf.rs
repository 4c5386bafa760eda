//! SDF-MPC: the signed distance is not negative at any step.

use optimal_control::ConstraintRow;

use super::{Demand, Passing, Point, Row};

/// `‖p_j − x_{k+1}‖ − R_j ≥ 0`, the dual collision constraint of Zhang, Liniger and Borrelli for a disc among discs.
///
/// Published for `k = 0 … N`. The robot's present place is no decision, so it is no row here; where it violates the
/// demand the verdict says so.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SdfRows;

/// Signed distance and its gradient by the robot's position; zero gradient where the centres meet.
pub(crate) fn signed_distance(robot: &[f64; 3], obstacle_m: [f64; 2], contact_m: f64) -> (f64, [f64; 2]) {
    let away = [robot[0] - obstacle_m[0], robot[1] - obstacle_m[1]];
    let distance = away[0].hypot(away[1]);
    let gradient = if distance > 0.0 { [away[0] / distance, away[1] / distance] } else { [0.0; 2] };
    (distance - contact_m, gradient)
}

pub(crate) fn sdf_row(point: &Point, obstacle: &Passing) -> Row {
    let (value, [x, y]) = signed_distance(&point.next, obstacle.next_position_m, obstacle.contact_m);
    Row { by_next: [x, y, 0.0], ..ConstraintRow::constant(value) }
}

impl Demand for SdfRows {
    fn demands_at_start(&self) -> bool {
        true
    }

    fn sparsity(&self) -> Row {
        Row { by_next: [1.0, 1.0, 0.0], ..ConstraintRow::constant(1.0) }
    }

    fn fill(&mut self, point: &Point, obstacles: &[Passing], rows: &mut [Row]) {
        for (row, obstacle) in rows.iter_mut().zip(obstacles) {
            *row = sdf_row(point, obstacle);
        }
    }
}
