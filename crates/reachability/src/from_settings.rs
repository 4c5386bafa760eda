//! The settings file's words for the game, grid and solver, turned into this crate's. The only place that
//! knows both.

use crate::{
    Axis, Checkpoint, Convergence, Dissipation, Grid, GridError, ProblemDescription, Progress, SolveError,
    SolverSettings, TimeIntegrator, TubeForm, UpwindScheme, ValueFunction, disc_failure_function,
    memory_needed_at_most_bytes, solve_resumable,
};
use dynamics::{
    DoubleIntegratorPair, InputBox, InputBoxError, RelativeDynamics, UnicyclePair, UnicycleStaticPair,
};
use settings::{Accuracy, Formulation, GridSettings, ObstacleMotion, RobotKind, Settings, TrainingGame};
use std::ops::ControlFlow;
use std::path::Path;

/// Share of each moving axis, at either end, where the extrapolated boundary spoils `max |ΔV|`: on the
/// paper's 80 nodes the outer six.
const BOUNDARY_LAYER: f64 = 0.08;

impl TryFrom<&GridSettings> for Grid<4> {
    type Error = GridError;

    fn try_from(settings: &GridSettings) -> Result<Self, GridError> {
        Self::new(std::array::from_fn(|d| Axis {
            min: settings.min[d],
            max: settings.max[d],
            count: settings.count[d],
            periodic: settings.periodic[d],
        }))
    }
}

impl From<&settings::SolverSettings> for SolverSettings {
    fn from(settings: &settings::SolverSettings) -> Self {
        let (upwind, integrator) = match settings.accuracy {
            Accuracy::Low => (UpwindScheme::FirstOrder, TimeIntegrator::Euler),
            Accuracy::Medium => (UpwindScheme::Eno2, TimeIntegrator::TvdRk2),
            Accuracy::High => (UpwindScheme::Weno3, TimeIntegrator::TvdRk3),
            Accuracy::VeryHigh => (UpwindScheme::Weno5, TimeIntegrator::TvdRk3),
        };
        Self {
            upwind,
            integrator,
            dissipation: Dissipation::OptimalPlay,
            tube: match settings.formulation {
                Formulation::Variational => TubeForm::Variational,
                Formulation::Freezing => TubeForm::Freezing,
            },
            cfl: settings.cfl,
            max_horizon_s: settings.max_horizon_s,
            convergence: Convergence {
                check_interval_s: settings.check_interval_s,
                unsafe_share_tolerance: settings.unsafe_share_tolerance,
                // Where the obstacle outruns the robot, far positive values keep falling for as long as the
                // solve runs; only the zero level settles.
                value_tolerance_m: None,
                boundary_layer: BOUNDARY_LAYER,
            },
        }
    }
}

