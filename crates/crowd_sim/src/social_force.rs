//! The forces of the social force model between pedestrians, as lightsfm defines and HuNavSim parametrises them.
//!
//! Forces are accelerations (unit mass). Obstacle and group forces are absent: the arena has no walls and nobody walks
//! in a group. The robot exerts none either, because people here ignore it. What people do with a force is in `crowd`.

use std::f64::consts::PI;

/// Weights and ranges of the model. Dimensionless unless the name carries a unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SocialForce {
    /// Weight of the pull towards the goal, `w_g`.
    pub goal_factor: f64,
    /// Time in which a lone walker would reach the desired velocity at weight one, `τ`, s.
    pub relaxation_time_s: f64,
    /// Weight of the push between people, `w_s`.
    pub social_factor: f64,
    /// Share of relative velocity in the interaction direction, `λ`, s/m.
    pub relative_velocity_weight: f64,
    /// Range of the push per length of the interaction vector, `γ`, m.
    pub interaction_range_m: f64,
    /// Angular sharpness of the slowing part, `n'`.
    pub velocity_sharpness: f64,
    /// Angular sharpness of the sideways part, `n`.
    pub angular_sharpness: f64,
}

impl SocialForce {
    /// The values HuNavSim effectively runs with: lightsfm's, except for the social factor, which it overrides with 5.
    pub const HUNAVSIM: Self = Self {
        goal_factor: 2.0,
        relaxation_time_s: 0.5,
        social_factor: 5.0,
        relative_velocity_weight: 2.0,
        interaction_range_m: 0.35,
        velocity_sharpness: 3.0,
        angular_sharpness: 2.0,
    };

    /// Pull towards `goal_m`: `w_g (v_d e − v)/τ` outside the goal's radius, plain braking `−v/τ` inside.
    ///
    /// Positions in m, `velocity_mps` and `desired_speed_mps` in m/s; returns m/s².
    pub fn goal_force(
        &self,
        position_m: [f64; 2],
        velocity_mps: [f64; 2],
        desired_speed_mps: f64,
        goal_m: [f64; 2],
        goal_radius_m: f64,
    ) -> [f64; 2] {
        let [dx, dy] = [goal_m[0] - position_m[0], goal_m[1] - position_m[1]];
        let distance = dx.hypot(dy);
        let [vx, vy] = velocity_mps;
        if distance <= goal_radius_m {
            return [-vx / self.relaxation_time_s, -vy / self.relaxation_time_s];
        }
        let gain = self.goal_factor / self.relaxation_time_s;
        [gain * (desired_speed_mps * dx / distance - vx), gain * (desired_speed_mps * dy / distance - vy)]
    }

    /// Push that person `j` exerts on person `i`: `w_s (f_v t + f_θ n)`, with centre distance, radii unused.
    ///
    /// Two people in exactly the same place, or whose interaction vector vanishes, have no direction to push in and
    /// exert nothing; an exactly head-on pair slows down but feels no sideways part, as in lightsfm.
    /// Positions in m, velocities in m/s; returns m/s².
    pub fn pair_force(
        &self,
        position_i_m: [f64; 2],
        velocity_i_mps: [f64; 2],
        position_j_m: [f64; 2],
        velocity_j_mps: [f64; 2],
    ) -> [f64; 2] {
        let [dx, dy] = [position_j_m[0] - position_i_m[0], position_j_m[1] - position_i_m[1]];
        let d = dx.hypot(dy);
        if d == 0.0 {
            return [0.0, 0.0];
        }
        let [ex, ey] = [dx / d, dy / d];
        let lambda = self.relative_velocity_weight;
        let [ix, iy] = [
            lambda * (velocity_i_mps[0] - velocity_j_mps[0]) + ex,
            lambda * (velocity_i_mps[1] - velocity_j_mps[1]) + ey,
        ];
        let interaction = ix.hypot(iy);
        if interaction == 0.0 {
            return [0.0, 0.0];
        }
        let [tx, ty] = [ix / interaction, iy / interaction];
        let b = self.interaction_range_m * interaction;
        let theta = angle_between([ix, iy], [ex, ey]);
        let f_v = -(-d / b - (self.velocity_sharpness * b * theta).powi(2)).exp();
        let side = if theta == 0.0 { 0.0 } else { theta.signum() };
        let f_theta = -side * (-d / b - (self.angular_sharpness * b * theta).powi(2)).exp();
        let [nx, ny] = [-ty, tx];
        [self.social_factor * (f_v * tx + f_theta * nx), self.social_factor * (f_v * ty + f_theta * ny)]
    }
}

