//! From a name and parameters to a method. Not here: the parameters' meaning (`parameters`).

use barrier::{Bounds, DynamicsKind, Expected, Kernel, KernelError, Model, ModelMismatch};
use dynamics::{InputBox, InputBoxError, UnicyclePair};
use optimal_control::SqpSetupError;
use serde::{Deserialize, Serialize};
use settings::{RobotKind, Settings};

use crate::filter::RowFilter;
use crate::method::Method;
use crate::pair_rows::{CollisionCone, DistanceOrderTwo};
use crate::parameters::{
    C3bfParameters, DcbfParameters, HoCbfParameters, PlannerParameters, RntcParameters, non_negative,
    positive,
};
use crate::planner::Planner;
use crate::rows::{DcbfRows, RntcRows, SdfRows, VoRows};

/// A method of the comparison, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MethodKind {
    /// Planner that keeps the signed distance.
    SdfMpc,
    /// Planner under a discrete-time control barrier function.
    DcbfMpc,
    /// Planner that avoids velocity obstacles.
    VoMpc,
    /// Planner with a terminal safe set.
    RntcMpc,
    /// Filter by collision cones.
    C3bf,
    /// Filter by a barrier of relative degree two.
    HoCbf,
}

impl MethodKind {
    /// Every method, in the paper's order.
    pub const ALL: [Self; 6] =
        [Self::SdfMpc, Self::DcbfMpc, Self::VoMpc, Self::RntcMpc, Self::C3bf, Self::HoCbf];

    /// The name in files and on command lines.
    pub const fn name(self) -> &'static str {
        match self {
            Self::SdfMpc => "sdf_mpc",
            Self::DcbfMpc => "dcbf_mpc",
            Self::VoMpc => "vo_mpc",
            Self::RntcMpc => "rntc_mpc",
            Self::C3bf => "c3bf",
            Self::HoCbf => "ho_cbf",
        }
    }

    /// The name of the method with its [tuned](MethodParameters::tuned) parameters.
    pub const fn tuned_name(self) -> &'static str {
        match self {
            Self::SdfMpc => "sdf_mpc_tuned",
            Self::DcbfMpc => "dcbf_mpc_tuned",
            Self::VoMpc => "vo_mpc_tuned",
            Self::RntcMpc => "rntc_mpc_tuned",
            Self::C3bf => "c3bf_tuned",
            Self::HoCbf => "ho_cbf_tuned",
        }
    }

    /// The robot that the method is for.
    pub const fn robot(self) -> RobotKind {
        match self {
            Self::SdfMpc | Self::DcbfMpc | Self::VoMpc | Self::RntcMpc => RobotKind::Unicycle,
            Self::C3bf | Self::HoCbf => RobotKind::DoubleIntegrator,
        }
    }

    /// How often the method is stepped as published, ns: planners at 20 Hz, filters at 250 Hz.
    pub const fn published_period_ns(self) -> u64 {
        match self.robot() {
            RobotKind::Unicycle => 50_000_000,
            RobotKind::DoubleIntegrator => 4_000_000,
        }
    }
}

impl std::fmt::Display for MethodKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl std::str::FromStr for MethodKind {
    type Err = MethodSetupError;

    fn from_str(name: &str) -> Result<Self, MethodSetupError> {
        let found = Self::ALL.into_iter().find(|kind| kind.name() == name);
        found.ok_or_else(|| MethodSetupError::UnknownMethod {
            name: name.to_owned(),
            known: Self::ALL.map(Self::name).join(", "),
        })
    }
}

/// A method with everything that can be chosen of it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "method", rename_all = "snake_case")]
pub enum MethodParameters {
    /// [`MethodKind::SdfMpc`].
    SdfMpc(PlannerParameters),
    /// [`MethodKind::DcbfMpc`].
    DcbfMpc(DcbfParameters),
    /// [`MethodKind::VoMpc`].
    VoMpc(PlannerParameters),
    /// [`MethodKind::RntcMpc`].
    RntcMpc(RntcParameters),
    /// [`MethodKind::C3bf`].
    C3bf(C3bfParameters),
    /// [`MethodKind::HoCbf`].
    HoCbf(HoCbfParameters),
}

