//! What `cncbf scenarios` can be told.

use std::path::PathBuf;

use clap::Args;

/// Options of `scenarios`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  cncbf scenarios drive.mcap --out worlds.json
  cncbf scenarios eth.mcap hotel.mcap --every 2 --out worlds.json
  cncbf evaluate --scenarios worlds.json          every method among the people recorded

People repeat what they did and take no notice of the robot. docs/scenarios.md has the format and how the ways are chosen.

Exit code: 0 written, 2 unusable arguments, input or output.")]
pub(crate) struct ScenariosArgs {
    /// Recordings with detections that have identities
    #[arg(value_name = "F.mcap", required = true)]
    pub(crate) recordings: Vec<PathBuf>,
    /// Scenario file to write
    #[arg(long, short, value_name = "F.json")]
    pub(crate) out: PathBuf,
    /// Time between the starts of two scenarios, s; below the crossing's time they share people
    #[arg(long, value_name = "S", default_value_t = 5.0, allow_negative_numbers = true)]
    pub(crate) every: f64,
    /// Length of the robot's way, m
    #[arg(long, value_name = "M", default_value_t = 15.0, allow_negative_numbers = true)]
    pub(crate) way: f64,
    /// Time that a crossing is expected to take, s; so much of the recording is left when the last scenario begins
    #[arg(long, value_name = "S", default_value_t = 20.0, allow_negative_numbers = true)]
    pub(crate) crossing: f64,
    /// Time after which a run has failed, s
    #[arg(long, value_name = "S", default_value_t = 60.0, allow_negative_numbers = true)]
    pub(crate) time_limit: f64,
    /// Settings: how recordings are read, and the robot's radius [default: the built-in config/ground_robot.toml]
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
}
