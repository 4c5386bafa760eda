//! `nominal_mpc` as a program of its own, for a robot that wants one small binary per process.

use std::path::PathBuf;

use anyhow::Context;
use clap::Parser;
use settings::Settings;

/// Drive to the goal as if nobody else were there: robot state and goal in, nominal command out
#[derive(Debug, Parser)]
#[command(version, after_help = "Example: nominal_mpc --config config/ground_robot.toml --instance demo")]
struct Arguments {
    /// Settings file
    #[arg(long, value_name = "F.toml")]
    config: PathBuf,
    /// Name of the stack
    #[arg(long, default_value = "cncbf", value_name = "NAME")]
    instance: String,
}

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    node_runtime::start_logging();
    let settings = Settings::load(&arguments.config).context("settings")?;
    nominal_mpc::shell::run(&settings, &arguments.instance)
}