/// Why a method cannot be set up.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MethodSetupError {
    /// No method of this name.
    #[error("there is no method {name}; there are: {known}")]
    UnknownMethod {
        /// The name asked for.
        name: String,
        /// The names there are.
        known: String,
    },
    /// The settings describe another robot than the method is for.
    #[error(
        "{method} is for a {needed:?} robot, the settings describe a {given:?}; use settings of that robot"
    )]
    OtherRobot {
        /// Its name.
        method: &'static str,
        /// The robot it is for.
        needed: RobotKind,
        /// The robot of the settings.
        given: RobotKind,
    },
    /// A parameter that is not a number of the right size.
    #[error("{parameter} is {value}; it must be {requirement}")]
    Parameter {
        /// Its name.
        parameter: &'static str,
        /// What was given.
        value: f64,
        /// What is needed.
        requirement: &'static str,
    },
    /// Nobody, or more people than a message holds.
    #[error("obstacle_limit is {given}; take 1 to {max}", max = messages::MAX_OBSTACLES)]
    ObstacleLimit {
        /// What was given.
        given: usize,
    },
    /// RNTC-MPC without a value function.
    #[error(
        "rntc_mpc needs a model of a unicycle among walking people; give one, such as embedded:ground_robot"
    )]
    NoModel,
    /// RNTC-MPC with a value function of another robot or of other people.
    #[error("rntc_mpc: {0}")]
    Model(#[from] ModelMismatch),
    /// Horizon, weights or bounds make no planner.
    #[error(transparent)]
    Sqp(#[from] SqpSetupError),
    /// The robot's bounds are no box.
    #[error("robot.control_min / control_max: {0}")]
    Bounds(#[from] InputBoxError),
    /// The network does not run here.
    #[error(transparent)]
    Kernel(#[from] KernelError),
}

impl MethodParameters {
    /// The method as its authors published it.
    pub fn published(kind: MethodKind) -> Self {
        match kind {
            MethodKind::SdfMpc => Self::SdfMpc(PlannerParameters::published()),
            MethodKind::DcbfMpc => Self::DcbfMpc(DcbfParameters::published()),
            MethodKind::VoMpc => Self::VoMpc(PlannerParameters::published()),
            MethodKind::RntcMpc => Self::RntcMpc(RntcParameters::published()),
            MethodKind::C3bf => Self::C3bf(C3bfParameters::published()),
            MethodKind::HoCbf => Self::HoCbf(HoCbfParameters::published()),
        }
    }

    /// Which method these are for.
    pub const fn kind(&self) -> MethodKind {
        match self {
            Self::SdfMpc(_) => MethodKind::SdfMpc,
            Self::DcbfMpc(_) => MethodKind::DcbfMpc,
            Self::VoMpc(_) => MethodKind::VoMpc,
            Self::RntcMpc(_) => MethodKind::RntcMpc,
            Self::C3bf(_) => MethodKind::C3bf,
            Self::HoCbf(_) => MethodKind::HoCbf,
        }
    }

    /// Sets the method up for the robot of `settings`: its radius, its bounds. `model` is RNTC-MPC's value function.
    ///
    /// # Errors
    /// [`MethodSetupError`]: settings of another robot, an unusable parameter, a missing or unsuitable model.
    pub fn build(
        &self,
        settings: &Settings,
        model: Option<&Model>,
    ) -> Result<Box<dyn Method>, MethodSetupError> {
        let (kind, robot) = (self.kind(), &settings.robot);
        if robot.kind != kind.robot() {
            return Err(MethodSetupError::OtherRobot {
                method: kind.name(),
                needed: kind.robot(),
                given: robot.kind,
            });
        }
        let control = InputBox::new(robot.control_min, robot.control_max)?;
        let radius_m = robot.radius_m;
        positive("robot.radius_m", radius_m)?;
        Ok(match self {
            Self::SdfMpc(planner) => Box::new(Planner::new(planner, SdfRows, control, radius_m)?),
            Self::DcbfMpc(DcbfParameters { planner, gamma }) => {
                positive("gamma", *gamma)?;
                if *gamma > 1.0 {
                    let requirement = "at most 1";
                    return Err(MethodSetupError::Parameter {
                        parameter: "gamma",
                        value: *gamma,
                        requirement,
                    });
                }
                Box::new(Planner::new(planner, DcbfRows { gamma: *gamma }, control, radius_m)?)
            }
            Self::VoMpc(planner) => Box::new(Planner::new(planner, VoRows, control, radius_m)?),
            Self::RntcMpc(RntcParameters { planner, terminal_margin_m }) => {
                non_negative("terminal_margin_m", *terminal_margin_m)?;
                let model = model.ok_or(MethodSetupError::NoModel)?;
                let obstacle = &settings.obstacle;
                model.check_fits(&Expected {
                    dynamics: DynamicsKind::UnicyclePair,
                    control,
                    disturbance: Bounds {
                        min: obstacle.disturbance_min.clone(),
                        max: obstacle.disturbance_max.clone(),
                    },
                    // Each obstacle brings its own.
                    failure_radius_m: None,
                })?;
                // The geometry alone is used of the pair; nobody turns within a prediction.
                let pair = UnicyclePair { control, disturbance: InputBox::new([0.0], [0.0])? };
                let last_step = planner.horizon_steps.saturating_sub(1);
                let rows = RntcRows::new(model, Kernel::detect(), pair, last_step, *terminal_margin_m)?;
                Box::new(Planner::new(planner, rows, control, radius_m)?)
            }
            Self::C3bf(C3bfParameters { filter, k_per_s }) => {
                positive("k_per_s", *k_per_s)?;
                Box::new(RowFilter::new(filter, CollisionCone { k_per_s: *k_per_s }, control, radius_m)?)
            }
            Self::HoCbf(HoCbfParameters { filter, k1_per_s, k2_per_s }) => {
                positive("k1_per_s", *k1_per_s)?;
                positive("k2_per_s", *k2_per_s)?;
                let row = DistanceOrderTwo { k1_per_s: *k1_per_s, k2_per_s: *k2_per_s };
                Box::new(RowFilter::new(filter, row, control, radius_m)?)
            }
        })
    }
}