/// Why the game of a settings file could not be solved.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SettingsSolveError {
    /// The file says nothing about how to solve.
    #[error("the settings have no table `offline`; add it, as in config/ground_robot_paper.toml")]
    NoOfflineSettings,
    /// The obstacle's limits do not fit the robot's kind.
    #[error("`obstacle.disturbance_min` and `disturbance_max` do not fit this kind of robot: {0}")]
    Disturbance(InputBoxError),
    /// Only a unicycle has a pair for obstacles that stand still.
    #[error(
        "`obstacle.motion = \"static\"` needs `robot.kind = \"unicycle\"`; set it to \"walking\" for a double integrator"
    )]
    StaticForDoubleIntegrator,
    /// The robot's limits are no box.
    #[error("`robot.control_min` and `control_max`: {0}")]
    Control(InputBoxError),
    /// The grid is none.
    #[error("`offline.grid`: {0}")]
    Grid(#[from] GridError),
    /// The solve failed.
    #[error(transparent)]
    Solve(#[from] SolveError),
}

/// Solves the pairwise game that `settings` describe; what `cncbf solve` calls.
///
/// The inputs are those of [`Settings::training_game`], so with slack the result belongs to a stricter game than the true
/// one, and says so in its description. The failure radius is the robot's plus the default obstacle's, without buffer
/// ([`Settings::failure_radius_m`]); the rest as in [`crate::solve`].
///
/// # Errors
/// See [`SettingsSolveError`].
pub fn solve_settings(
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<ValueFunction, SettingsSolveError> {
    solve_settings_resumable(settings, None, progress)
}

/// As [`solve_settings`], and saves its state to the file `checkpoint` now and then, or continues from it if it is there.
///
/// The result is the same to the bit. The file stays when the solve ends: remove it once the result is saved.
///
/// # Errors
/// As [`solve_settings`]; a checkpoint of other settings is refused ([`SolveError::Checkpoint`]).
pub fn solve_settings_resumable(
    settings: &Settings,
    checkpoint: Option<&Path>,
    progress: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<ValueFunction, SettingsSolveError> {
    let checkpoint = checkpoint.map(Checkpoint::at);
    let game = settings.training_game();
    let control = InputBox::new(game.control_min, game.control_max).map_err(SettingsSolveError::Control)?;
    match (settings.robot.kind, settings.obstacle.motion) {
        (RobotKind::Unicycle, ObstacleMotion::Walking) => {
            let pair = UnicyclePair { control, disturbance: disturbance_box(&game)? };
            solve_pair("unicycle_pair", &pair, settings, checkpoint, progress)
        }
        (RobotKind::Unicycle, ObstacleMotion::Static) => {
            // Refuses inputs for an obstacle that has none.
            disturbance_box::<0>(&game)?;
            solve_pair(
                "unicycle_static_pair",
                &UnicycleStaticPair { control },
                settings,
                checkpoint,
                progress,
            )
        }
        (RobotKind::DoubleIntegrator, ObstacleMotion::Static) => {
            Err(SettingsSolveError::StaticForDoubleIntegrator)
        }
        (RobotKind::DoubleIntegrator, ObstacleMotion::Walking) => {
            let pair = DoubleIntegratorPair { control, disturbance: disturbance_box(&game)? };
            solve_pair("double_integrator_pair", &pair, settings, checkpoint, progress)
        }
    }
}

/// Returns a bound on the memory that solving these settings takes, bytes, to be told before it is taken.
///
/// # Errors
/// * [`SettingsSolveError::NoOfflineSettings`] and [`SettingsSolveError::Grid`].
pub fn memory_of_settings_bytes(settings: &Settings) -> Result<u64, SettingsSolveError> {
    let offline = settings.offline.as_ref().ok_or(SettingsSolveError::NoOfflineSettings)?;
    let inputs = settings.robot.control_min.len() + settings.obstacle.disturbance_min.len();
    Ok(memory_needed_at_most_bytes(&Grid::try_from(&offline.grid)?, inputs))
}

fn solve_pair<const NU: usize, const ND: usize>(
    name: &str,
    pair: &impl RelativeDynamics<4, NU, ND>,
    settings: &Settings,
    checkpoint: Option<Checkpoint<'_>>,
    progress: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<ValueFunction, SettingsSolveError> {
    let offline = settings.offline.as_ref().ok_or(SettingsSolveError::NoOfflineSettings)?;
    let failure_radius_m = settings.failure_radius_m();
    let solution = solve_resumable(
        pair,
        &disc_failure_function(failure_radius_m),
        &Grid::try_from(&offline.grid)?,
        &SolverSettings::from(&offline.solver),
        checkpoint,
        progress,
    )?;
    let problem = ProblemDescription {
        dynamics: name.to_owned(),
        control: pair.control_box().into(),
        disturbance: pair.disturbance_box().into(),
        failure_radius_m,
    };
    Ok(ValueFunction::new(solution, problem))
}

fn disturbance_box<const ND: usize>(game: &TrainingGame) -> Result<InputBox<ND>, SettingsSolveError> {
    InputBox::from_slices(&game.disturbance_min, &game.disturbance_max)
        .map_err(SettingsSolveError::Disturbance)
}
