//! What the command line can say.

mod profile;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use perception_bridge::{Playback, SourceChoice};
use settings::ControllerKind;
use verification::affine::StateBox;

pub(crate) use profile::{LoadArgs, ProfileArgs, TransportName, TriggerName, WaitName};

/// A safety filter for robots among people: composite neural control barrier function, four processes, shared memory.
///
/// Without a subcommand: `cncbf run`, a robot among ten simulated people on this machine.
#[derive(Debug, Parser)]
#[command(name = "cncbf", version, args_conflicts_with_subcommands = true)]
#[command(after_help = "Examples:
  cncbf                                           drive the demo, then write a report
  cncbf replay drive.mcap --json                  what the filter would have done in a recording
  cncbf replay drive.mcap --lockstep              the same in virtual time, byte for byte repeatable
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

/// Options of `run`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  cncbf run
  cncbf run --config config/ground_robot_paper.toml --seed 3 --people 15
  cncbf run --source mcap:drive.mcap --duration 20 --report runs/drive
  ROS_DOMAIN_ID=7 cncbf run --source ros2         drives a robot's /cmd_vel until Ctrl-C")]
pub(crate) struct RunArgs {
    /// Settings and name of the stack
    #[command(flatten)]
    pub(crate) process: ProcessArgs,
    /// Where the world comes from: `sim`, `mcap:FILE`, or `ros2`
    #[arg(long, value_name = "SOURCE", default_value = "sim")]
    pub(crate) source: Source,
    /// End after this long, s [default: when the goal is reached or the source ends]
    #[arg(long, value_name = "S")]
    pub(crate) duration: Option<f64>,
    /// Nominal controller; `external` leaves the place to a program of yours [default: nominal.controller]
    #[arg(long, value_enum, value_name = "NAME")]
    pub(crate) controller: Option<Controller>,
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
  cncbf solve config/ground_robot_paper.toml       writes ground_robot_paper.value.safetensors

Stopped by Ctrl-C or worse, the same command goes on where it was. In Python:
  safetensors.numpy.load_file(\"ground_robot_paper.value.safetensors\")    value, axis_0 .. axis_3")]
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
#[command(after_help = "Examples:
  cncbf train my_robot.toml                        solves, trains, verifies; writes my_robot.safetensors
  cncbf train my_robot.toml --no-verify            a quick look

