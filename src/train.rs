//! `cncbf train`: from a settings file to a verified model file.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use anyhow::Context;
use barrier_training::{TrainError, TrainSettingsError, Trained, Values, train_settings};
use node_runtime::Shutdown;
use reachability::ValueFunction;
use settings::{Settings, TargetSource};
use verification::{ClosedForm, TrueValue, VerificationPlan};

use crate::cli::TrainArgs;
use crate::progress::Bar;
use crate::solve::{default_value_file, load_or_solve, offline};
use crate::verify::{report, verify_model};

/// Solves what must be solved, trains, verifies and writes the model. Success means: verified without a finding.
pub(crate) fn train(args: &TrainArgs) -> anyhow::Result<bool> {
    let settings = Settings::load(&args.config)?;
    let offline = offline(&settings)?;
    let output =
        args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}.safetensors", offline.name)));
    crate::common::refuse_unwritable(&output, "--output")?;

    let value_file = args.value.clone().map_or_else(|| default_value_file(&settings), Ok)?;
    let (solved, truth) = match offline.training.target {
        TargetSource::ClosedForm => (None, None),
        TargetSource::Grid if offline.slack.is_none() => (Some(load_or_solve(&settings, &value_file)?), None),
        TargetSource::Grid => {
            eprintln!("two games: the stricter one to learn from, the true one to be judged by");
            let solved = load_or_solve(&settings, &value_file)?;
            let mut without_slack = settings.clone();
            without_slack.offline.as_mut().map(|offline| offline.slack.take());
            (Some(solved), Some(load_or_solve(&without_slack, &crate::common::beside(&value_file, "true"))?))
        }
    };
    let Trained { model, .. } = fit(&settings, solved.as_ref(), truth.as_ref(), &output)?;
    // Saved at once, so that nothing is lost should the verification be stopped.
    model.save(&output).with_context(|| format!("cannot write {}", output.display()))?;
    if args.no_verify {
        println!("wrote {} (hash {}), unverified", output.display(), model.metadata().hash);
        return Ok(true);
    }
    let closed_form;
    let judge: &dyn TrueValue = if let Some(value) = truth.as_ref().or(solved.as_ref()) {
        value
    } else {
        closed_form = ClosedForm::of(model.metadata())?;
        &closed_form
    };
    let filter = &settings.filter;
    let plan = VerificationPlan::standard(
        filter.alpha_per_s,
        filter.period_ms as f64 * 1e-3,
        filter.slack_weight,
        offline.training.seed,
    );
    let (model, verification) = verify_model(&model, Some(judge), &plan, None)?;
    model.save(&output).with_context(|| format!("cannot write {}", output.display()))?;
    report(&model, &verification, args.json)?;
    eprintln!("wrote {} (hash {})", output.display(), model.metadata().hash);
    Ok(crate::verify::passed(&verification))
}

/// Trains with a progress bar. What an interrupted call left is gone on with.
fn fit(
    settings: &Settings,
    solved: Option<&ValueFunction>,
    truth: Option<&ValueFunction>,
    output: &Path,
) -> anyhow::Result<Trained> {
    let checkpoint = crate::common::beside(output, "checkpoint");
    let shutdown = Shutdown::install()?;
    let bar = Bar::new("training", offline(settings)?.training.epochs);
    let trained = train_settings(settings, Values { solved, truth }, Some(&checkpoint), &mut |progress| {
        bar.set(progress.epoch, || {
            let short = progress.short_share;
            let condition =
                short.map_or_else(String::new, |s| format!(", condition short at {:.2} %", s * 100.0));
            format!(
                "epoch {} of {}, loss {:.3e} m²{condition}",
                progress.epoch, progress.epochs, progress.loss
            )
        });
        if shutdown.requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    bar.finish();
    if let Err(TrainSettingsError::Train(TrainError::Stopped { epoch })) = &trained {
        anyhow::bail!("stopped after epoch {epoch}; the same command goes on from {}", checkpoint.display());
    }
    let trained = trained?;
    crate::common::remove_if_there(&checkpoint)?;
    Ok(trained)
}
