//! `cncbf evaluate`: methods, crowds and scenarios in, a table of runs out.

mod output;
mod pooled;

use std::path::{Path, PathBuf};

use anyhow::Context;
use evaluation::{Campaign, Done, Partition, Robot, Row, Scenario, Store, Variant, merged, write_table};
use node_runtime::Shutdown;

use crate::cli::{EvaluateArgs, RobotName, ScenarioChoice};
use crate::progress::Bar;

/// Runs what the table lacks, or merges tables. Success means: every run asked for is in it.
pub(crate) fn evaluate(args: &EvaluateArgs) -> anyhow::Result<bool> {
    if let Some(folder) = &args.report {
        std::fs::create_dir_all(folder).with_context(|| {
            format!("cannot make the folder {}; name another one with --report", folder.display())
        })?;
    }
    let (rows, complete) = if args.merge.is_empty() { compute(args)? } else { (merge(args)?, true) };
    let methods = methods(args);
    if let Some(folder) = &args.report {
        output::write(&rows, &methods, folder, &command_line())?;
        eprintln!("wrote {}", folder.join("evaluation.html").display());
    }
    print!("{}", output::overview(&rows, &methods));
    Ok(complete)
}

/// The robot of the methods.
const fn robot(args: &EvaluateArgs) -> Robot {
    match args.robot {
        RobotName::Ground => Robot::Ground,
        RobotName::Quadrotor => Robot::Quadrotor,
    }
}

/// The methods asked for, in the order of tables and figures; all there are if none is named.
fn methods(args: &EvaluateArgs) -> Vec<String> {
    if args.methods.is_empty() {
        Variant::names(robot(args)).into_iter().map(str::to_owned).collect()
    } else {
        args.methods.clone()
    }
}

fn compute(args: &EvaluateArgs) -> anyhow::Result<(Vec<Row>, bool)> {
    let (partition, scheduled) = args.partition()?;
    let file = table_file(args, partition, scheduled);
    // Everything that can be wrong with the arguments is found before anything is written.
    let campaign = Campaign {
        variants: variants(args)?,
        scenarios: scenarios(args)?,
        partition,
        build_hash: build_hash()?,
        jobs: args.jobs.map(usize::from),
        keep_times: !args.no_times,
    };
    let mut store = Store::open(&file)?;
    let shutdown = Shutdown::install()?;
    let missing = campaign.missing(&store)?.len();
    eprintln!("{missing} runs to do; {} keeps them, Ctrl-C stops, the same command goes on", file.display());
    let bar = Bar::new("evaluating", missing as u64);
    let done = campaign.run(&mut store, &|| shutdown.requested(), &|progress| {
        bar.set(progress.done, || format!("{} of {} runs", progress.done, progress.total));
    })?;
    bar.finish();
    eprintln!("{}", told(&done));
    if done.stopped {
        // The parts stay beside the table: nothing has to be gathered in a hurry.
        return Ok((store.rows().cloned().collect(), false));
    }
    Ok((store.finish()?, true))
}

fn told(done: &Done) -> String {
    let Done { known, added, simulated_s, thread_s, stopped } = *done;
    let speed = simulated_s / thread_s.max(1e-9);
    let end = if stopped { "; stopped: the same command goes on" } else { "" };
    format!("{added} runs done, {known} were there; {speed:.0} simulated seconds per second and thread{end}")
}

fn merge(args: &EvaluateArgs) -> anyhow::Result<Vec<Row>> {
    let rows = merged(&args.merge)?;
    let out = args.out.as_deref().context("--merge needs --out")?;
    write_table(out, &rows.iter().collect::<Vec<_>>())?;
    eprintln!("{} runs in {}", rows.len(), out.display());
    Ok(rows)
}

fn variants(args: &EvaluateArgs) -> anyhow::Result<Vec<Variant>> {
    let robot = robot(args);
    let variants: Result<Vec<Variant>, _> =
        methods(args).iter().map(|name| Variant::named(robot, name, &args.set)).collect();
    let variants = variants?;
    for (index, variant) in variants.iter().enumerate() {
        let twice = variants[..index].iter().any(|earlier| earlier.name() == variant.name());
        anyhow::ensure!(!twice, "the method {} is named twice; give each its own name", variant.name());
    }
    Ok(variants)
}

fn scenarios(args: &EvaluateArgs) -> anyhow::Result<Vec<Scenario>> {
    match &args.scenarios {
        ScenarioChoice::Random(count) => {
            let last = args.seed.checked_add(count - 1);
            anyhow::ensure!(last.is_some(), "--seed {} leaves no room for {count} seeds", args.seed);
            let people =
                if args.people.is_empty() { robot(args).crowds().to_vec() } else { args.people.clone() };
            Ok(Scenario::random_set(args.seed, *count, &people))
        }
        ScenarioChoice::File(file) => {
            anyhow::ensure!(
                args.people.is_empty(),
                "the scenarios of {} have their own people; leave --people out",
                file.display()
            );
            Ok(Scenario::from_file(file)?)
        }
    }
}

/// The table this call writes. Jobs of one array share their command line, so each gets its number into the name.
fn table_file(args: &EvaluateArgs, partition: Partition, scheduled: bool) -> PathBuf {
    let name = match args.robot {
        RobotName::Ground => "evaluation_ground.parquet",
        RobotName::Quadrotor => "evaluation_quadrotor.parquet",
    };
    let file = args.out.clone().unwrap_or_else(|| PathBuf::from(name));
    match partition.parts() {
        Some((index, count)) if scheduled => crate::common::beside(&file, &format!("{index}-of-{count}")),
        Some(_) | None => file,
    }
}

/// Fingerprint of this very program: a table goes on only with the build that began it.
fn build_hash() -> anyhow::Result<String> {
    let program: PathBuf = std::env::current_exe().context("cannot find this program's own file")?;
    let bytes = std::fs::read(Path::new(&program)).context("cannot read this program's own file")?;
    Ok(evaluation::short_hash(&bytes))
}

/// The command as it was given, for the report.
fn command_line() -> String {
    let mut words = std::env::args();
    words.next();
    words.fold("cncbf".to_owned(), |line, word| line + " " + &word)
}
