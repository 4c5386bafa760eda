//! What `cncbf profile` and its load generator can be told.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use latency::Budget;
use load_generator::LoadKind;
use node_runtime::Transport;

use super::ProcessArgs;

/// Options of `profile`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  cncbf profile drive.mcap                                        three repeats in real time
  cncbf profile drive.mcap --load cpu --duration 600 --repeat 1   ten minutes beside other work
  cncbf profile drive.mcap --json > new.json
  cncbf profile drive.mcap --baseline runs/0001/profile.json --budget 'end_to_end.p99<=+10%'
  cncbf profile drive.mcap --budget 'end_to_end.p99<=1ms' --budget 'deadline_misses<=0'
  cncbf profile drive.mcap --transport dds --trace dds.json       then open it in ui.perfetto.dev

Nothing is filtered away: outliers stay, and the maximum is exact. Only start-up, until the \
filter has used the first detections, is counted apart. \
At rates other than 1 the filter sees other speeds: only timing means anything then. \
A recording that is shorter than --duration is played again and again; people and robot jump \
back at each beginning. \
`cncbf doctor` tells what this machine grants and how punctual it is without a stack.

Exit code: 0 measured and every budget kept, 1 a budget broken, a process crashed or interrupted, \
2 unusable arguments or input. An unclear budget, within what differs between repeats, is not \
broken.")]
pub(crate) struct ProfileArgs {
    /// Recording with odometry and detections
    #[arg(value_name = "F.mcap")]
    pub(crate) file: PathBuf,
    /// Settings and name of the stack
    #[command(flatten)]
    pub(crate) process: ProcessArgs,
    /// Speed as a multiple of real time
    #[arg(long, value_name = "X", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(crate) rate: f64,
    /// Runs of which each has its own figures; from three on, changes get confidence intervals
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) repeat: u32,
    /// Length of each run from its first sensor message, s [default: until the recording ends]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) duration: Option<f64>,
    /// Other work for the machine meanwhile, in a process of its own
    #[arg(long, value_enum, value_name = "KIND", default_value_t = LoadName::None)]
    pub(crate) load: LoadName,
    /// How all processes wait; `spin` looks all the time, at the default scheduler [default: as the settings say]
    #[arg(long, value_enum, value_name = "HOW")]
    pub(crate) wait: Option<WaitName>,
    /// What begins a filter cycle [default: filter.trigger]
    #[arg(long, value_enum, value_name = "WHAT")]
    pub(crate) trigger: Option<TriggerName>,
    /// What carries the messages [default: environment variable CNCBF_TRANSPORT, else iceoryx2]
    #[arg(long, value_enum, value_name = "WHAT")]
    pub(crate) transport: Option<TransportName>,
    /// Replace the recorded robot by a simulated one that obeys the filter
    #[arg(long)]
    pub(crate) closed_loop: bool,
    /// Folder for the figures, reports, recordings and logs [default: the next free runs/NNNN]
    #[arg(long, value_name = "DIR")]
    pub(crate) report: Option<PathBuf>,
    /// Print the figures as JSON on standard output
    #[arg(long)]
    pub(crate) json: bool,
    /// Compare with an earlier profile.json
    #[arg(long, value_name = "OLD.json")]
    pub(crate) baseline: Option<PathBuf>,
    /// Compare although machine, version, recording or options differ; the differences are listed
    #[arg(long, requires = "baseline")]
    pub(crate) across: bool,
    /// A limit that must be kept, such as `end_to_end.p99<=1ms`; may be repeated
    #[arg(long, value_name = "WHAT<=LIMIT")]
    pub(crate) budget: Vec<Budget>,
    /// Write the last run as a trace for ui.perfetto.dev
    #[arg(long, value_name = "OUT.json")]
    pub(crate) trace: Option<PathBuf>,
}

/// Kinds of load by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum LoadName {
    /// Nothing else to do
    None,
    /// One busy thread on each processor
    Cpu,
    /// One thread on each processor that streams through memory
    Memory,
    /// Blocks written, forced to the disk and deleted
    Io,
}

impl LoadName {
    /// What is to be generated.
    pub(crate) fn kind(self) -> Option<LoadKind> {
        match self {
            Self::None => None,
            Self::Cpu => Some(LoadKind::Cpu),
            Self::Memory => Some(LoadKind::Memory),
            Self::Io => Some(LoadKind::Io),
        }
    }
}

/// Ways to wait by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum WaitName {
    /// Asleep until there is something to do
    Listener,
    /// Awake, looking all the time
    Spin,
}

/// Triggers of the filter by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TriggerName {
    /// Its period
    Timer,
    /// New obstacles
    Event,
    /// Both
    Both,
}

/// Transports by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TransportName {
    /// Shared memory
    Iceoryx2,
    /// DDS, as ROS 2 has it
    Dds,
}

impl TransportName {
    /// What is to carry the messages.
    pub(crate) const fn transport(self) -> Transport {
        match self {
            Self::Iceoryx2 => Transport::Iceoryx2,
            Self::Dds => Transport::Dds,
        }
    }
}

/// Options of `load-generator`.
#[derive(Debug, Clone, Args)]
pub(crate) struct LoadArgs {
    /// What is kept busy
    #[arg(value_enum, value_name = "KIND")]
    pub(crate) load: LoadName,
    /// Folder for the temporary file of `io`
    #[arg(long, value_name = "DIR", default_value = ".")]
    pub(crate) folder: PathBuf,
}