Stopped by Ctrl-C or worse, the same command goes on where it was.
Exit code 1: the model was written, and its verification speaks against it.")]
pub(crate) struct TrainArgs {
    /// Settings file with an `[offline]` part
    #[arg(value_name = "CONFIG")]
    pub(crate) config: PathBuf,
    /// Solved value function [default: NAME.value.safetensors; solved if it is missing or of other settings]
    #[arg(long, value_name = "FILE")]
    pub(crate) value: Option<PathBuf>,
    /// Where to write the model [default: NAME.safetensors beside where you are]
    #[arg(long, short, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Leave the verification out; `cncbf verify` does it later
    #[arg(long)]
    pub(crate) no_verify: bool,
    /// Print the figures as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Options of `verify`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  cncbf verify models/ground_robot.safetensors                 a few minutes
  cncbf verify my_robot.safetensors --rollouts 0               without the closed loop, seconds
  cncbf verify my_robot.safetensors --value my_robot.value.safetensors --json
  cncbf verify my_robot.safetensors --rollouts 0 --prove 0.8:2,-1:1,-0.5:0.5,0:1 --epsilon 0.25 --minutes 5

Exit code 1: something was found that speaks against the model.")]
pub(crate) struct VerifyArgs {
    /// Model file
    #[arg(value_name = "MODEL")]
    pub(crate) model: PathBuf,
    /// Value function of the true game [default: closed form if there is one, else solved anew]
    #[arg(long, value_name = "FILE")]
    pub(crate) value: Option<PathBuf>,
    /// Gain alpha of the CBF condition, 1/s
    #[arg(long, value_name = "1/S", default_value_t = 4.0)]
    pub(crate) alpha: f64,
    /// Rollouts of the scenario certificate; 0 leaves it out
    #[arg(long, value_name = "N", default_value_t = verification::STANDARD_ROLLOUTS)]
    pub(crate) rollouts: usize,
    /// What the robot would do alone in the rollouts
    #[arg(long, value_enum, value_name = "POLICY", default_value_t = NominalName::TowardObstacle)]
    pub(crate) nominal: NominalName,
    /// What the obstacle does in the rollouts
    #[arg(long, value_enum, value_name = "POLICY", default_value_t = DisturbanceName::LowersBarrier)]
    pub(crate) disturbance: DisturbanceName,
    /// Length of a rollout, s
    #[arg(long, value_name = "S", default_value_t = 5.0)]
    pub(crate) horizon: f64,
    /// Filter period in the rollouts, s
    #[arg(long, value_name = "S", default_value_t = 0.004)]
    pub(crate) period: f64,
    /// Weight of the squared slack in the rollouts' QP
    #[arg(long, value_name = "W", default_value_t = 1e6)]
    pub(crate) slack_weight: f64,
    /// Seed of everything random
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Prove the CBF condition on this box of relative states, one MIN:MAX for each of the four axes
    #[arg(long, value_name = "BOX", value_parser = state_box, allow_hyphen_values = true)]
    pub(crate) prove: Option<StateBox>,
    /// How far the condition may be missed by: C >= -epsilon is to be proven, m/s
    #[arg(long, value_name = "M/S", default_value_t = 0.25, requires = "prove")]
    pub(crate) epsilon: f64,
    /// Longest search for a proof, min; the same command goes on where it ended
    #[arg(long, value_name = "MIN", default_value_t = 5.0, requires = "prove")]
    pub(crate) minutes: f64,
    /// Where to write the model with its verification [default: in place]
    #[arg(long, short, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Print the model's metadata as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Four ranges with colons and commas, such as `0.8:2,-1:1,-0.5:0.5,0:1`.
fn state_box(text: &str) -> Result<StateBox, String> {
    let range = |range: &str| {
        let (min, max) = range.split_once(':')?;
        Some([min.trim().parse().ok()?, max.trim().parse().ok()?])
    };
    let ranges: Option<Vec<[f64; 2]>> = text.split(',').map(range).collect();
    match ranges.as_deref() {
        Some(&[a, b, c, d]) => Ok(StateBox { min: [a[0], b[0], c[0], d[0]], max: [a[1], b[1], c[1], d[1]] }),
        _ => Err("four ranges are needed, such as 0.8:2,-1:1,-0.5:0.5,0:1".to_owned()),
    }
}

/// Options of `inspect`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  cncbf inspect models/ground_robot.safetensors
  cncbf inspect models/quadrotor.safetensors --plot quadrotor.svg
  cncbf inspect my_robot.safetensors --plot my.svg --value my_robot.value.true.safetensors --at 3.14,1.5 --at 0,0.5")]
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
  cncbf doctor                                     the machine, what the kernel grants, ten seconds of wake-ups
  cncbf doctor --seconds 600 --json                long enough to trust the worst; start the robot's own load beside it
  cncbf doctor --config my_robot.toml              what this file's [realtime] would get
  cncbf doctor --instance cncbf                    and what the processes of a running stack were granted

Everything that is asked of the kernel is given back. Each way of waking up gets an equal share of the time, in turns.
Exit code 1: something was found that makes a run miss deadlines or fail, or the filter's rate is not held; 2: unusable
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

/// Options of `bridge`.
#[derive(Debug, Clone, Args)]
pub(crate) struct BridgeArgs {
    /// Settings and name of the stack
    #[command(flatten)]
    pub(crate) process: ProcessArgs,
    /// Where the world comes from: `sim`, `mcap:FILE`, or `ros2`
    #[arg(long, value_name = "SOURCE", default_value = "sim")]
    pub(crate) source: Source,
    /// Replace a recording's robot by a simulated one that obeys the filter
    #[arg(long)]
    pub(crate) closed_loop: bool,
    /// Play a recording this many times as fast; speeds seen by the filter change, so that only the timing means anything
    #[arg(long, value_name = "X", default_value_t = 1.0)]
    pub(crate) rate: f64,
    /// Play a recording this many times in a row
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) passes: u32,
}

/// Options of `nominal`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Example:
  cncbf nominal --controller pure_pursuit          takes the place beside `cncbf run --controller external`")]
pub(crate) struct NominalArgs {
    /// Settings and name of the stack
    #[command(flatten)]
    pub(crate) process: ProcessArgs,
    /// Nominal controller [default: nominal.controller]
    #[arg(long, value_enum, value_name = "NAME")]
    pub(crate) controller: Option<Controller>,
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
    /// The live ROS 2 graph that the environment names.
    Ros2,
}

impl Source {
    /// What the bridge is told.
    pub(crate) fn choice(&self, closed_loop: bool, playback: Playback) -> SourceChoice {
        match self {
            Self::Sim => SourceChoice::Simulation,
            Self::Mcap(file) => SourceChoice::Mcap { file: file.clone(), closed_loop, playback },
            Self::Ros2 => SourceChoice::Ros2,
        }
    }
}

impl std::str::FromStr for Source {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == "sim" => Ok(Self::Sim),
            None if text == "ros2" => Ok(Self::Ros2),
            Some(("mcap", file)) if !file.is_empty() => Ok(Self::Mcap(PathBuf::from(file))),
            _ => Err(format!("unknown source `{text}`; use `sim`, `mcap:FILE` or `ros2`")),
        }
    }
}

impl std::fmt::Display for Source {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Sim => f.write_str("sim"),
            Self::Mcap(file) => write!(f, "mcap:{}", file.display()),
            Self::Ros2 => f.write_str("ros2"),
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
    /// Pure pursuit of the goal by the unicycle
    #[value(name = "pure_pursuit", alias = "pure-pursuit")]
    PurePursuit,
    /// None of these: a program of somebody else's takes the place
    External,
}

impl Controller {
    /// The same in settings.
    pub(crate) const fn kind(self) -> ControllerKind {
        match self {
            Self::Mpc => ControllerKind::Mpc,
            Self::Lqr => ControllerKind::Lqr,
            Self::Hold => ControllerKind::Hold,
            Self::PurePursuit => ControllerKind::PurePursuit,
            Self::External => ControllerKind::External,
        }
    }
}

/// Nominal policies of `verify`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum NominalName {
    /// Drives at the obstacle as fast as it can
    TowardObstacle,
    /// Does what lowers the barrier most
    LowersBarrier,
    /// Another random control now and then
    Random,
}

/// Disturbance policies of `verify`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum DisturbanceName {
    /// Does what lowers the barrier most
    LowersBarrier,
    /// Another random input now and then
    Random,
    /// Goes straight on
    Zero,
}

/// Evaluation kernels by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum KernelName {
    /// Runs everywhere
    Portable,
    /// x86-64 with AVX2 and FMA
    Avx2Fma,
    /// x86-64 with AVX-512
    Avx512,
}
