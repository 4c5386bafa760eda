//! What the command line can say.

mod drive;
mod evaluate;
mod kit;
mod offline;
mod profile;
mod scenarios;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

pub(crate) use drive::{BridgeArgs, Controller, KernelName, NominalArgs, Rate, ReplayArgs, RunArgs, Source};
pub(crate) use evaluate::{EvaluateArgs, RobotName, ScenarioChoice};
pub(crate) use kit::{CheckControllerArgs, CompareArgs, Contestant, World};
pub(crate) use offline::{DisturbanceName, NominalName, SolveArgs, TrainArgs, VerifyArgs};
pub(crate) use profile::{LoadArgs, ProfileArgs, TransportName, TriggerName, WaitName};
pub(crate) use scenarios::ScenariosArgs;

/// A safety filter for robots among people: composite neural control barrier function, four processes, shared memory.
///
/// Without a subcommand: `cncbf run`, a robot among ten simulated people on this machine.
#[derive(Debug, Parser)]
#[command(name = "cncbf", version, args_conflicts_with_subcommands = true)]
#[command(after_help = "Examples:
  cncbf                                           drive the demo, then write a report
  cncbf replay drive.mcap --json                  what the filter would have done in a recording
  cncbf replay drive.mcap --lockstep              the same in virtual time, byte for byte repeatable
  cncbf run --source ros2 --shadow                watch a robot that drives itself
  cncbf check-controller -- python3 mine.py       whether your controller keeps the rules
  cncbf compare mpc pure_pursuit --on drive.mcap  two nominal controllers behind the same filter
  cncbf evaluate --methods cn_cbf --scenarios 20  successes among 5, 10, 15 people
  cncbf profile drive.mcap                        where time goes on this machine
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
    /// Play a recording through the stack and say where time goes: every hop, every loop, nothing filtered away.
    Profile(ProfileArgs),
    /// Start a nominal controller of your own against a test bench and say what it does wrong.
    CheckController(CheckControllerArgs),
    /// Drive the same way with two nominal controllers behind the same filter and show the figures side by side.
    Compare(CompareArgs),
    /// Drive many methods through many random crowds in virtual time; tables of success, with intervals and causes.
    Evaluate(EvaluateArgs),
    /// Cut scenarios for `run` and `evaluate` out of recordings of people.
    Scenarios(ScenariosArgs),
    /// Explain one moment of a recording made by `run`, `replay` or `record`.
    Why(WhyArgs),
    /// Compute the value function of a settings file's `[offline]` part.
    Solve(SolveArgs),
    /// From a robot's settings to a verified model: solve, fit the network, verify.
    Train(TrainArgs),
    /// Say how far a model can be trusted, and write that into its file.
    Verify(VerifyArgs),
    /// Show what a model, value function or recording contains.
    Inspect(InspectArgs),
    /// Say what on this machine would spoil real time.
    Doctor(DoctorArgs),
    /// Run the perception bridge alone (process 1).
    Bridge(BridgeArgs),
    /// Run the obstacle estimator alone (process 2).
    Estimator(ProcessArgs),
    /// Run the nominal controller alone (process 3).
    Nominal(NominalArgs),
    /// Run the safety filter alone (process 4).
    Filter(ProcessArgs),
    /// Write everything that flows into an MCAP file until told to stop.
    Record(RecordArgs),
    /// Make load beside a stack until told to stop; `profile` starts it.
    #[command(hide = true)]
    LoadGenerator(LoadArgs),
}

/// What every process of a stack is told.
#[derive(Debug, Clone, Args)]
pub(crate) struct ProcessArgs {
    /// Settings file [default: the built-in config/ground_robot.toml]
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Name of the stack; stacks with different names do not see each other
    #[arg(long, value_name = "NAME", default_value = "cncbf", value_parser = instance)]
    pub(crate) instance: String,
}

fn instance(text: &str) -> Result<String, node_runtime::NodeError> {
    node_runtime::check_instance(text).map(|()| text.to_owned())
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

/// Options of `inspect`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  cncbf inspect models/ground_robot.safetensors
  cncbf inspect models/quadrotor.safetensors --plot quadrotor.svg
  cncbf inspect my.safetensors --plot my.svg --value my.value.true.safetensors --at 3.14,1.5")]
pub(crate) struct InspectArgs {
    /// Model, value function or recording
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Draw slices of a model to this SVG file: V, h, their zero levels, the failure set, the error
    #[arg(long, value_name = "OUT.svg")]
    pub(crate) plot: Option<PathBuf>,
    /// Value function to draw beside the model [default: the closed form if there is one]
    #[arg(long, value_name = "FILE", requires = "plot")]
    pub(crate) value: Option<PathBuf>,
    /// A slice: third and fourth component of the relative state, rad and m/s or m/s both; may be repeated
    #[arg(long, value_name = "Z3,Z4", requires = "plot", value_parser = pair, allow_negative_numbers = true)]
    pub(crate) at: Vec<[f64; 2]>,
    /// Print as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Two numbers with a comma between them.
fn pair(text: &str) -> Result<[f64; 2], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[third, fourth]) => Ok([third, fourth]),
        _ => Err("two numbers with a comma between them are needed, such as 3.14,1.5".to_owned()),
    }
}

/// Options of `doctor`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  cncbf doctor                                     machine, kernel, ten seconds of wake-ups
  cncbf doctor --seconds 600 --json                long enough to trust the worst
  cncbf doctor --config my_robot.toml              what this file's [realtime] would get
  cncbf doctor --instance cncbf                    and what a running stack was granted

Everything that is asked of the kernel is given back. Each way of waking up gets an equal share of the time, in turns.
Exit code 1: something was found that makes a run miss deadlines or fail, or the filter's rate is not held; 2: unusable \
arguments or settings.")]
pub(crate) struct DoctorArgs {
    /// Settings whose `[realtime]` is tried out, and name of the stack that is looked for
    #[command(flatten)]
    pub(crate) process: ProcessArgs,
    /// How long wake-ups are measured, s
    #[arg(long, value_name = "S", default_value_t = 10.0, allow_negative_numbers = true)]
    pub(crate) seconds: f64,
    /// Print as JSON
    #[arg(long)]
    pub(crate) json: bool,
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
    /// Note in the recording that the filter only watched
    #[arg(long)]
    pub(crate) shadow: bool,
}
