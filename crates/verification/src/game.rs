//! The pairwise game a model was made for, with its true boxes, whatever the number of disturbances.
//!
//! Not here: the dynamics themselves (`dynamics`) and the barrier (`barrier`).

use barrier::{DynamicsKind, HalfSpace, ModelMetadata};
use dynamics::{DoubleIntegratorPair, InputBox, RelativeDynamics, UnicyclePair, UnicycleStaticPair};

use crate::error::VerificationError;

/// A disturbance of any pair; components that the pair lacks are zero and have no effect.
pub type Disturbance = [f64; 2];

/// One of the pairs of `dynamics`, with the model's true boxes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Game {
    /// Unicycle robot, unicycle person.
    Unicycle(UnicyclePair),
    /// Double integrators.
    DoubleIntegrator(DoubleIntegratorPair),
    /// Unicycle robot, obstacle at rest.
    UnicycleStatic(UnicycleStaticPair),
}

impl Game {
    /// Returns the game that `metadata` states.
    ///
    /// # Errors
    /// * [`VerificationError::Disturbance`] if the disturbance box does not fit the pair.
    pub fn of(metadata: &ModelMetadata) -> Result<Self, VerificationError> {
        let (control, bounds) = (metadata.control, &metadata.disturbance);
        Ok(match metadata.dynamics {
            DynamicsKind::UnicyclePair => Self::Unicycle(UnicyclePair {
                control,
                disturbance: InputBox::from_slices(&bounds.min, &bounds.max)?,
            }),
            DynamicsKind::DoubleIntegratorPair => Self::DoubleIntegrator(DoubleIntegratorPair {
                control,
                disturbance: InputBox::from_slices(&bounds.min, &bounds.max)?,
            }),
            DynamicsKind::UnicycleStaticPair => Self::UnicycleStatic(UnicycleStaticPair { control }),
        })
    }

    /// Returns the robot's box of controls.
    pub fn control_box(&self) -> &InputBox<2> {
        match self {
            Self::Unicycle(pair) => pair.control_box(),
            Self::DoubleIntegrator(pair) => pair.control_box(),
            Self::UnicycleStatic(pair) => pair.control_box(),
        }
    }

    /// Returns the ends of the obstacle's box of disturbances.
    pub fn disturbance_ends(&self) -> (Disturbance, Disturbance) {
        match self {
            Self::Unicycle(pair) => ([pair.disturbance.min[0], 0.0], [pair.disturbance.max[0], 0.0]),
            Self::DoubleIntegrator(pair) => (pair.disturbance.min, pair.disturbance.max),
            Self::UnicycleStatic(_) => ([0.0; 2], [0.0; 2]),
        }
    }

    /// Returns `max_u min_d p·ζ(z, u, d)`, m/s for `p = ∇h`.
    pub fn hamiltonian(&self, z: &[f64; 4], p: &[f64; 4]) -> f64 {
        match self {
            Self::Unicycle(pair) => pair.hamiltonian(z, p),
            Self::DoubleIntegrator(pair) => pair.hamiltonian(z, p),
            Self::UnicycleStatic(pair) => pair.hamiltonian(z, p),
        }
    }

    /// Returns `argmin_d p·ζ(z, u, d)`, which does not depend on u.
    pub fn worst_disturbance(&self, z: &[f64; 4], p: &[f64; 4]) -> Disturbance {
        match self {
            Self::Unicycle(pair) => [pair.optimal_disturbance(z, p)[0], 0.0],
            Self::DoubleIntegrator(pair) => pair.optimal_disturbance(z, p),
            Self::UnicycleStatic(_) => [0.0; 2],
        }
    }

    /// Returns `argmin_u p·ζ(z, u, d)`: the corner of the control box that does most harm.
    pub fn worst_control(&self, z: &[f64; 4], p: &[f64; 4]) -> [f64; 2] {
        let opposite = p.map(|component| -component);
        match self {
            Self::Unicycle(pair) => pair.optimal_control(z, &opposite),
            Self::DoubleIntegrator(pair) => pair.optimal_control(z, &opposite),
            Self::UnicycleStatic(pair) => pair.optimal_control(z, &opposite),
        }
    }

    /// Returns `ζ(z, u, d)`, per second.
    pub fn flow(&self, z: &[f64; 4], u: &[f64; 2], d: &Disturbance) -> [f64; 4] {
        match self {
            Self::Unicycle(pair) => pair.flow(z, u, &[d[0]]),
            Self::DoubleIntegrator(pair) => pair.flow(z, u, d),
            Self::UnicycleStatic(pair) => pair.flow(z, u, &[]),
        }
    }

    /// Returns the CBF-QP's row `∇h·ζ(z, u, d) + α h ≥ 0` on u for a known disturbance.
    ///
    /// Source: paper, eq. `cbf_qp`, in relative coordinates; equal to the composite's row for one obstacle.
    pub fn row(
        &self,
        z: &[f64; 4],
        h_m: f64,
        gradient: &[f64; 4],
        d: &Disturbance,
        alpha_per_s: f64,
    ) -> HalfSpace<2> {
        let jacobian = match self {
            Self::Unicycle(pair) => pair.control_jacobian(z),
            Self::DoubleIntegrator(pair) => pair.control_jacobian(z),
            Self::UnicycleStatic(pair) => pair.control_jacobian(z),
        };
        let normal = std::array::from_fn(|j| (0..4).map(|i| gradient[i] * jacobian[i][j]).sum());
        let still = self.flow(z, &[0.0; 2], d);
        let drift: f64 = (0..4).map(|i| gradient[i] * still[i]).sum();
        HalfSpace { normal, offset: drift + alpha_per_s * h_m }
    }

    /// Returns the control that drives at the obstacle, inside the box.
    ///
    /// A unicycle turns toward it in half a second and goes as fast as it may while it lies ahead; a double
    /// integrator accelerates toward where it will be.
    pub fn pursuit(&self, z: &[f64; 4]) -> [f64; 2] {
        let bounds = self.control_box();
        match self {
            Self::Unicycle(_) | Self::UnicycleStatic(_) => {
                let speed = if z[0] > 0.0 { bounds.max[0] } else { bounds.min[0] };
                bounds.clamp(&[speed, 2.0 * z[1].atan2(z[0])])
            }
            Self::DoubleIntegrator(_) => bounds.clamp(&[4.0 * z[0] + z[2], 4.0 * z[1] + z[3]]),
        }
    }
}
