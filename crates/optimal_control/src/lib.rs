//! What the nominal controller and the planners that it is compared with share: linear-quadratic regulators and
//! sequential quadratic programming (SQP).
//!
//! * [`continuous_lqr`], [`discrete_lqr`]: gains through the algebraic Riccati equation.
//! * [`Sqp`]: box-constrained optimal control of any [`DiscreteDynamics`], under [`StageConstraints`] if there are any;
//!   its QPs are solved by Clarabel.
//! * [`UnicycleMpc`]: the paper's nominal controller of the ground robot, an [`Sqp`] with a heading that never jumps.
//!
//! Not here: obstacles (the nominal controller is blind to them; `baselines` has planners that see them), messages, clocks, and when a command counts as
//! too old. Those belong to `nominal_mpc` and to the filter.

mod constraints;
mod detectability;
mod dynamics;
mod expansion;
mod linear_quadratic;
mod riccati;
mod sqp;
mod sqp_settings;
mod sqp_status;
mod trajectory_qp;
mod turn_policy;
mod unicycle_mpc;

pub use constraints::{ConstraintRow, NoConstraints, StageConstraints, StepPoint};
pub use dynamics::{DiscreteDynamics, EulerUnicycle, Linearisation};
pub use linear_quadratic::{Lqr, LqrError, continuous_lqr, discrete_lqr};
pub use sqp::Sqp;
pub use sqp_settings::{QuadraticWeights, SqpSettings, SqpSetupError};
pub use sqp_status::{SqpError, SqpReport, SqpStatus};
pub use unicycle_mpc::{UnicycleMpc, UnicycleMpcSettings};
