//! What `cncbf run`, `replay`, `bridge` and `nominal` can be told.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use perception_bridge::{Obedience, Playback, SourceChoice};
use settings::ControllerKind;

use super::ProcessArgs;

/// Options of `run`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  cncbf run
  cncbf run --config config/ground_robot_paper.toml --seed 3 --people 15
  cncbf run --scenario crowds.json:busy           docs/scenarios.md describes such files
  cncbf run --source mcap:drive.mcap --duration 20 --report runs/drive
  ROS_DOMAIN_ID=7 cncbf run --source ros2         drives a robot's /cmd_vel until Ctrl-C
  cncbf run --source ros2 --shadow                publishes nothing on /cmd_vel

With --shadow the robot's own command is left untouched; recording and report say what the filter would have done. The simulated \
robot then obeys its nominal controller, and a recorded one drives as it did anyway. A live robot's command_topic is heard as \
the nominal command, unless source.ros2.nominal_topic names another one or --controller a controller of its own.

Exit code: 0 goal reached and nobody touched, or with --shadow or a recording played to its end (Ctrl-C ends a live graph); 1 \
otherwise; 2 unusable arguments or input.")]
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
    /// Only watch: leave the robot's own command untouched and record what the filter would have done
    #[arg(long)]
    pub(crate) shadow: bool,
    /// Scenario of a file, instead of a drawn one: its first, or the one named after a colon [default: simulation.scenario]
    #[arg(long, value_name = "FILE[:NAME]", conflicts_with_all = ["seed", "people"])]
    pub(crate) scenario: Option<PathBuf>,
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
  cncbf replay drive.mcap --closed-loop           a simulated robot that obeys the filter")]
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
    /// Only watch: no command reaches a live robot, and a simulated one obeys its nominal controller
    #[arg(long, conflicts_with = "closed_loop")]
    pub(crate) shadow: bool,
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
  cncbf nominal --controller pure_pursuit    beside `cncbf run --controller external`")]
pub(crate) struct NominalArgs {
    /// Settings and name of the stack
    #[command(flatten)]
    pub(crate) process: ProcessArgs,
    /// Nominal controller [default: nominal.controller]
    #[arg(long, value_enum, value_name = "NAME")]
    pub(crate) controller: Option<Controller>,
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
    pub(crate) fn choice(&self, closed_loop: bool, playback: Playback, shadow: bool) -> SourceChoice {
        match self {
            Self::Sim => SourceChoice::Simulation {
                obeys: if shadow { Obedience::Nominal } else { Obedience::Filter },
            },
            Self::Mcap(file) => SourceChoice::Mcap { file: file.clone(), closed_loop, playback },
            Self::Ros2 => SourceChoice::Ros2 { shadow },
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
    /// Its name on the command line.
    pub(crate) fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

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
