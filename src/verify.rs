//! `cncbf verify`: how far a model can be trusted.

use std::ops::ControlFlow;
use std::path::Path;

use anyhow::Context;
use barrier::{DynamicsKind, Kernel, Model};
use node_runtime::Shutdown;
use reachability::ValueFunction;
use verification::affine::{AffineRecord, Outcome};
use verification::{
    ClosedForm, DisturbancePolicy, NominalPolicy, OnProgress, Phase, Progress, Subject, TrueValue,
    Verification, VerificationPlan, solve_truth, verify as verify_parts,
};

use crate::cli::{DisturbanceName, NominalName, VerifyArgs};
use crate::progress::Bar;

/// Verifies and writes what was found into the model's metadata. Success means: nothing speaks against the model.
pub(crate) fn verify(args: &VerifyArgs) -> anyhow::Result<bool> {
    let model = Model::load(&args.model).with_context(|| format!("cannot use {}", args.model.display()))?;
    let output = args.output.as_ref().unwrap_or(&args.model);
    crate::common::refuse_unwritable(output, "--output")?;
    let truth = truth(&model, args.value.as_deref())?;
    let mut plan = VerificationPlan::standard(args.alpha, args.period, args.slack_weight, args.seed);
    plan.scenario = plan.scenario.filter(|_| args.rollouts > 0);
    if let Some(scenario) = &mut plan.scenario {
        (scenario.rollouts, scenario.horizon_s) = (args.rollouts, args.horizon);
        scenario.nominal = match args.nominal {
            NominalName::TowardObstacle => NominalPolicy::TowardObstacle,
            NominalName::LowersBarrier => NominalPolicy::LowersBarrier,
            NominalName::Random => NominalPolicy::Random,
        };
        scenario.disturbance = match args.disturbance {
            DisturbanceName::LowersBarrier => DisturbancePolicy::LowersBarrier,
            DisturbanceName::Random => DisturbancePolicy::Random,
            DisturbanceName::Zero => DisturbancePolicy::Zero,
        };
    }
    let proof = crate::prove::prove(args, &model)?;
    let (model, verification) = verify_model(&model, Some(&*truth), &plan, proof)?;
    model.save(output).with_context(|| format!("cannot write {}", output.display()))?;
    report(&model, &verification, args.json)?;
    eprintln!("wrote {} (hash {})", output.display(), model.metadata().hash);
    Ok(passed(&verification))
}

/// The value function to judge by: the file if one is named, else the closed form, else solved from the model's own record.
pub(crate) fn truth(model: &Model, file: Option<&Path>) -> anyhow::Result<Box<dyn TrueValue>> {
    let metadata = model.metadata();
    if let Some(file) = file {
        let value: ValueFunction =
            ValueFunction::load(file).with_context(|| format!("cannot use {}", file.display()))?;
        value.check_fits(metadata)?;
        return Ok(Box::new(value));
    }
    if metadata.dynamics == DynamicsKind::DoubleIntegratorPair {
        return Ok(Box::new(ClosedForm::of(metadata)?));
    }
    eprintln!("solving the model's true game to judge by; --value FILE spares that");
    let shutdown = Shutdown::install()?;
    let bar = Bar::new("solving", 1000);
    let value = solve_truth(metadata, &mut |progress| crate::solve::watch(&bar, progress, &shutdown))?;
    bar.finish();
    anyhow::ensure!(!shutdown.requested(), "stopped; nothing was written");
    Ok(Box::new(value))
}

/// Carries out `plan` on the kernel that this machine would fly with, and returns the model with what was found.
pub(crate) fn verify_model(
    model: &Model,
    truth: Option<&dyn TrueValue>,
    plan: &VerificationPlan,
    proof: Option<AffineRecord>,
) -> anyhow::Result<(Model, Verification)> {
    let subject = Subject::new(model, Kernel::detect())?;
    let mut verification = with_bars(|progress| Ok(verify_parts(&subject, truth, plan, progress)?))?;
    verification.affine = proof;
    let mut parts = model.metadata().verification.clone();
    parts.extend(verification.to_metadata()?);
    let all = Verification::from_metadata(&parts)?;
    Ok((model.with_verification(parts)?, all))
}

/// Runs `work` with one progress bar per phase; Ctrl-C stops it.
fn with_bars<T>(work: impl FnOnce(OnProgress<'_>) -> anyhow::Result<T>) -> anyhow::Result<T> {
    let shutdown = Shutdown::install()?;
    let mut current: Option<(Phase, Bar)> = None;
    work(&mut |progress: &Progress| {
        if current.as_ref().is_none_or(|(phase, _)| *phase != progress.phase) {
            if let Some((_, bar)) = current.take() {
                bar.finish();
            }
            current = Some((progress.phase, Bar::new(name(progress.phase), progress.total as u64)));
        }
        if let Some((_, bar)) = &current {
            bar.set(progress.done as u64, || format!("{} of {}", progress.done, progress.total));
            if progress.done == progress.total {
                bar.finish();
            }
        }
        if shutdown.requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })
}

const fn name(phase: Phase) -> &'static str {
    match phase {
        Phase::Structure => "structure",
        Phase::ValueError => "error",
        Phase::Shell => "unsafe shell",
        Phase::Condition => "CBF condition",
        Phase::WorstCondition => "its worst state",
        Phase::Rollouts => "rollouts",
    }
}

/// Prints what is known of the model.
pub(crate) fn report(model: &Model, verification: &Verification, json: bool) -> anyhow::Result<()> {
    if json {
        println!("{}", serde_json::to_string_pretty(model.metadata())?);
    } else {
        println!("{verification}");
    }
    Ok(())
}

/// Whether nothing that was found speaks against flying with the model.
pub(crate) fn passed(verification: &Verification) -> bool {
    let structure = verification.structural.as_ref().is_none_or(|structural| structural.holds);
    let proof = verification.affine.as_ref().is_none_or(|proof| proof.outcome != Outcome::Refuted);
    structure && proof
}
