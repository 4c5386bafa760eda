//! `cbf_filter` as a program of its own, for a robot that wants one small binary per process.

use std::path::PathBuf;

use clap::Parser;
use settings::Settings;

/// Correct the nominal command so that nobody is touched: everything in, safe command out
#[derive(Debug, Parser)]
#[command(version, after_help = "Example: cbf_filter --config config/ground_robot.toml --instance demo")]
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
    cbf_filter::shell::run(&Settings::load(&arguments.config)?, &arguments.instance)
}
