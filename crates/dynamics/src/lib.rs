//! Robot, obstacle and relative dynamics, affine in the inputs of the robot and of the obstacle.
//!
//! Here live the two pairs of the paper (unicycle robot with a unicycle pedestrian, double-integrator
//! robot with a double-integrator obstacle), the unicycle among things that stand still, the boxes their
//! inputs stay in, and the Hamiltonian that follows from both. Not here: integration in time (`crowd_sim`), grids (`reachability`) and anything
//! learned (`barrier`).
//!
//! | trait | answers |
//! |---|---|
//! | [`RelativeDynamics`] | how the relative state moves (offline: reachability, certificates) |
//! | [`RobotObstaclePair`] | how the relative state follows from robot and obstacle (online: the filter) |
//! | [`conformance`] | whether a pair is what it says (in tests, also of pairs made elsewhere) |

mod angle;
pub mod conformance;
mod double_integrator;
mod input_box;
mod relative;
mod robot_obstacle;
mod unicycle;
mod unicycle_static;

pub use angle::wrap_angle;
pub use double_integrator::DoubleIntegratorPair;
pub use input_box::{InputBox, InputBoxError};
pub use relative::RelativeDynamics;
pub use robot_obstacle::{HeadingFrame, RobotObstaclePair};
pub use unicycle::UnicyclePair;
pub use unicycle_static::UnicycleStaticPair;
