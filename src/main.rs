//! The `cncbf` command: parses arguments and hands over. One file per subcommand; no logic of its own.

mod check_controller;
mod cli;
mod common;
mod compare;
mod doctor;
mod evaluate;
mod inspect;
mod inspect_plot;
mod lockstep;
mod outcome;
mod process;
mod profile;
mod progress;
mod prove;
mod replay;
mod run;
mod run_folder;
mod scenarios;
mod session;
mod silence;
mod solve;
mod train;
mod verify;
mod why;
mod zero_level;

use std::process::ExitCode;

use clap::Parser;

use cli::{Cli, Command};

fn main() -> ExitCode {
    let cli = Cli::parse();
    node_runtime::start_logging();
    let outcome = match cli.command.unwrap_or(Command::Run(cli.run)) {
        Command::Run(args) => run::run(&args),
        Command::Replay(args) => replay::replay(&args),
        Command::Profile(args) => profile::profile(&args),
        Command::CheckController(args) => check_controller::check_controller(&args),
        Command::Compare(args) => compare::compare(&args),
        Command::Evaluate(args) => evaluate::evaluate(&args),
        Command::Scenarios(args) => scenarios::scenarios(&args),
        Command::Why(args) => why::why(&args),
        Command::Solve(args) => solve::solve(&args),
        Command::Train(args) => train::train(&args),
        Command::Verify(args) => verify::verify(&args),
        Command::Inspect(args) => inspect::inspect(&args),
        Command::Doctor(args) => doctor::doctor(&args),
        Command::Bridge(args) => process::bridge(&args),
        Command::Estimator(args) => process::estimator(&args),
        Command::Nominal(args) => process::nominal(&args),
        Command::Filter(args) => process::filter(&args),
        Command::Record(args) => process::record(&args),
        Command::LoadGenerator(args) => profile::load_generator(&args),
    };
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            eprintln!("error: {}", in_one_line(&error));
            ExitCode::from(2)
        }
    }
}

/// An error with its causes; those that an outer message already quotes are not told twice.
fn in_one_line(error: &anyhow::Error) -> String {
    error.chain().skip(1).map(ToString::to_string).fold(error.to_string(), |told, cause| {
        if told.contains(&cause) { told } else { format!("{told}: {cause}") }
    })
}
