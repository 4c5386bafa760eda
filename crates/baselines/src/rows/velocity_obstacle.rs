//! VO-MPC: no velocity points into an obstacle's collision cone.

use optimal_control::ConstraintRow;

use super::{Demand, Passing, Point, Row};

/// Cosines and sines are cut here, as published, which keeps the inverse functions' slopes finite.
const CUT: f64 = 1.0 - 1e-3;
/// A relative speed or distance below this has no direction, m/s or m.
const NO_DIRECTION: f64 = 1e-6;

/// `α ≥ β` after Piccinelli, Vesentini and Muradore: at every step the angle `α` between the relative velocity
/// `v(cos θ, sin θ) − v_j` and the line to the obstacle is at least half the opening `β = asin(R_j / ‖p_j − x‖)` of the
/// cone that its disc fills. The cone has no end in time. Where a cut is active the slope is zero, as published: straight
/// at an obstacle no derivative says which way to turn.
#[derive(Debug, Clone, Copy)]
pub(crate) struct VoRows;

pub(crate) fn vo_row(point: &Point, obstacle: &Passing) -> Row {
    let (sin, cos) = point.state[2].sin_cos();
    let speed = point.control[0];
    let p: [f64; 2] = std::array::from_fn(|i| obstacle.position_m[i] - point.state[i]);
    let v = [speed * cos - obstacle.velocity_mps[0], speed * sin - obstacle.velocity_mps[1]];
    let distance = p[0].hypot(p[1]).max(NO_DIRECTION);
    let relative_speed = v[0].hypot(v[1]).max(NO_DIRECTION);

    let cosine = (p[0] * v[0] + p[1] * v[1]) / (distance * relative_speed);
    let alpha = cosine.clamp(-CUT, CUT).acos();
    let alpha_slope = if cosine.abs() < CUT { -1.0 / (1.0 - cosine * cosine).sqrt() } else { 0.0 };
    let sine = obstacle.contact_m / distance;
    let beta = sine.clamp(-CUT, CUT).asin();
    let beta_slope = if sine.abs() < CUT { 1.0 / (1.0 - sine * sine).sqrt() } else { 0.0 };

    // Derivatives by p and v; p falls as the robot moves.
    let by_p: [f64; 2] = std::array::from_fn(|i| {
        let cosine_by_p = (v[i] / relative_speed - cosine * p[i] / distance) / distance;
        let sine_by_p = -sine * p[i] / (distance * distance);
        alpha_slope * cosine_by_p - beta_slope * sine_by_p
    });
    let by_v: [f64; 2] = std::array::from_fn(|i| {
        alpha_slope * (p[i] / distance - cosine * v[i] / relative_speed) / relative_speed
    });
    Row {
        value: alpha - beta,
        by_state: [-by_p[0], -by_p[1], speed * (by_v[1] * cos - by_v[0] * sin)],
        by_control: [by_v[0] * cos + by_v[1] * sin, 0.0],
        by_next: [0.0; 3],
    }
}

impl Demand for VoRows {
    fn demands_at_start(&self) -> bool {
        false
    }

    fn sparsity(&self) -> Row {
        Row { by_state: [1.0; 3], by_control: [1.0, 0.0], ..ConstraintRow::constant(1.0) }
    }

    fn fill(&mut self, point: &Point, obstacles: &[Passing], rows: &mut [Row]) {
        for (row, obstacle) in rows.iter_mut().zip(obstacles) {
            *row = vo_row(point, obstacle);
        }
    }
}
