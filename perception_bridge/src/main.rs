//! `perception_bridge` as a program of its own, for a robot that wants one small binary per process.

use std::path::PathBuf;

use clap::Parser;
use perception_bridge::{Obedience, Playback, SourceChoice, shell};
use settings::Settings;

/// Bring the world into the stack and its commands out: robot state, detections and goal in odom; safe commands back
#[derive(Debug, Parser)]
#[command(
    version,
    after_help = "Example: perception_bridge --config config/ground_robot.toml --recording drive.mcap --closed-loop"
)]
struct Arguments {
    /// Settings file
    #[arg(long, value_name = "F.toml")]
    config: PathBuf,
    /// Name of the stack
    #[arg(long, default_value = "cncbf", value_name = "NAME")]
    instance: String,
    /// Recording to play [default: the simulated crowd of the settings]
    #[arg(long, value_name = "F.mcap")]
    recording: Option<PathBuf>,
    /// Join the ROS 2 graph that ROS_DOMAIN_ID names, and drive its robot
    #[arg(long, conflicts_with = "recording")]
    ros2: bool,
    /// Only watch: no command is published to a live robot, and a simulated one obeys its nominal controller
    #[arg(long, conflicts_with = "recording")]
    shadow: bool,
    /// Replace the recording's robot by a simulated one that obeys the filter
    #[arg(long, requires = "recording")]
    closed_loop: bool,
    /// Play the recording this many times as fast; only the timing means anything then
    #[arg(long, value_name = "X", default_value_t = 1.0, requires = "recording")]
    rate: f64,
    /// Play the recording this many times in a row
    #[arg(long, value_name = "N", default_value_t = 1, requires = "recording")]
    passes: u32,
}

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    node_runtime::start_logging();
    let choice = match arguments.recording {
        Some(file) => SourceChoice::Mcap {
            file,
            closed_loop: arguments.closed_loop,
            playback: Playback::new(arguments.rate, arguments.passes)?,
        },
        None if arguments.ros2 => SourceChoice::Ros2 { shadow: arguments.shadow },
        None => SourceChoice::Simulation {
            obeys: if arguments.shadow { Obedience::Nominal } else { Obedience::Filter },
        },
    };
    shell::run(&Settings::load(&arguments.config)?, &arguments.instance, &choice, None)
}
