//! The quadrotor's rows: what C3BF and HO-CBF demand of an acceleration because of one obstacle. Pure formulas; not here:
//! how rows become a control (`soft_rows_qp`).

use barrier::HalfSpace;

/// Smallest `‖p‖² − R²` that C3BF computes with, m², as in the authors' code: inside the disc there is no cone.
const SMALLEST_TANGENT_SQUARED: f64 = 0.01;
/// A relative speed or distance below this has no direction, m/s or m.
const NO_DIRECTION: f64 = 1e-6;

/// One obstacle relative to the robot, axes of `odom`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairState {
    /// `p = p_o − p_r`, m.
    pub position_m: [f64; 2],
    /// `v = v_o − v_r`, m/s.
    pub velocity_mps: [f64; 2],
    /// `a_o`, the obstacle's own acceleration, m/s².
    pub obstacle_acceleration_mps2: [f64; 2],
    /// `R`, distance of the centres that counts as contact, m.
    pub contact_m: f64,
}

/// A barrier between two double integrators.
pub trait PairRow: Send {
    /// The accelerations `u` of the robot that the barrier admits, as `normal · u + offset ≥ 0`.
    fn row(&self, pair: &PairState) -> HalfSpace<2>;
}

/// C3BF, the collision cone barrier of Tayal and others:
///
/// ```text
/// h = p·v + ‖v‖ s,   s = √(‖p‖² − R²)          ḣ + k h ≥ 0,   v̇ = a_o − u
/// ḣ = ‖v‖² + p·v̇ + (v·v̇/‖v‖) s + ‖v‖ (p·v)/s
/// ```
///
/// `h ≥ 0` where the relative velocity points outside the cone of the disc. As in the authors' code `s² ≥ 0.01 m²`, and
/// where that bound holds `s` the last term is absent. Where `v` vanishes its direction counts as zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CollisionCone {
    /// `k`, 1/s.
    pub k_per_s: f64,
}

impl PairRow for CollisionCone {
    fn row(&self, pair: &PairState) -> HalfSpace<2> {
        let (p, v, a) = (pair.position_m, pair.velocity_mps, pair.obstacle_acceleration_mps2);
        let tangent_squared = dot(p, p) - pair.contact_m * pair.contact_m;
        let s = tangent_squared.max(SMALLEST_TANGENT_SQUARED).sqrt();
        let speed = dot(v, v).sqrt();
        let direction = if speed > NO_DIRECTION { v.map(|component| component / speed) } else { [0.0; 2] };
        let h = dot(p, v) + speed * s;
        // ∂h/∂v, by which both accelerations count.
        let by_velocity: [f64; 2] = std::array::from_fn(|i| p[i] + s * direction[i]);
        let by_tangent = if tangent_squared > SMALLEST_TANGENT_SQUARED { speed * dot(p, v) / s } else { 0.0 };
        HalfSpace {
            normal: by_velocity.map(|component| -component),
            offset: dot(v, v) + dot(by_velocity, a) + by_tangent + self.k_per_s * h,
        }
    }
}

/// HO-CBF, the distance as a barrier of relative degree two, after Xiao and Belta:
///
/// ```text
/// h = ‖p‖ − R      ḣ = p·v/‖p‖      ḧ = (p·v̇ + ‖v‖²)/‖p‖ − (p·v)²/‖p‖³
/// ḧ + (k₁ + k₂) ḣ + k₁ k₂ h ≥ 0,   v̇ = a_o − u
/// ```
///
/// It keeps `h ≥ 0` only if `ḣ + k₁ h ≥ 0` at the start, which nothing here ensures. Distances below a micrometre count
/// as one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DistanceOrderTwo {
    /// `k₁`, 1/s.
    pub k1_per_s: f64,
    /// `k₂`, 1/s.
    pub k2_per_s: f64,
}

impl PairRow for DistanceOrderTwo {
    fn row(&self, pair: &PairState) -> HalfSpace<2> {
        let (p, v, a) = (pair.position_m, pair.velocity_mps, pair.obstacle_acceleration_mps2);
        let distance = dot(p, p).sqrt().max(NO_DIRECTION);
        let n = p.map(|component| component / distance);
        let h = distance - pair.contact_m;
        let h_dot = dot(n, v);
        // The part of ḧ that no acceleration enters: the square of the speed across, over the distance.
        let turning = (dot(v, v) - h_dot * h_dot) / distance;
        let (k1, k2) = (self.k1_per_s, self.k2_per_s);
        HalfSpace {
            normal: n.map(|component| -component),
            offset: dot(n, a) + turning + (k1 + k2) * h_dot + k1 * k2 * h,
        }
    }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}
