//! What the command line can say.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use perception_bridge::SourceChoice;

/// A safety filter for robots among people: composite neural control barrier function, four processes, shared memory.
///
/// Without a subcommand: `cncbf run`, a robot among ten simulated people on this machine.
#[derive(Debug, Parser)]
#[command(name = "cncbf", version, args_conflicts_with_subcommands = true)]
#[command(after_help = "Examples:
  cncbf                                           drive the demo, then write a report
  cncbf replay drive.mcap --json                  what the filter would have done in a recording
  cncbf replay drive.mcap --lockstep              the same in virtual time, byte for byte repeatable
  cncbf why runs/0001/run.mcap 12.5               why it intervened 12.5 s into a run
  cncbf doctor                                    what on this machine would spoil real time

Exit code: 0 success, 1 the thing measured or verified failed, 2 unusable arguments or input.
Log level: environment variable RUST_LOG (error, warn, info, debug); logs go to standard error.")]
pub(crate) struct Cli {
    /// What to do; nothing means `run`.
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    /// Options of `run`.
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Drive: simulated crowd or a recording in real time, four processes, then a verdict and a report.
    Run(RunArgs),
    /// Play a recording through the stack and say what the filter would have done.
    Replay(ReplayArgs),
    /// Explain one moment of a recording made by `run`, `replay` or `record`.
    Why(WhyArgs),
    /// Compute the value function of a settings file's `[offline]` part.
    Solve(SolveArgs),
    /// Fit the network to a solved value function and write the model file.
    Train(TrainArgs),
    /// Show what a model, value function or recording contains.
    Inspect(InspectArgs),
    /// Say what on this machine would spoil real time.
    Doctor(DoctorArgs),
    /// Run the perception bridge alone (process 1).
    Bridge(BridgeArgs),
    /// Run the obstacle estimator alone (process 2).
    Estimator(ProcessArgs),
    /// Run the nominal controller alone (process 3).
    Nominal(ProcessArgs),
    /// Run the safety filter alone (process 4).
    Filter(ProcessArgs),
    /// Write everything that flows into an MCAP file until told to stop.
    Record(RecordArgs),
}

/// What every process of a stack is told.
#[derive(Debug, Clone, Args)]
pub(crate) struct ProcessArgs {
    /// Settings file [default: the built-in config/ground_robot.toml]
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Name of the stack; stacks with different names do not see each other
    #[arg(long, value_name = "NAME", default_value = "cncbf")]
    pub(crate) instance: String,
}

/// Options of `run`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  cncbf run
  cncbf run --config config/ground_robot_paper.toml --seed 3 --people 15
  cncbf run --source mcap:drive.mcap --duration 20 --report runs/drive")]
pub(crate) struct RunArgs {
    /// Settings and name of the stack
    #[command(flatten)]
    pub(crate) process: ProcessArgs,
    /// Where the world comes from: `sim`, or `mcap:FILE`
    #[arg(long, value_name = "SOURCE", default_value = "sim")]
    pub(crate) source: Source,
    /// End after this long, s [default: when the goal is reached or the source ends]
    #[arg(long, value_name = "S")]
    pub(crate) duration: Option<f64>,
    /// Seed of the simulated crowd [default: simulation.seed]
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// Number of simulated people [default: simulation.people]
    #[arg(long, value_name = "N")]
    pub(crate) people: Option<usize>,
    /// Where to write the recording [default: DIR/run.mcap]
    #[arg(long, value_name = "F.mcap")]
    pub(crate) record: Option<PathBuf>,
    /// Folder for the report, the logs and the recording [default: the next free runs/NNNN]
    #[arg(long, value_name = "DIR")]
    pub(crate) report: Option<PathBuf>,
    /// Print the figures as JSON on standard output
    #[arg(long)]
    pub(crate) json: bool,
}

/// Options of `replay`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  cncbf replay drive.mcap                         in real time through the four processes
  cncbf replay drive.mcap --rate max --json       in virtual time, as fast as possible
  cncbf replay drive.mcap --lockstep --repeat 2   twice; the commands' SHA-256 must be equal
  cncbf replay drive.mcap --closed-loop           the recorded people, but a simulated robot that obeys the filter")]
pub(crate) struct ReplayArgs {
    /// Recording with odometry and detections
    #[arg(value_name = "F.mcap")]
    pub(crate) file: PathBuf,
    /// Settings and name of the stack
    #[command(flatten)]
    pub(crate) process: ProcessArgs,
    /// Speed as a multiple of real time, or `max`; anything but 1 plays in virtual time (as --lockstep)
    #[arg(long, value_name = "X|max", default_value = "1")]
    pub(crate) rate: Rate,
    /// One process in virtual time: the same file gives the same bytes on every run
    #[arg(long)]
    pub(crate) lockstep: bool,
    /// Replace the recorded robot by a simulated one, so that the filter's commands matter
    #[arg(long)]
    pub(crate) closed_loop: bool,
    /// Nominal controller [default: nominal.controller]
    #[arg(long, value_enum, value_name = "NAME")]
    pub(crate) controller: Option<Controller>,
    /// Force an evaluation kernel [default: filter.kernel]
    #[arg(long, value_enum)]
    pub(crate) kernel: Option<KernelName>,
    /// Play this many times; in lockstep all must give the same bytes
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) repeat: u32,
    /// End after this much of the recording, s
    #[arg(long, value_name = "S")]
    pub(crate) duration: Option<f64>,
    /// Write what flowed to this MCAP file
    #[arg(long, value_name = "F.mcap")]
    pub(crate) record: Option<PathBuf>,
    /// Folder for the report [default: the next free runs/NNNN in real time, none in lockstep]
    #[arg(long, value_name = "DIR")]
    pub(crate) report: Option<PathBuf>,
    /// Print the figures as JSON on standard output
    #[arg(long)]
    pub(crate) json: bool,
}

