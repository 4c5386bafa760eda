//! What one hop between two processes costs: a message of 2 KiB at 250 Hz, the receiver asleep, one way.
//!
//! Starts itself as the receiver. The ways take turns in short rounds, so that a machine whose speed changes changes for all of
//! them. Prints one line of JSON for each: `mode`, `count`, `p50_ns`, `p90_ns`, `p99_ns`, `p99_9_ns`, `max_ns`.
//!
//! * `bare`: iceoryx2's own interface, publish and notify, its listener's own wait
//! * `ours`: this crate's ports over iceoryx2
//! * `dds`: this crate's ports over DDS
//!
//! `cargo run --release -p node_runtime --example hop -- --count 5000`
//!
//! `--fifo` is for the threads that send and receive; DDS has threads of its own on the path, which it leaves behind. To give
//! all of them the class, start the program under `chrt -f 80` instead.

mod bare;
mod message;
mod ports;
mod receiver;
mod sender;

use std::error::Error;

use clap::{Parser, ValueEnum};
use node_runtime::realtime::{Request, Scheduler};

/// Anything that stops the measurement.
type Failure = Box<dyn Error + Send + Sync>;

/// A way from one process to the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Mode {
    Bare,
    Ours,
    Dds,
}

/// Measures one hop between two processes.
#[derive(Debug, Clone, Parser)]
struct Arguments {
    /// Ways to measure.
    #[arg(long, value_delimiter = ',', default_value = "bare,ours,dds")]
    modes: Vec<Mode>,
    /// Messages to measure, of each way.
    #[arg(long, default_value_t = 5_000)]
    count: u64,
    /// Messages of one way before the next takes its turn.
    #[arg(long, default_value_t = 250, value_parser = clap::value_parser!(u64).range(1..))]
    round: u64,
    /// Time between two messages, µs.
    #[arg(long, default_value_t = 4_000, value_parser = clap::value_parser!(u64).range(1..))]
    period_us: u64,
    /// Asks for SCHED_FIFO with this priority, for the sending and the receiving threads.
    #[arg(long)]
    fifo: Option<u8>,
    /// Longest time that a processor may take to wake up, µs, asked of the kernel while it runs.
    #[arg(long)]
    cpu_dma_latency_us: Option<u32>,
    /// Receives, for the sender that owns this domain.
    #[arg(long, hide = true)]
    receive: Option<String>,
}

impl Arguments {
    /// What a thread on the path asks of the kernel.
    fn rights(&self) -> Request {
        Request {
            scheduler: self.fifo.map_or(Scheduler::Other, |priority| Scheduler::Fifo { priority }),
            timer_slack_ns: self.fifo.map(|_| 1),
            cpu_dma_latency_us: self.cpu_dma_latency_us,
            ..Request::nothing()
        }
    }
}

fn main() -> Result<(), Failure> {
    let arguments = Arguments::parse();
    match &arguments.receive {
        Some(prefix) => receiver::run(&arguments, prefix),
        None => sender::run(&arguments),
    }
}
