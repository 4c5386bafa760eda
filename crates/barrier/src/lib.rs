//! What the safety filter computes: model file, network and gradient, composite barrier, CBF-QP.
//!
//! Pure functions of their arguments: no port, no clock, and apart from [`Model::load`] and
//! [`Model::save`] no file. Not here: how states move (`dynamics`), how the value function is solved
//! (`reachability`) or the network fitted (`barrier_training`), and what the robot does when an answer
//! is missing (`cbf_filter`).
//!
//! | step of the paper | here |
//! |---|---|
//! | failure function `ℓ(z)` | [`FailureFunction`] |
//! | residual network `r_Θ(z)` and `∇r_Θ` | [`ResidualNetwork`], on a [`Kernel`] chosen at run time |
//! | relative barrier `h̄_Θ(z) = ℓ(z) − r_Θ(z)` (eq. `h_bar`) | [`RelativeBarrier`] |
//! | aggregation `η` (eq. `eta`) | [`softmin`] |
//! | composite `h(x, t)`, `L_g h`, `L_f h`, `∂h/∂t` (eq. `h_cn_to_h`) | [`CompositeBarrier`] |
//! | CBF-QP (eq. `cbf_qp`), softened by one slack | [`CbfQp`] |
//!
//! Beyond the paper: conditions of single obstacles ([`CompositeBarrier::evaluate_pairs`], [`RowsQp`]); [`JointEscape`] looks
//! ahead for a manoeuvre that keeps clear of everybody at once, [`Anticipation`] for the best way through a crowd.
//!
//! Nothing that is called once per cycle allocates after construction; `tests/allocation.rs` counts.
//!
//! Results of one [`Kernel`] do not depend on the machine's mathematics library: the network uses its
//! own polynomials and the softmin the portable `libm` crate. The sine and cosine of the robot's heading
//! are taken in `dynamics`.

mod anticipation;
mod composite;
mod domain;
mod elementary;
mod encoding;
mod failure;
mod fit;
mod joint;
mod kernel;
mod lanes;
#[cfg(target_arch = "x86_64")]
mod lanes_avx2;
#[cfg(target_arch = "x86_64")]
mod lanes_avx512;
mod metadata;
mod minimax;
mod model;
mod model_error;
mod model_file;
mod network;
mod network_pass;
mod polygon;
mod qp;
mod relative_barrier;
mod relative_barriers;
mod rows_qp;
mod softmin;
mod weights;

pub use anticipation::{AnticipatingRobot, Anticipation, AnticipationHorizon};
pub use composite::{
    BarrierConstraint, BarrierObstacle, CompositeBarrier, CompositeError, CompositeSample,
    CompositeSetupError, ObstacleInput, SoftminOffset,
};
pub use domain::{DomainError, PlacedState, TrainedDomain};
pub use encoding::{InputEncoding, LAYER_WIDTHS};
pub use failure::FailureFunction;
pub use fit::{Expected, ModelMismatch};
pub use joint::{Escape, JointEscape, JointHorizon, JointRobot};
pub use kernel::{Kernel, KernelError};
pub use metadata::{Bounds, DynamicsKind, FORMAT_VERSION, GridRecord, ModelMetadata, TrainingRecord};
pub use minimax::largest_margin;
pub use model::Model;
pub use model_error::ModelFileError;
pub use network::{NetworkBatch, ResidualNetwork};
pub use qp::{CbfQp, HalfSpace, QpError, QpSolution};
pub use relative_barrier::{RelativeBarrier, RelativeObstacle, RelativeSample};
pub use rows_qp::RowsQp;
pub use softmin::{softmin, softmin_weights};
pub use weights::{LayerWeights, NetworkWeights, WeightsError};

/// Most obstacles one evaluation takes; the capacity of the `obstacles` message.
pub const MAX_OBSTACLES: usize = 64;
