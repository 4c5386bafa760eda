//! What `cncbf evaluate` can be told.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use evaluation::{Partition, PartitionError};

/// Options of `evaluate`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  cncbf evaluate                                            every method of the ground robot
  cncbf evaluate --robot quadrotor --methods cn_cbf,ho_cbf --people 15 --scenarios 20 --report out
  cncbf evaluate --methods cn_cbf,mine=my_robot.toml        settings of your own beside ours
  cncbf evaluate --scenarios my_scenarios.json              worlds of your own: docs/scenarios.md
  cncbf evaluate --set simulation.position_noise_m=0.05     one setting changed for every method
  cncbf evaluate --partition slice:1/4 --out a.parquet      a quarter of the work: deploy/
  cncbf evaluate --merge a.parquet b.parquet --out all.parquet --report out

Stopped by Ctrl-C or worse, the same command goes on where it was. On a cluster the slice is taken from SLURM_ARRAY_TASK_ID \
and SLURM_ARRAY_TASK_COUNT, or from JOB_COMPLETION_INDEX and JOB_COMPLETION_COUNT, and its number enters the file's name. \
docs/evaluation.md says what is measured.

Exit code: 0 all runs are in the table, 1 stopped before, 2 unusable arguments, input or output.")]
pub(crate) struct EvaluateArgs {
    /// Robot whose methods are compared
    #[arg(long, value_enum, value_name = "ROBOT", default_value_t = RobotName::Ground)]
    pub(crate) robot: RobotName,
    /// Methods, with commas: names, or NAME=SETTINGS.toml [default: all there are for the robot]
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    pub(crate) methods: Vec<String>,
    /// Crowd sizes, with commas [default: 5,10,15, and 20 for the quadrotor]
    #[arg(long, value_name = "N,M", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(0..=1000))]
    pub(crate) people: Vec<u32>,
    /// Number of random scenarios for each crowd size, or a file of scenarios
    #[arg(long, value_name = "N|FILE", default_value = "100")]
    pub(crate) scenarios: ScenarioChoice,
    /// Seed of the first random scenario; the others follow it
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(crate) seed: u64,
    /// A setting changed for every method, as in a settings file; may be repeated
    #[arg(long, value_name = "SECTION.KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Share of the work, slice:i/n with i from 1 [default: all, or what a cluster's scheduler says]
    #[arg(long, value_name = "slice:i/n")]
    pub(crate) partition: Option<Partition>,
    /// Threads [default: one per core]
    #[arg(long, value_name = "J", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) jobs: Option<u16>,
    /// Table of runs, Parquet [default: evaluation_ROBOT.parquet]
    #[arg(long, short, value_name = "F.parquet")]
    pub(crate) out: Option<PathBuf>,
    /// Folder for tables and figures of what is in the table
    #[arg(long, value_name = "DIR")]
    pub(crate) report: Option<PathBuf>,
    /// Leave computing times out, so that equal runs give equal bytes
    #[arg(long)]
    pub(crate) no_times: bool,
    /// Run nothing: put these tables together into --out
    #[arg(long, value_name = "F.parquet", num_args = 1.., requires = "out",
          conflicts_with_all = ["methods", "people", "seed", "set", "partition", "jobs", "no_times"])]
    pub(crate) merge: Vec<PathBuf>,
}

/// A robot of the tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum RobotName {
    /// Unicycle with MPC
    Ground,
    /// Double integrator with LQR
    Quadrotor,
}

/// Where scenarios come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum ScenarioChoice {
    /// So many random ones.
    Random(u64),
    /// A file.
    File(PathBuf),
}

impl std::str::FromStr for ScenarioChoice {
    type Err = String;

    /// What is a whole number is one; a file of such a name can be given as `./7`.
    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse() {
            Ok(0) => Err("at least one scenario is needed".to_owned()),
            Ok(count) => Ok(Self::Random(count)),
            Err(_) => Ok(Self::File(PathBuf::from(text))),
        }
    }
}

impl EvaluateArgs {
    /// The share of the work, and whether a scheduler rather than a person asks for it.
    pub(crate) fn partition(&self) -> Result<(Partition, bool), PartitionError> {
        if let Some(partition) = self.partition {
            return Ok((partition, false));
        }
        let asked = Partition::from_environment(|name| std::env::var(name).ok())?;
        Ok((asked.unwrap_or(Partition::WHOLE), asked.is_some()))
    }
}
