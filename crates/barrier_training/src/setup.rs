//! From settings to a model: the pair of the settings, the target they ask for, the fit, the record.

use crate::closed_form::ClosedForm;
use crate::error::{TargetError, TrainError};
use crate::export::{ExportError, Source, to_model};
use crate::judge::Judge;
use crate::report::TrainingReport;
use crate::residual_grid::ResidualGrid;
use crate::target::Target;
use crate::train::{Job, Progress, train};
use crate::worst_case::{WorstCase, game};
use barrier::{DynamicsKind, Model};
use core::ops::ControlFlow;
use dynamics::{DoubleIntegratorPair, InputBox, InputBoxError, UnicyclePair, UnicycleStaticPair};
use reachability::closed_form::{ClosedFormError, DoubleIntegratorValue};
use reachability::{Axis, Grid, GridError, ValueFunction};
use settings::{ObstacleMotion, OfflineSettings, RobotKind, Settings, TargetSource};
use std::path::Path;

/// Solved value functions a fit may need.
#[derive(Clone, Copy, Default)]
pub struct Values<'a> {
    /// Of the game to fit, [`Settings::training_game`]; not needed where the target is the closed form.
    pub solved: Option<&'a ValueFunction>,
    /// Of the true game, to measure the fit against; where it is absent, `solved` serves.
    pub truth: Option<&'a ValueFunction>,
}

/// A model and how it came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Trained {
    /// The model, its record included.
    pub model: Model,
    /// How the run went and how well the result fits.
    pub report: TrainingReport,
}

