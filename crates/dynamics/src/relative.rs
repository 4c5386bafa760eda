//! Relative dynamics and what reachability needs of them: optimal inputs and the Hamiltonian.

use crate::InputBox;

/// Relative dynamics `ż = ζ(z, u, d) = f(z) + G_u(z) u + G_d(z) d`, affine in both inputs.
///
/// Source: paper, equation `relative_dynamics`. The control `u` belongs to the robot and flees the
/// failure set, the disturbance `d` belongs to the obstacle and seeks it. As both enter affinely and
/// apart, `max_u min_d = min_d max_u` and the game has a value.
///
/// # Shapes
/// `z` and costates `p`: `[NZ]`; `u`: `[NU]`; `d`: `[ND]`; Jacobians: rows follow `z`.
pub trait RelativeDynamics<const NZ: usize, const NU: usize, const ND: usize>: Send + Sync {
    /// Returns `f(z)`, the motion with both inputs at zero, in state units per second.
    fn drift(&self, z: &[f64; NZ]) -> [f64; NZ];

    /// Returns `G_u(z) = ∂ζ/∂u`.
    fn control_jacobian(&self, z: &[f64; NZ]) -> [[f64; NU]; NZ];

    /// Returns `G_d(z) = ∂ζ/∂d`.
    fn disturbance_jacobian(&self, z: &[f64; NZ]) -> [[f64; ND]; NZ];

    /// Returns the inputs the robot may choose from.
    fn control_box(&self) -> &InputBox<NU>;

    /// Returns the inputs the obstacle may choose from.
    fn disturbance_box(&self) -> &InputBox<ND>;

    /// Returns the control that maximises `p·ζ(z, u, d)`; a component that does not matter is at its maximum.
    fn optimal_control(&self, z: &[f64; NZ], p: &[f64; NZ]) -> [f64; NU] {
        let s = transposed_product(&self.control_jacobian(z), p);
        let bounds = self.control_box();
        std::array::from_fn(|j| if s[j] >= 0.0 { bounds.max[j] } else { bounds.min[j] })
    }

    /// Returns the disturbance that minimises `p·ζ(z, u, d)`; a component that does not matter is at its
    /// minimum.
    fn optimal_disturbance(&self, z: &[f64; NZ], p: &[f64; NZ]) -> [f64; ND] {
        let s = transposed_product(&self.disturbance_jacobian(z), p);
        let bounds = self.disturbance_box();
        std::array::from_fn(|j| if s[j] >= 0.0 { bounds.min[j] } else { bounds.max[j] })
    }

    /// Returns `H(z, p) = max_u min_d p·ζ(z, u, d)`.
    ///
    /// Source: paper, the Hamiltonian below equation `hjb_vi`, with `p = ∇V`.
    fn hamiltonian(&self, z: &[f64; NZ], p: &[f64; NZ]) -> f64 {
        let u = self.optimal_control(z, p);
        let d = self.optimal_disturbance(z, p);
        let flow = self.flow(z, &u, &d);
        (0..NZ).map(|i| p[i] * flow[i]).sum()
    }

    /// Returns `ζ(z, u, d)`. The inputs are used as they are, inside their boxes or not.
    fn flow(&self, z: &[f64; NZ], u: &[f64; NU], d: &[f64; ND]) -> [f64; NZ] {
        let f = self.drift(z);
        let g_u = self.control_jacobian(z);
        let g_d = self.disturbance_jacobian(z);
        std::array::from_fn(|i| {
            let by_control: f64 = (0..NU).map(|j| g_u[i][j] * u[j]).sum();
            let by_disturbance: f64 = (0..ND).map(|j| g_d[i][j] * d[j]).sum();
            f[i] + by_control + by_disturbance
        })
    }
}

/// Returns `Gᵀ p`.
fn transposed_product<const NZ: usize, const N: usize>(g: &[[f64; N]; NZ], p: &[f64; NZ]) -> [f64; N] {
    std::array::from_fn(|j| (0..NZ).map(|i| p[i] * g[i][j]).sum())
}