/// Angle from `from` to `to`, rad in (−π, π]: θ = ang(ê) − ang(t), lightsfm's interval.
///
/// Taken from the cross product, so that parallel vectors give exactly zero. The difference of two angles would leave a
/// rounding error, whose sign alone decides to which side people step: everybody at rest would be pushed at random.
fn angle_between(from: [f64; 2], to: [f64; 2]) -> f64 {
    let cross = from[0] * to[1] - from[1] * to[0];
    let dot = from[0] * to[0] + from[1] * to[1];
    if cross == 0.0 && dot < 0.0 { PI } else { cross.atan2(dot) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: SocialForce = SocialForce::HUNAVSIM;

    #[test]
    fn a_lone_walker_is_pulled_with_gain_four_per_second() {
        let force = MODEL.goal_force([0.0, 0.0], [0.0, 0.0], 1.2, [3.0, 4.0], 0.3);
        assert!((force[0] - 4.0 * 1.2 * 0.6).abs() < 1e-12, "{force:?}");
        assert!((force[1] - 4.0 * 1.2 * 0.8).abs() < 1e-12, "{force:?}");
    }

    #[test]
    fn inside_the_goal_radius_a_walker_brakes() {
        assert_eq!(MODEL.goal_force([0.0, 0.0], [1.0, -0.5], 1.2, [0.2, 0.0], 0.3), [-2.0, 1.0]);
    }

    #[test]
    fn head_on_pairs_feel_no_sideways_push() {
        let force = MODEL.pair_force([0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [-1.0, 0.0]);
        assert!(force[0] < 0.0 && force[1] == 0.0, "{force:?}");
    }

    #[test]
    fn people_at_rest_push_each_other_straight_away() {
        for k in 0..100 {
            let angle = 0.062_9 * f64::from(k);
            let [x, y] = [1.3 * angle.cos(), 1.3 * angle.sin()];
            let force = MODEL.pair_force([0.0, 0.0], [0.0, 0.0], [x, y], [0.0, 0.0]);
            assert!(
                (force[0] * y - force[1] * x).abs() < 1e-15 && force[0] * x + force[1] * y < 0.0,
                "{force:?}"
            );
        }
    }

    #[test]
    fn coincident_people_exert_no_force_rather_than_nan() {
        assert_eq!(MODEL.pair_force([1.0, 1.0], [0.3, 0.0], [1.0, 1.0], [0.0, 0.0]), [0.0, 0.0]);
        // λ (v_i − v_j) cancels the unit vector exactly.
        assert_eq!(MODEL.pair_force([0.0, 0.0], [-0.5, 0.0], [1.0, 0.0], [0.0, 0.0]), [0.0, 0.0]);
    }

    #[test]
    fn the_push_is_mirror_symmetric() {
        let left = MODEL.pair_force([0.0, 0.0], [1.0, 0.1], [1.5, 0.4], [-0.8, 0.2]);
        let right = MODEL.pair_force([0.0, 0.0], [1.0, -0.1], [1.5, -0.4], [-0.8, -0.2]);
        assert!((left[0] - right[0]).abs() < 1e-14 && (left[1] + right[1]).abs() < 1e-14);
    }
}
