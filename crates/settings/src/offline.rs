//! How a model is computed: grid, solver, training. What makes a grid fit a robot stands in `covered`, what makes the
//! solved game stricter than the true one in `slack`.

use serde::{Deserialize, Serialize};

use crate::error::{Checked, bounds, non_negative, positive, require};
use crate::{SlackSettings, TrainingSettings};

/// Everything `cncbf solve` and `cncbf train` need beside robot and obstacle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OfflineSettings {
    /// Name of the model, and of the files made for it.
    pub name: String,
    /// Grid of the value function.
    pub grid: GridSettings,
    /// Scheme and end of the solve.
    pub solver: SolverSettings,
    /// Fit of the network.
    pub training: TrainingSettings,
    /// How much stricter than the true game the solved one is; without it, not at all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slack: Option<SlackSettings>,
}

/// A regular grid over the relative state z. A periodic axis leaves its maximum out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GridSettings {
    /// Lower corner, in the units of z.
    pub min: [f64; 4],
    /// Upper corner, in the units of z.
    pub max: [f64; 4],
    /// Nodes along each axis.
    pub count: [usize; 4],
    /// Which axes are periodic.
    pub periodic: [bool; 4],
}

/// Order of the spatial and temporal scheme, under hj_reachability's names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Accuracy {
    /// First-order upwind differences, forward Euler.
    Low,
    /// Second-order essentially non-oscillatory differences, second-order TVD Runge–Kutta.
    Medium,
    /// Third-order weighted essentially non-oscillatory differences, third-order TVD Runge–Kutta.
    High,
    /// Fifth-order weighted essentially non-oscillatory differences, third-order TVD Runge–Kutta.
    VeryHigh,
}

/// How the obstacle of the variational inequality enters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Formulation {
    /// V ← min(V + Δt·Ĥ, ℓ).
    Variational,
    /// V ← V + Δt·min(Ĥ, 0), as in hj_reachability; for comparison.
    Freezing,
}

/// Scheme and end of the solve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolverSettings {
    /// Order of the scheme.
    pub accuracy: Accuracy,
    /// How the obstacle enters.
    pub formulation: Formulation,
    /// Share of the largest stable time step, in (0, 1].
    pub cfl: f64,
    /// The solve stops unconverged after this, s.
    pub max_horizon_s: f64,
    /// Time between two looks at convergence, s.
    pub check_interval_s: f64,
    /// Converged once the share of nodes with V < 0 changes by less than this between two looks.
    pub unsafe_share_tolerance: f64,
}

impl OfflineSettings {
    pub(crate) fn validate(&self) -> Checked {
        require(!self.name.is_empty(), "offline.name", &self.name, "a name")?;
        let grid = &self.grid;
        bounds("offline.grid.min / max", &grid.min, &grid.max)?;
        require(
            grid.count.iter().all(|&n| n >= 4),
            "offline.grid.count",
            grid.count,
            "at least 4 along each axis",
        )?;
        let solver = &self.solver;
        require(solver.cfl > 0.0 && solver.cfl <= 1.0, "offline.solver.cfl", solver.cfl, "in (0, 1]")?;
        positive("offline.solver.max_horizon_s", solver.max_horizon_s)?;
        positive("offline.solver.check_interval_s", solver.check_interval_s)?;
        non_negative("offline.solver.unsafe_share_tolerance", solver.unsafe_share_tolerance)?;
        if let Some(slack) = &self.slack {
            slack.validate()?;
        }
        self.training.validate()
    }
}