/// Options of `why`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Example:
  cncbf why runs/0001/run.mcap 12.5")]
pub(crate) struct WhyArgs {
    /// Recording made by this program
    #[arg(value_name = "F.mcap")]
    pub(crate) file: PathBuf,
    /// Moment, s since the first safe command of the recording
    #[arg(value_name = "T")]
    pub(crate) time_s: f64,
    /// Print as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Options of `solve`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Example:
  cncbf solve config/ground_robot_paper.toml       writes ground_robot_paper.value.safetensors")]
pub(crate) struct SolveArgs {
    /// Settings file with an `[offline]` part
    #[arg(value_name = "CONFIG")]
    pub(crate) config: PathBuf,
    /// Where to write the value function [default: NAME.value.safetensors beside where you are]
    #[arg(long, short, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Print the figures as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Options of `train`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Example:
  cncbf train config/ground_robot_paper.toml       reads ground_robot_paper.value.safetensors (solves first if there is none)")]
pub(crate) struct TrainArgs {
    /// Settings file with an `[offline]` part
    #[arg(value_name = "CONFIG")]
    pub(crate) config: PathBuf,
    /// Solved value function [default: NAME.value.safetensors; solved first if it does not exist]
    #[arg(long, value_name = "FILE")]
    pub(crate) value: Option<PathBuf>,
    /// Where to write the model [default: NAME.safetensors beside where you are]
    #[arg(long, short, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Print the figures as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Options of `inspect`.
#[derive(Debug, Clone, Args)]
pub(crate) struct InspectArgs {
    /// Model, value function or recording
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Print as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Options of `doctor`.
#[derive(Debug, Clone, Args)]
pub(crate) struct DoctorArgs {
    /// How long wake-ups are measured, s
    #[arg(long, value_name = "S", default_value_t = 2.0)]
    pub(crate) seconds: f64,
    /// Print as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Options of `bridge`.
#[derive(Debug, Clone, Args)]
pub(crate) struct BridgeArgs {
    /// Settings and name of the stack
    #[command(flatten)]
    pub(crate) process: ProcessArgs,
    /// Where the world comes from: `sim`, or `mcap:FILE`
    #[arg(long, value_name = "SOURCE", default_value = "sim")]
    pub(crate) source: Source,
    /// Replace a recording's robot by a simulated one that obeys the filter
    #[arg(long)]
    pub(crate) closed_loop: bool,
}

/// Options of `record`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Example:
  cncbf record drive.mcap --instance cncbf")]
pub(crate) struct RecordArgs {
    /// File to write
    #[arg(value_name = "F.mcap")]
    pub(crate) file: PathBuf,
    /// Settings and name of the stack
    #[command(flatten)]
    pub(crate) process: ProcessArgs,
}

/// Where the bridge takes the world from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Source {
    /// The simulated crowd.
    Sim,
    /// A recording.
    Mcap(PathBuf),
}

impl Source {
    /// What the bridge is told.
    pub(crate) fn choice(&self, closed_loop: bool) -> SourceChoice {
        match self {
            Self::Sim => SourceChoice::Simulation,
            Self::Mcap(file) => SourceChoice::Mcap { file: file.clone(), closed_loop },
        }
    }
}

impl std::str::FromStr for Source {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == "sim" => Ok(Self::Sim),
            Some(("mcap", file)) if !file.is_empty() => Ok(Self::Mcap(PathBuf::from(file))),
            _ => Err(format!("unknown source `{text}`; use `sim` or `mcap:FILE`")),
        }
    }
}

impl std::fmt::Display for Source {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Sim => f.write_str("sim"),
            Self::Mcap(file) => write!(f, "mcap:{}", file.display()),
        }
    }
}

/// Speed of a replay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Rate {
    /// A multiple of real time.
    Times(f64),
    /// As fast as possible.
    Max,
}

impl std::str::FromStr for Rate {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        if text == "max" {
            return Ok(Self::Max);
        }
        match text.parse::<f64>() {
            Ok(rate) if rate.is_finite() && rate > 0.0 => Ok(Self::Times(rate)),
            _ => Err(format!("`{text}` is no rate; use a number > 0 such as 0.5 or 4, or `max`")),
        }
    }
}

/// Nominal controllers by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Controller {
    /// Model-predictive controller of the unicycle
    Mpc,
    /// Linear-quadratic regulator of the double integrator
    Lqr,
    /// Keeps still
    Hold,
}

/// Evaluation kernels by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum KernelName {
    /// Runs everywhere
    Portable,
    /// x86-64 with AVX2 and FMA
    Avx2Fma,
}
