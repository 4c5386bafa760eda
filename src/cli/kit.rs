//! What `cncbf check-controller` and `compare` can be told.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{Controller, ProcessArgs};

/// Options of `check-controller`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  cncbf check-controller -- python3 bindings/python/examples/pure_pursuit.py
  cncbf check-controller --config my_robot.toml -- ./my_controller --gain 2
  cncbf check-controller --json -- cncbf nominal --controller mpc

The command is started in shared memory of its own, found through CNCBF_IPC_PREFIX, so that a running stack is not \
disturbed. It meets the stack's services and a simulated robot, alone in an open field, that does what it says. In ten \
to forty seconds it has been given three goals, has been left without robot states, been given one that is not a number, and \
been asked to end. docs/own_controller.md says what is asked of it.

Exit code: 0 every check passed, 1 one failed, 2 the command could not be started or unusable arguments.")]
pub(crate) struct CheckControllerArgs {
    /// Settings file: robot, rates and limits [default: the built-in config/ground_robot.toml]
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Name of the stack that the command is made for
    #[arg(long, value_name = "NAME", default_value = "cncbf", value_parser = super::instance)]
    pub(crate) instance: String,
    /// How long the command may take until it speaks for the first time, s
    #[arg(long, value_name = "S", default_value_t = 15.0, value_parser = seconds)]
    pub(crate) patience: f64,
    /// Print the figures as JSON on standard output
    #[arg(long)]
    pub(crate) json: bool,
    /// The controller to start, with its arguments, after `--`
    #[arg(last = true, required = true, value_name = "COMMAND")]
    pub(crate) command: Vec<OsString>,
}

/// A number of seconds above zero.
fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds.is_finite() && seconds > 0.0 => Ok(seconds),
        _ => Err(format!("`{text}` is no time; use a number of seconds > 0")),
    }
}

/// Options of `compare`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  cncbf compare mpc pure_pursuit --on drive.mcap
  cncbf compare mpc pure_pursuit --on sim:7 --json
  cncbf compare mpc 'cmd:python3 mine.py' --on drive.mcap    in real time

Both meet the recorded people, or the simulated ones, and drive a simulated robot from the same start to the same goal behind \
the same filter. Controllers of ours run in virtual time: the same arguments give the same figures, byte for byte. Where one \
is a program of yours, both run one after the other in real time as the stack that --instance names.

Smoothness is the RMS of the rate of the filter's command, per component, in units of the control per second: smaller is \
smoother. Exit code: 0 compared, 2 unusable arguments or input.")]
pub(crate) struct CompareArgs {
    /// First controller: mpc, lqr, hold, pure_pursuit, or `cmd:COMMAND`
    #[arg(value_name = "A")]
    pub(crate) first: Contestant,
    /// Second controller
    #[arg(value_name = "B")]
    pub(crate) second: Contestant,
    /// Where they drive: a recording, or `sim[:SEED]`
    #[arg(long, value_name = "F.mcap|sim[:SEED]")]
    pub(crate) on: World,
    /// Settings and name of the stack
    #[command(flatten)]
    pub(crate) process: ProcessArgs,
    /// End after this long, s [default: when the goal is reached or the recording ends]
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub(crate) duration: Option<f64>,
    /// Print the figures as JSON on standard output
    #[arg(long)]
    pub(crate) json: bool,
}

/// A controller to compare.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Contestant {
    /// One of ours.
    Own(Controller),
    /// A program, as a shell understands it.
    Command(String),
}

impl std::str::FromStr for Contestant {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            Some(("cmd", command)) if !command.trim().is_empty() => Ok(Self::Command(command.to_owned())),
            _ => match Controller::from_str(text, false) {
                Ok(Controller::External) => {
                    Err("say which program: `cmd:COMMAND`, such as 'cmd:python3 mine.py'".to_owned())
                }
                Ok(controller) => Ok(Self::Own(controller)),
                Err(_) => Err(format!(
                    "unknown controller `{text}`; use mpc, lqr, hold, pure_pursuit, or 'cmd:COMMAND' for a program of yours"
                )),
            },
        }
    }
}

impl std::fmt::Display for Contestant {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Own(controller) => f.write_str(&controller.name()),
            Self::Command(command) => f.write_str(command),
        }
    }
}

/// Where controllers are compared.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum World {
    /// Among the people of a recording.
    Recording(PathBuf),
    /// Among simulated people, with this seed if one was named.
    Simulation(Option<u64>),
}

impl std::str::FromStr for World {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == "sim" => Ok(Self::Simulation(None)),
            Some(("sim", seed)) => match seed.parse() {
                Ok(seed) => Ok(Self::Simulation(Some(seed))),
                Err(_) => Err(format!("`{seed}` is no seed; use a whole number, such as sim:7")),
            },
            _ if text.is_empty() => Err("name a recording, or `sim`".to_owned()),
            _ => Ok(Self::Recording(PathBuf::from(text.strip_prefix("mcap:").unwrap_or(text)))),
        }
    }
}

impl std::fmt::Display for World {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Recording(file) => write!(f, "{}", file.display()),
            Self::Simulation(None) => f.write_str("sim"),
            Self::Simulation(Some(seed)) => write!(f, "sim:{seed}"),
        }
    }
}
