//! `cncbf solve`: the value function of a settings file's `[offline]` part.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use anyhow::Context;
use reachability::{Outcome, ValueFunction, solve_settings};
use settings::Settings;

use crate::cli::SolveArgs;
use crate::progress::Bar;

/// Solves and writes the value function. Success means: converged.
pub(crate) fn solve(args: &SolveArgs) -> anyhow::Result<bool> {
    let settings = Settings::load(&args.config)?;
    let output = args.output.clone().map_or_else(|| default_value_file(&settings), Ok)?;
    let value = solve_to(&settings, &output)?;
    let metadata = value.metadata();
    if args.json {
        println!("{}", serde_json::to_string_pretty(metadata)?);
    } else {
        println!("{:>9}  {:>14}  {:>12}", "horizon s", "max change m", "share V < 0");
        for entry in &metadata.history {
            println!("{:>9.2}  {:>14.4}  {:>12.5}", entry.time_s, entry.max_change_m, entry.unsafe_share);
        }
        println!("{:?} after {} steps; wrote {}", metadata.outcome, metadata.steps, output.display());
    }
    Ok(metadata.outcome == Outcome::Converged)
}

/// Solves with a progress bar and writes the result to `output`.
pub(crate) fn solve_to(settings: &Settings, output: &Path) -> anyhow::Result<ValueFunction> {
    crate::common::refuse_unwritable(output)?;
    let bar = Bar::new("solving", 1000);
    let value = solve_settings(settings, &mut |progress| {
        let share = progress.time_s / progress.max_horizon_s;
        let unsafe_share = progress.latest.map_or(0.0, |entry| entry.unsafe_share);
        bar.set((share * 1000.0) as u64, || {
            format!(
                "horizon {:.2} of at most {:.1} s, V < 0 at {:.3} %",
                progress.time_s,
                progress.max_horizon_s,
                unsafe_share * 100.0
            )
        });
        ControlFlow::Continue(())
    })?;
    bar.finish();
    value.save(output).with_context(|| format!("cannot write {}", output.display()))?;
    Ok(value)
}

/// `NAME.value.safetensors` in the working directory.
pub(crate) fn default_value_file(settings: &Settings) -> anyhow::Result<PathBuf> {
    let offline = settings
        .offline
        .as_ref()
        .context("the settings have no [offline] part; start from config/ground_robot_paper.toml")?;
    Ok(PathBuf::from(format!("{}.value.safetensors", offline.name)))
}
