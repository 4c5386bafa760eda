//! What a solve needs to be told besides dynamics, grid and failure function.

use serde::{Deserialize, Serialize};

/// How one-sided derivatives are formed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum UpwindScheme {
    /// First differences: monotone, smears kinks over many nodes.
    FirstOrder,
    /// Essentially non-oscillatory, second order: the smoother of two parabolas.
    Eno2,
    /// Weighted essentially non-oscillatory, third order where smooth (the paper's choice).
    Weno3,
    /// The same at fifth order.
    Weno5,
}

impl UpwindScheme {
    /// Returns how many neighbours to either side the scheme reads.
    pub(crate) fn radius(self) -> usize {
        match self {
            Self::FirstOrder => 1,
            Self::Eno2 | Self::Weno3 => 2,
            Self::Weno5 => 3,
        }
    }
}

/// How a time step is composed of evaluations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TimeIntegrator {
    /// One evaluation, first order.
    Euler,
    /// Two evaluations, total-variation-diminishing Runge–Kutta of second order (Heun).
    TvdRk2,
    /// Three evaluations, total-variation-diminishing Runge–Kutta of third order (Shu and Osher).
    TvdRk3,
}

/// Which bound on `|∂H/∂p_i|` scales the Lax–Friedrichs dissipation and the time step. All are local.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Dissipation {
    /// `|f_i| + Σ_j |G_ij| max|input_j|`: what hj_reachability uses.
    BoxMagnitude,
    /// `max_{u,d} |f_i + (G_u u)_i + (G_d d)_i|`: never larger, hence less smearing and longer steps.
    ReachableSpeed,
    /// `max_p |f_i + (G_u u*(p))_i + (G_d d*(p))_i|`, with the inputs that are optimal for one costate: never larger
    /// again, since robot and obstacle then work against each other wherever they push along the same direction.
    OptimalPlay,
}

/// How the obstacle problem `min{∂V/∂t + H, ℓ − V} = 0` is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TubeForm {
    /// `V ← min(V + Δt Ĥ, ℓ)` after each step: can recover from a numerical undershoot.
    Variational,
    /// `V ← V + Δt min(Ĥ, 0)` in each evaluation: never rises again, hence slightly conservative.
    Freezing,
}

/// When a solve may stop before its longest horizon.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Convergence {
    /// Interval between two checks, s of game time, > 0.
    pub check_interval_s: f64,
    /// Converged when the share of nodes with `V < 0` changed by less than this; 0 never stops.
    pub unsafe_share_tolerance: f64,
    /// If given, `max |ΔV|` over the interior must also be below this, m.
    pub value_tolerance_m: Option<f64>,
    /// Share of each moving bounded axis left out of `max |ΔV|` at either end, in `[0, 0.5)`; there the
    /// extrapolated boundary shows.
    pub boundary_layer: f64,
}

/// Settings of a solve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolverSettings {
    /// One-sided derivatives.
    pub upwind: UpwindScheme,
    /// Time stepping.
    pub integrator: TimeIntegrator,
    /// Dissipation and step-size bound.
    pub dissipation: Dissipation,
    /// Form of the obstacle problem.
    pub tube: TubeForm,
    /// Fraction of the largest stable step (Courant–Friedrichs–Lewy), in `(0, 1]`.
    pub cfl: f64,
    /// Longest horizon, s of game time, > 0.
    pub max_horizon_s: f64,
    /// When to stop earlier.
    pub convergence: Convergence,
}

/// A setting outside its range.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("solver setting `{name}` is {value}; it must be {range}")]
pub struct SettingsError {
    /// Name of the field.
    pub name: &'static str,
    /// What it holds.
    pub value: f64,
    /// What it may hold, in words.
    pub range: &'static str,
}

impl SolverSettings {
    /// Checks every range.
    ///
    /// # Errors
    /// * [`SettingsError`] for the first setting outside its range; NaN is outside.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let check = |ok: bool, name, value, range| {
            if ok { Ok(()) } else { Err(SettingsError { name, value, range }) }
        };
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let c = &self.convergence;
        check(self.cfl > 0.0 && self.cfl <= 1.0, "cfl", self.cfl, "above 0 and at most 1")?;
        check(positive(self.max_horizon_s), "max_horizon_s", self.max_horizon_s, "finite and above 0")?;
        check(positive(c.check_interval_s), "check_interval_s", c.check_interval_s, "finite and above 0")?;
        check(
            c.unsafe_share_tolerance.is_finite() && c.unsafe_share_tolerance >= 0.0,
            "unsafe_share_tolerance",
            c.unsafe_share_tolerance,
            "finite and at least 0",
        )?;
        if let Some(tolerance) = c.value_tolerance_m {
            check(positive(tolerance), "value_tolerance_m", tolerance, "finite and above 0")?;
        }
        check(
            (0.0..0.5).contains(&c.boundary_layer),
            "boundary_layer",
            c.boundary_layer,
            "at least 0 and below 0.5",
        )
    }
}
