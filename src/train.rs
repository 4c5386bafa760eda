//! `cncbf train`: from a solved value function to a model file.

use std::ops::ControlFlow;
use std::path::PathBuf;

use anyhow::Context;
use barrier_training::{Recipe, ResidualGrid, to_model, train as fit};
use reachability::ValueFunction;
use settings::Settings;

use crate::cli::TrainArgs;
use crate::progress::Bar;
use crate::solve::{default_value_file, solve_to};

/// Trains and writes the model; solves first where no value function is found.
pub(crate) fn train(args: &TrainArgs) -> anyhow::Result<bool> {
    let settings = Settings::load(&args.config)?;
    let value_file = args.value.clone().map_or_else(|| default_value_file(&settings), Ok)?;
    let offline = settings.offline.as_ref().context("the settings have no [offline] part")?;
    let output =
        args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}.safetensors", offline.name)));
    crate::common::refuse_unwritable(&output)?;
    let value = if value_file.exists() {
        ValueFunction::load(&value_file).with_context(|| format!("cannot use {}", value_file.display()))?
    } else {
        anyhow::ensure!(args.value.is_none(), "{} does not exist", value_file.display());
        solve_to(&settings, &value_file)?
    };
    let problem = &value.metadata().problem;
    anyhow::ensure!(
        problem.failure_radius_m == settings.failure_radius_m()
            && problem.control.min == settings.robot.control_min
            && problem.control.max == settings.robot.control_max
            && problem.disturbance.min == settings.obstacle.disturbance_min
            && problem.disturbance.max == settings.obstacle.disturbance_max,
        "{} was solved for other bounds or another radius than {}; run `cncbf solve` again",
        value_file.display(),
        args.config.display(),
    );

    let training = &offline.training;
    let recipe = Recipe::default();
    let target = ResidualGrid::try_from(&value)?;
    let bar = Bar::new("training", training.epochs);
    let trained = fit(&target, training, &recipe, &mut |progress| {
        bar.set(progress.epoch, || format!("loss {:.3e} m²", progress.loss));
        ControlFlow::Continue(())
    })?;
    bar.finish();
    let model = to_model(&value, &trained, training, &recipe)?;
    model.save(&output).with_context(|| format!("cannot write {}", output.display()))?;

    let error = &trained.report.fit;
    if args.json {
        println!("{}", serde_json::to_string_pretty(model.metadata())?);
    } else {
        println!(
            "error of V outside the failure set: mean {:.4} m, p99 {:.4} m, max {:.4} m",
            error.outside.mean_m, error.outside.p99_m, error.outside.max_m
        );
        println!(
            "near the zero level (|V| < 0.2 m):  mean {:.4} m, p99 {:.4} m",
            error.near_zero.mean_m, error.near_zero.p99_m
        );
        println!(
            "unsafe states called safe {:.3} %, safe states called unsafe {:.3} %",
            error.false_safe_share * 100.0,
            error.false_unsafe_share * 100.0
        );
        println!("wrote {} (hash {})", output.display(), model.metadata().hash);
    }
    Ok(true)
}
