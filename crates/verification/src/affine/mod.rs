//! The deterministic ε-certificate: Taylor models with branch and bound on a named box.
//!
//! [`certify`] asks whether the CBF condition holds on every state of a box, not on samples of it. Each piece of the box
//! is enclosed by affine arithmetic with quadratic terms: every quantity of the network is a polynomial of order two in
//! the piece's four coordinates plus a radius that holds all higher terms and all rounding (`form`). A piece is settled
//! when its bounds suffice and cut in two when not.
//!
//! Second order pays: on the published quadrotor network and pieces of ±0.025, the gradient's radius is 0.003 against
//! 0.11 for first order and 0.02 for a second-order value with first-order derivatives.
//!
//! Not here: statements from samples and from rollouts, which the crate's other parts make.

mod cell;
mod certify;
mod checkpoint;
mod elementary;
mod enclosure;
mod error;
mod form;
mod game;
mod layer;
mod network;
mod onboard;
mod quadratic;
mod question;
mod record;
mod rounding;
mod search;
#[cfg(test)]
mod test_models;

pub use cell::StateBox;
pub use certify::certify;
pub use error::AffineError;
pub use onboard::OnboardDeviation;
pub use question::{AffineSettings, subject_sha256};
pub use record::{AffineRecord, Outcome};
pub use search::{AffineProgress, Witness};
