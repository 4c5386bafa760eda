//! The simulated world: pedestrians, robot plants, scenarios and files of them, and the ledger of what happened.
//!
//! People follow the social force model as HuNavSim runs it, walk straight on between walls, or repeat a recorded track; all
//! ignore the robot. The robot is a kinematic unicycle or a planar double integrator behind clipped actuators that may lag,
//! answer late or change slowly. [`World`] joins the two on an integer
//! nanosecond clock that the caller advances: there is no clock, thread, port or random number in a step, so the same
//! scenario and commands give the same run.
//!
//! Not here: sensors and messages (`perception_bridge`), controllers, and statistics over many runs (`evaluation`).

mod crowd;
mod delay;
mod generate;
mod ledger;
mod person;
mod plant;
mod rectangle;
mod scenario;
mod scenario_error;
mod scenario_file;
mod social_force;
mod track;
mod walker;
mod world;

pub use crowd::{CROWD_PERIOD_NS, Crowd};
pub use generate::{CrowdKind, GenerateError, ScenarioRequest};
pub use ledger::{Contact, RunLedger};
pub use person::{Motion, Person};
pub use plant::{Plant, PlantError, PlantModel, PlantSettings, RobotState};
pub use rectangle::Rectangle;
pub use scenario::{RobotLimits, RobotStart, Scenario};
pub use scenario_error::ScenarioError;
pub use scenario_file::{
    SCENARIO_FORMAT, ScenarioFileError, parse_scenarios, read_scenario, read_scenarios, write_scenarios,
};
pub use social_force::SocialForce;
pub use world::{PersonState, StepError, World, WorldError};
