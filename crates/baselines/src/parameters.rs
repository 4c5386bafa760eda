//! What can be chosen of each method, with the values its authors published. Not here: how a method is built (`setup`).

use serde::{Deserialize, Serialize};

use crate::setup::MethodSetupError;

/// Which obstacles a method takes into account, and how large they are to it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SightParameters {
    /// Half the side of the square around the robot, axes of `odom`, beyond which nobody is seen, m.
    pub window_half_width_m: f64,
    /// The nearest that many are taken into account; the rest are left out.
    pub obstacle_limit: usize,
    /// Added to the sum of the radii, m. Published: 0.
    pub margin_m: f64,
}

/// What the four planners share. Cost, horizon and window are those of the first author's public planners.
///
/// Speeds and yaw rates are bounded by the settings of the robot, which for the paper are those of the paper. The cost is
/// `Σ (x−r)ᵀQ(x−r) + uᵀRu`, `r` the goal's pose; the heading error takes the shorter way round, where the published code
/// takes the difference as it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlannerParameters {
    /// Steps of the plan.
    pub horizon_steps: usize,
    /// Length of a step, s.
    pub step_s: f64,
    /// Diagonal of `Q`, `[x, y, heading]`, 1/m², 1/m², 1/rad².
    pub state_weight: [f64; 3],
    /// Diagonal of `Q` at the last state.
    pub terminal_weight: [f64; 3],
    /// Diagonal of `R`, `[speed, yaw rate]`, s²/m², s²/rad².
    pub control_weight: [f64; 2],
    /// Cost per unit (m or rad) by which a demand is missed. Above every multiplier of the problem, demands are hard as
    /// published, and where they cannot be met they are missed by as little as possible; below, they are soft.
    pub violation_weight: f64,
    /// A demand missed by less counts as met, m or rad.
    pub feasibility_tolerance: f64,
    /// Quadratic programs at most per search. The published planners bound IPOPT's time instead, to 0.1 s.
    pub iteration_limit: u32,
    /// Whether a search that ended without meeting every demand is followed by up to four more, each from one corner of
    /// the control box, until one succeeds. IPOPT restores feasibility by a search of its own; without this ours would
    /// give up on 7 of 110 plans that IPOPT finds from some start instead of on one.
    pub search_again: bool,
    /// Whom the planner sees.
    pub sight: SightParameters,
}

impl PlannerParameters {
    /// 2 s ahead in steps of 0.1 s, weights (50, 50, 1) and (1, 1), hard demands, four obstacles in 8 m by 8 m.
    pub fn published() -> Self {
        Self {
            horizon_steps: 20,
            step_s: 0.1,
            state_weight: [50.0, 50.0, 1.0],
            terminal_weight: [50.0, 50.0, 1.0],
            control_weight: [1.0, 1.0],
            violation_weight: 1e5,
            feasibility_tolerance: 1e-4,
            iteration_limit: 60,
            search_again: true,
            sight: SightParameters { window_half_width_m: 4.0, obstacle_limit: 4, margin_m: 0.0 },
        }
    }

    pub(crate) fn validate(&self) -> Result<(), MethodSetupError> {
        self.sight.validate()?;
        non_negative("feasibility_tolerance", self.feasibility_tolerance)
    }
}

/// DCBF-MPC.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DcbfParameters {
    /// The planner.
    pub planner: PlannerParameters,
    /// Share `γ` of the distance left that one step may take, in (0, 1].
    pub gamma: f64,
}

impl DcbfParameters {
    /// `γ = 0.3`.
    pub fn published() -> Self {
        Self { planner: PlannerParameters::published(), gamma: 0.3 }
    }
}

/// RNTC-MPC, with a terminal set that is not the original's.
///
/// The original demands at the last state `x_N` that the signed distance exceeds 1.4 times a residual which a second
/// network, fed with two grids of distances around the robot, writes for this scene: an approximation of the *joint*
/// value function of all obstacles together, with speeds of up to 1 m/s and inputs of ±0.5. Here it demands
/// `h̄_Θ(z_j(x_N, o_N)) ≥ 0` of each obstacle `j` apart, with CN-CBF's own pairwise model, which knows the robot's
/// bounds and its obstacles' speed and turn rate. So this row shows what a terminal set does for a planner, with a better
/// pairwise value function and without the joint one; it says nothing about the original's network.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RntcParameters {
    /// The planner.
    pub planner: PlannerParameters,
    /// What the value function is to exceed at the last state, m. 0 is the safe set itself.
    pub terminal_margin_m: f64,
}

impl RntcParameters {
    /// Terminal margin 0.
    pub fn published() -> Self {
        Self { planner: PlannerParameters::published(), terminal_margin_m: 0.0 }
    }
}

/// What the two filters share.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FilterParameters {
    /// Weight of each squared slack against the squared change of the control.
    pub slack_weight: f64,
    /// Whom the filter sees.
    pub sight: SightParameters,
}

impl FilterParameters {
    /// Weight 10⁶, one slack per obstacle, at most five obstacles; the window is that of the planners, for which nothing
    /// is published.
    pub fn published() -> Self {
        Self {
            slack_weight: 1e6,
            sight: SightParameters { window_half_width_m: 4.0, obstacle_limit: 5, margin_m: 0.0 },
        }
    }

    pub(crate) fn validate(&self) -> Result<(), MethodSetupError> {
        self.sight.validate()?;
        positive("slack_weight", self.slack_weight)
    }
}

/// C3BF, the collision cone barrier.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct C3bfParameters {
    /// The filter.
    pub filter: FilterParameters,
    /// `k` of the class-K function `k·h`, 1/s.
    pub k_per_s: f64,
}

impl C3bfParameters {
    /// `k = 3`.
    pub fn published() -> Self {
        Self { filter: FilterParameters::published(), k_per_s: 3.0 }
    }
}

/// HO-CBF, the distance as a barrier of relative degree two.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HoCbfParameters {
    /// The filter.
    pub filter: FilterParameters,
    /// `k₁` of the first class-K function, 1/s.
    pub k1_per_s: f64,
    /// `k₂` of the second, 1/s. The demand is the same with both exchanged.
    pub k2_per_s: f64,
}

impl HoCbfParameters {
    /// `k₁ = 3`, `k₂ = 2`.
    pub fn published() -> Self {
        Self { filter: FilterParameters::published(), k1_per_s: 3.0, k2_per_s: 2.0 }
    }
}

impl SightParameters {
    fn validate(&self) -> Result<(), MethodSetupError> {
        positive("window_half_width_m", self.window_half_width_m)?;
        if !(1..=messages::MAX_OBSTACLES).contains(&self.obstacle_limit) {
            return Err(MethodSetupError::ObstacleLimit { given: self.obstacle_limit });
        }
        non_negative("margin_m", self.margin_m)
    }
}

pub(crate) fn positive(parameter: &'static str, value: f64) -> Result<(), MethodSetupError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(MethodSetupError::Parameter { parameter, value, requirement: "finite and above 0" })
    }
}

pub(crate) fn non_negative(parameter: &'static str, value: f64) -> Result<(), MethodSetupError> {
    if value.is_finite() && value >= 0.0 {
        Ok(())
    } else {
        Err(MethodSetupError::Parameter { parameter, value, requirement: "finite and at least 0" })
    }
}
