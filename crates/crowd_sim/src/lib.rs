//! The simulated world: social-force pedestrians, robot plants, scenarios, and the ledger of what happened.
//!
//! People follow the social force model as HuNavSim runs it and ignore the robot; the robot is a kinematic unicycle or
//! a planar double integrator behind clipped, optionally lagging actuators. [`World`] joins the two on an integer
//! nanosecond clock that the caller advances: there is no clock, thread, port or random number in a step, so the same
//! scenario and commands give the same run.
//!
//! Not here: sensors and messages (`perception_bridge`), controllers, and statistics over many runs (`evaluation`).

mod crowd;
mod generate;
mod ledger;
mod plant;
mod scenario;
mod social_force;
mod world;

pub use crowd::{CROWD_PERIOD_NS, Crowd};
pub use generate::{GenerateError, ScenarioRequest};
pub use ledger::RunLedger;
pub use plant::{Plant, PlantError, PlantModel, PlantSettings, RobotState};
pub use scenario::{Person, Rectangle, RobotStart, Scenario, ScenarioError};
pub use social_force::SocialForce;
pub use world::{PersonState, StepError, World, WorldError};
