//! What `cncbf solve`, `train` and `verify` can be told.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use verification::affine::StateBox;

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