/// Why settings gave no model.
#[derive(Debug, thiserror::Error)]
pub enum TrainSettingsError {
    /// The file says nothing about how to train.
    #[error("the settings have no table `offline`; add it, as in config/ground_robot_paper.toml")]
    NoOfflineSettings,
    /// A grid is to be fitted and none was given.
    #[error("`offline.training.target = \"grid\"` needs a solved value function; run `cncbf solve` first")]
    NoValue,
    /// A closed form is known for double integrators only.
    #[error(
        "`offline.training.target = \"closed_form\"` needs `robot.kind = \"double_integrator\"`; use \"grid\" here"
    )]
    NoClosedForm,
    /// A value function of another game.
    #[error(
        "the {which} value function was solved for {what} other than the settings'; run `cncbf solve` again"
    )]
    OtherGame {
        /// Which of the two.
        which: &'static str,
        /// What differs.
        what: &'static str,
    },
    /// The input boxes are none.
    #[error("`robot.control_*` or `obstacle.disturbance_*`: {0}")]
    Inputs(#[from] InputBoxError),
    /// The grid is none.
    #[error("`offline.grid`: {0}")]
    Grid(#[from] GridError),
    /// The closed form does not hold for these inputs.
    #[error(transparent)]
    ClosedForm(#[from] ClosedFormError),
    /// The value function is no target.
    #[error(transparent)]
    Target(#[from] TargetError),
    /// The fit failed.
    #[error(transparent)]
    Train(#[from] TrainError),
    /// The result makes no model.
    #[error(transparent)]
    Export(#[from] ExportError),
}

/// Trains the model that `settings` describe; what `cncbf train` calls.
///
/// With `target = "closed_form"` no grid is needed and every error is against the exact value of the true game at 100,000
/// random states. Otherwise `values.solved` is fitted, and errors are those at its nodes, or against `values.truth` at the
/// nodes of that. `checkpoint` and `progress` are as in [`train`].
///
/// # Errors
/// See [`TrainSettingsError`].
pub fn train_settings(
    settings: &Settings,
    values: Values<'_>,
    checkpoint: Option<&Path>,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Trained, TrainSettingsError> {
    let offline = settings.offline.as_ref().ok_or(TrainSettingsError::NoOfflineSettings)?;
    let (dynamics, pair) = true_game(settings)?;
    let game = Some((&*pair, settings.filter.alpha_per_s));
    let fit = |target: Target<'_>, judge: &Judge, progress: &mut dyn FnMut(Progress) -> ControlFlow<()>| {
        train(&Job { target, judge, game, settings: &offline.training, checkpoint }, progress)
    };
    let (trained, value) = match offline.training.target {
        TargetSource::ClosedForm => {
            let axes = *Grid::<4>::try_from(&offline.grid)?.axes();
            let training = settings.training_game();
            let solved = closed_form(
                settings,
                offline,
                training.control_min,
                training.control_max,
                [&training.disturbance_min, &training.disturbance_max],
            )?;
            let (robot, obstacle) = (&settings.robot, &settings.obstacle);
            let truth = closed_form(
                settings,
                offline,
                robot.control_min,
                robot.control_max,
                [&obstacle.disturbance_min, &obstacle.disturbance_max],
            )?;
            let judge = Judge::of_closed_form(&truth, axes);
            (fit(Target::ClosedForm(&solved), &judge, progress)?, None)
        }
        TargetSource::Grid => {
            let value = values.solved.ok_or(TrainSettingsError::NoValue)?;
            check_solved(settings, value)?;
            let grid = ResidualGrid::try_from(value)?;
            let judge = match values.truth {
                Some(truth) => {
                    check_truth(settings, truth)?;
                    Judge::of_grid(&ResidualGrid::try_from(truth)?)
                }
                None => Judge::of_grid(&grid),
            };
            (fit(Target::Grid(&grid), &judge, progress)?, Some(value))
        }
    };
    let source = Source { settings, offline, dynamics, value, truth: values.truth };
    let model = to_model(&source, &trained)?;
    Ok(Trained { model, report: trained.report })
}

/// The true game of the settings, by the filter's name for it and as what its worst case is.
fn true_game(settings: &Settings) -> Result<(DynamicsKind, Box<dyn WorstCase>), TrainSettingsError> {
    let (robot, obstacle) = (&settings.robot, &settings.obstacle);
    let control = InputBox::new(robot.control_min, robot.control_max)?;
    Ok(match (robot.kind, obstacle.motion) {
        (RobotKind::Unicycle, ObstacleMotion::Walking) => {
            let disturbance = InputBox::from_slices(&obstacle.disturbance_min, &obstacle.disturbance_max)?;
            (DynamicsKind::UnicyclePair, game(UnicyclePair { control, disturbance }))
        }
        (RobotKind::Unicycle, ObstacleMotion::Static) => {
            (DynamicsKind::UnicycleStaticPair, game(UnicycleStaticPair { control }))
        }
        // A standing obstacle of a double integrator is refused when the settings are read.
        (RobotKind::DoubleIntegrator, ObstacleMotion::Walking | ObstacleMotion::Static) => {
            let disturbance = InputBox::from_slices(&obstacle.disturbance_min, &obstacle.disturbance_max)?;
            (DynamicsKind::DoubleIntegratorPair, game(DoubleIntegratorPair { control, disturbance }))
        }
    })
}

fn closed_form(
    settings: &Settings,
    offline: &OfflineSettings,
    control_min: [f64; 2],
    control_max: [f64; 2],
    disturbance: [&[f64]; 2],
) -> Result<ClosedForm, TrainSettingsError> {
    if settings.robot.kind != RobotKind::DoubleIntegrator {
        return Err(TrainSettingsError::NoClosedForm);
    }
    let control = InputBox::new(control_min, control_max)?;
    let radius_m = settings.failure_radius_m();
    let value = DoubleIntegratorValue::new(
        &control,
        &InputBox::from_slices(disturbance[0], disturbance[1])?,
        radius_m,
    )?;
    let value_m = Box::new(move |z: &[f64; 4]| value.value_m(z));
    Ok(ClosedForm::new(value_m, radius_m, offline.grid.min, offline.grid.max))
}

/// Refuses a value function that is not of the game to fit.
fn check_solved(settings: &Settings, value: &ValueFunction) -> Result<(), TrainSettingsError> {
    let game = settings.training_game();
    let inputs = [&game.control_min[..], &game.control_max, &game.disturbance_min, &game.disturbance_max];
    check_game("solved", settings, value, inputs)
}

/// Refuses a value function that is not of the true game.
fn check_truth(settings: &Settings, value: &ValueFunction) -> Result<(), TrainSettingsError> {
    let (robot, obstacle) = (&settings.robot, &settings.obstacle);
    let inputs =
        [&robot.control_min[..], &robot.control_max, &obstacle.disturbance_min, &obstacle.disturbance_max];
    check_game("true", settings, value, inputs)
}

fn check_game(
    which: &'static str,
    settings: &Settings,
    value: &ValueFunction,
    inputs: [&[f64]; 4],
) -> Result<(), TrainSettingsError> {
    let problem = &value.metadata().problem;
    let given =
        [&problem.control.min, &problem.control.max, &problem.disturbance.min, &problem.disturbance.max];
    let refuse = |what| Err(TrainSettingsError::OtherGame { which, what });
    if problem.failure_radius_m != settings.failure_radius_m() {
        return refuse("a failure radius");
    }
    if inputs.iter().zip(given).any(|(wanted, given)| wanted != given) {
        return refuse("input boxes");
    }
    Ok(())
}

/// The domain of the settings.
pub(crate) fn domain(offline: &OfflineSettings) -> [Axis; 4] {
    let grid = &offline.grid;
    core::array::from_fn(|k| Axis {
        min: grid.min[k],
        max: grid.max[k],
        count: grid.count[k],
        periodic: grid.periodic[k],
    })
}
