//! The process that sleeps: one thread for each way, of which the sender wakes one at a time.

use std::{
    io::{Read, stdin},
    sync::atomic::{AtomicBool, Ordering},
};

use clap::ValueEnum;
use hdrhistogram::Histogram;
use node_runtime::{Clock, Domain, RealClock, Transport, realtime};
use serde_json::{Value, json};

use crate::{Arguments, Failure, Mode, bare, message::Receiving, ports};

/// Longest time between two processes that is told apart from a longer one, ns.
const LONGEST_NS: u64 = 10_000_000_000;

/// Receives until the standard input ends, and prints what it measured. Says `ready` for each way that has come to life.
pub(crate) fn run(arguments: &Arguments, prefix: &str) -> Result<(), Failure> {
    let domain = Domain::named(prefix)?;
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let threads: Vec<_> = arguments
            .modes
            .iter()
            .map(|&mode| {
                let (domain, stop) = (&domain, &stop);
                scope.spawn(move || listen(mode, domain, arguments, stop))
            })
            .collect();
        stdin().read_to_end(&mut Vec::new())?;
        stop.store(true, Ordering::Relaxed);
        for (mode, thread) in arguments.modes.iter().zip(threads) {
            let latencies = thread.join().map_err(|_| format!("the receiver of {mode:?} panicked"))??;
            println!("{}", figures(*mode, &latencies));
        }
        Ok(())
    })
}

fn listen(
    mode: Mode,
    domain: &Domain,
    arguments: &Arguments,
    stop: &AtomicBool,
) -> Result<Histogram<u64>, Failure> {
    let mut end: Box<dyn Receiving> = match mode {
        Mode::Bare => Box::new(bare::Receiver::new(domain.prefix())?),
        Mode::Ours => Box::new(ports::Receiver::new(Transport::Iceoryx2, domain)?),
        Mode::Dds => Box::new(ports::Receiver::new(Transport::Dds, domain)?),
    };
    let mut latencies = Histogram::new_with_bounds(1, LONGEST_NS, 3)?;
    let mut alive = false;
    // The whole machine's wake-up time is held by the sender.
    let _rights = realtime::enter(&realtime::Request { cpu_dma_latency_us: None, ..arguments.rights() });
    while !stop.load(Ordering::Relaxed) {
        let Some(message) = end.wait()? else { continue };
        let latency_ns = RealClock.now_ns().saturating_sub(message.sent_ns);
        if message.counts > 0 {
            latencies.saturating_record(latency_ns);
        }
        if !alive {
            println!("ready");
            alive = true;
        }
    }
    Ok(latencies)
}

fn figures(mode: Mode, latencies: &Histogram<u64>) -> Value {
    let name = mode.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned());
    json!({
        "mode": name,
        "count": latencies.len(),
        "p50_ns": latencies.value_at_quantile(0.5),
        "p90_ns": latencies.value_at_quantile(0.9),
        "p99_ns": latencies.value_at_quantile(0.99),
        "p99_9_ns": latencies.value_at_quantile(0.999),
        "max_ns": latencies.max(),
    })
}
