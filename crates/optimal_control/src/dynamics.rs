//! Discrete-time dynamics as [`crate::Sqp`] sees them, and the unicycle. No cost and no bounds.

/// First-order expansion of `f(x, u)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linearisation<const NX: usize, const NU: usize> {
    /// `∂f/∂x`, row by row.
    pub by_state: [[f64; NX]; NX],
    /// `∂f/∂u`, row by row.
    pub by_control: [[f64; NU]; NX],
}

/// `x⁺ = f(x, u)` over one step of the horizon.
pub trait DiscreteDynamics<const NX: usize, const NU: usize> {
    /// The state one step later.
    fn next(&self, state: &[f64; NX], control: &[f64; NU]) -> [f64; NX];

    /// The Jacobians of [`Self::next`].
    fn linearise(&self, state: &[f64; NX], control: &[f64; NU]) -> Linearisation<NX, NU>;

    /// Which entries of the Jacobians may ever differ from zero; the QP stores only those.
    fn sparsity(&self) -> Linearisation<NX, NU> {
        Linearisation { by_state: [[1.0; NX]; NX], by_control: [[1.0; NU]; NX] }
    }

    /// A diagonal, non-negative stand-in for `Σᵢ λᵢ ∂²fᵢ/∂x²`, added to the Gauss–Newton Hessian.
    ///
    /// `costate` is `λ` of the next state, half the gradient of the cost to go. Where the reference is far beyond
    /// the horizon that term dominates, and a step that neglects it overshoots. Zero gives plain Gauss–Newton.
    fn curvature(&self, state: &[f64; NX], control: &[f64; NU], costate: &[f64; NX]) -> [f64; NX] {
        let _ = (state, control, costate);
        [0.0; NX]
    }
}

/// Unicycle, one explicit Euler step.
///
/// State `[x_m, y_m, heading_rad]`, control `[speed_mps, yaw_rate_radps]`:
/// `x⁺ = x + T v cos θ`, `y⁺ = y + T v sin θ`, `θ⁺ = θ + T ω`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EulerUnicycle {
    /// Length `T` of one step, s.
    pub step_s: f64,
}

impl DiscreteDynamics<3, 2> for EulerUnicycle {
    fn next(&self, &[x, y, heading]: &[f64; 3], &[speed, yaw_rate]: &[f64; 2]) -> [f64; 3] {
        let (sin, cos) = heading.sin_cos();
        [x + self.step_s * speed * cos, y + self.step_s * speed * sin, heading + self.step_s * yaw_rate]
    }

    fn linearise(&self, &[_, _, heading]: &[f64; 3], &[speed, _]: &[f64; 2]) -> Linearisation<3, 2> {
        let (sin, cos) = heading.sin_cos();
        let t = self.step_s;
        Linearisation {
            by_state: [[1.0, 0.0, -t * speed * sin], [0.0, 1.0, t * speed * cos], [0.0, 0.0, 1.0]],
            by_control: [[t * cos, 0.0], [t * sin, 0.0], [0.0, t]],
        }
    }

    fn sparsity(&self) -> Linearisation<3, 2> {
        Linearisation {
            by_state: [[1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]],
            by_control: [[1.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        }
    }

    /// `∂²/∂θ²` of `λ·f` is `−T v (λx cos θ + λy sin θ)`: positive while the robot faces its reference.
    fn curvature(&self, &[_, _, heading]: &[f64; 3], &[speed, _]: &[f64; 2], costate: &[f64; 3]) -> [f64; 3] {
        let (sin, cos) = heading.sin_cos();
        [0.0, 0.0, (-self.step_s * speed * (costate[0] * cos + costate[1] * sin)).max(0.0)]
    }
}
