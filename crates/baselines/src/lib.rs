//! The methods that the CN-CBF paper compares itself with, behind one interface: [`Method`].
//!
//! | method | robot | what it demands |
//! |---|---|---|
//! | SDF-MPC | unicycle | `‖p_j − x‖ ≥ R_j` at every step of the plan |
//! | DCBF-MPC | unicycle | the distance shrinks by at most the share γ per step |
//! | VO-MPC | unicycle | no velocity inside an obstacle's collision cone |
//! | RNTC-MPC | unicycle | SDF-MPC, and a last state from which every obstacle can be evaded (see [`RntcParameters`]) |
//! | C3BF | double integrator | the relative velocity leaves the collision cone, as a CBF on the accelerations |
//! | HO-CBF | double integrator | the distance, as a CBF of relative degree two |
//!
//! Each is as its authors published it with [`MethodParameters::published`], as a fair search tuned it with
//! [`MethodParameters::tuned`], and whatever one chooses otherwise. The first control is applied whatever the verdict; the
//! verdict is data. Steps are pure: time is passed in, nothing is sent. They allocate nothing, apart from Clarabel inside
//! the planners.
//!
//! Not here: CN-CBF itself (`cbf_filter` is its one implementation), the nominal controllers that the filters correct
//! (`nominal_mpc`), closed loops and tables (`evaluation`). Nothing on board uses this crate.

mod filter;
mod inputs;
mod method;
mod pair_rows;
mod parameters;
mod planner;
mod rows;
mod setup;
mod soft_rows_qp;
mod surroundings;
mod tuned;

pub use inputs::{Inputs, NoControl};
pub use method::{Method, MethodOutput, Verdict};
pub use pair_rows::{CollisionCone, DistanceOrderTwo, PairRow, PairState};
pub use parameters::{
    C3bfParameters, DcbfParameters, FilterParameters, HoCbfParameters, PlannerParameters, RntcParameters,
    SightParameters,
};
pub use setup::{MethodKind, MethodParameters, MethodSetupError};
pub use soft_rows_qp::{SoftRowsQp, SoftRowsSolution};
