//! `cncbf solve`: the value function of a settings file's `[offline]` part.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use anyhow::Context;
use node_runtime::Shutdown;
use reachability::{
    Grid, Outcome, Progress, SolverSettings, ValueFunction, memory_of_settings_bytes,
    solve_settings_resumable,
};
use settings::{OfflineSettings, Settings};

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

/// Solves with a progress bar and writes the result to `output`. What an interrupted call left is gone on with.
pub(crate) fn solve_to(settings: &Settings, output: &Path) -> anyhow::Result<ValueFunction> {
    crate::common::refuse_unwritable(output, "--output")?;
    let shutdown = Shutdown::install()?;
    let checkpoint = crate::common::beside(output, "checkpoint");
    let memory_mib = memory_of_settings_bytes(settings)? >> 20;
    eprintln!("solving takes up to {memory_mib} MiB of memory; Ctrl-C stops, the same command goes on");
    let bar = Bar::new("solving", 1000);
    let value = solve_settings_resumable(settings, Some(&checkpoint), &mut |progress| {
        watch(&bar, progress, &shutdown)
    })?;
    bar.finish();
    anyhow::ensure!(
        value.metadata().outcome != Outcome::Interrupted,
        "stopped at a horizon of {:.2} s; the same command goes on from {}",
        value.metadata().horizon_s,
        checkpoint.display()
    );
    value.save(output).with_context(|| format!("cannot write {}", output.display()))?;
    crate::common::remove_if_there(&checkpoint)?;
    Ok(value)
}

/// Moves the bar, and says whether to go on.
pub(crate) fn watch(bar: &Bar, progress: &Progress, shutdown: &Shutdown) -> ControlFlow<()> {
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
    if shutdown.requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

/// The value function in `file` if it is what these settings would give, else a newly solved one.
pub(crate) fn load_or_solve(settings: &Settings, file: &Path) -> anyhow::Result<ValueFunction> {
    if !file.exists() {
        return solve_to(settings, file);
    }
    let value = ValueFunction::load(file).with_context(|| format!("cannot use {}", file.display()))?;
    if belongs_to(&value, settings)? {
        eprintln!("using {}", file.display());
        return Ok(value);
    }
    eprintln!("{} is of other settings; it is solved again", file.display());
    solve_to(settings, file)
}

/// Whether `value` is what solving `settings` gives.
fn belongs_to(value: &ValueFunction, settings: &Settings) -> anyhow::Result<bool> {
    let (metadata, offline) = (value.metadata(), offline(settings)?);
    let (problem, game) = (&metadata.problem, settings.training_game());
    let grid: Grid<4> = Grid::try_from(&offline.grid).context("offline.grid")?;
    Ok(problem.failure_radius_m == settings.failure_radius_m()
        && problem.control.min == game.control_min
        && problem.control.max == game.control_max
        && problem.disturbance.min == game.disturbance_min
        && problem.disturbance.max == game.disturbance_max
        && metadata.grid == grid.axes()
        && metadata.solver == SolverSettings::from(&offline.solver))
}

/// The `[offline]` part.
pub(crate) fn offline(settings: &Settings) -> anyhow::Result<&OfflineSettings> {
    settings
        .offline
        .as_ref()
        .context("the settings have no [offline] part; start from config/ground_robot_paper.toml")
}

/// `NAME.value.safetensors` in the working directory.
pub(crate) fn default_value_file(settings: &Settings) -> anyhow::Result<PathBuf> {
    Ok(PathBuf::from(format!("{}.value.safetensors", offline(settings)?.name)))
}
