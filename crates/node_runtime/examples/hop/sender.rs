//! The process that sends: at fixed times, one way after the other in short rounds.

use std::{
    io::{BufRead, BufReader},
    process::{Child, Command, Stdio},
    sync::atomic::{AtomicUsize, Ordering},
    time::Duration,
};

use bytemuck::Zeroable;
use node_runtime::{Clock, Pacer, RealClock, ScopedDomain, Transport, Waiting, realtime};

use crate::{
    Arguments, Failure, Mode, bare,
    message::{Hop, Sending},
    ports,
};

/// Messages at the beginning of a round that do not count: caches and branch predictors still know the other way.
const WARM_UP: u64 = 5;
/// How long the ways may take to come to life, in messages of each.
const PATIENCE: u64 = 2_500;

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let domain = ScopedDomain::new();
    let mut ends = Vec::new();
    for mode in &arguments.modes {
        let end: Box<dyn Sending> = match mode {
            Mode::Bare => Box::new(bare::Sender::new(domain.prefix())?),
            Mode::Ours => Box::new(ports::Sender::new(Transport::Iceoryx2, &domain)?),
            Mode::Dds => Box::new(ports::Sender::new(Transport::Dds, &domain)?),
        };
        ends.push(end);
    }
    let mut receiver = Receiver::start(domain.prefix())?;
    let output = receiver.0.stdout.take().ok_or("the receiver has no output")?;
    let ready = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        let figures = scope.spawn(|| {
            let lines = BufReader::new(output).lines().map_while(Result::ok);
            lines
                .filter(|line| {
                    let says_ready = line == "ready";
                    ready.fetch_add(usize::from(says_ready), Ordering::Relaxed);
                    !says_ready
                })
                .collect::<Vec<_>>()
        });
        let sent = send(arguments, &mut ends, &ready);
        // The end of its input tells the receiver to print its figures.
        drop(receiver.0.stdin.take());
        let figures = figures.join().map_err(|_| "the reader of the receiver panicked")?;
        sent?;
        if figures.len() < ends.len() {
            return Err("the receiver ended without its figures; what it says is above".into());
        }
        println!("{}", figures.join("\n"));
        Ok(())
    })
}

/// Sends until every way is alive, and then what is to be measured.
fn send(arguments: &Arguments, ends: &mut [Box<dyn Sending>], ready: &AtomicUsize) -> Result<(), Failure> {
    let _rights = realtime::enter(&arguments.rights());
    let mut timer = Pacer::every(Duration::from_micros(arguments.period_us), Waiting::ASLEEP);
    let mut message = Hop::zeroed();
    let mut send = |end: &mut dyn Sending, counts: u64| {
        timer.wait();
        message.counts = counts;
        message.rest.fill(counts);
        message.sent_ns = RealClock.now_ns();
        end.send(&message)
    };
    for attempt in 0.. {
        if ready.load(Ordering::Relaxed) == ends.len() {
            break;
        }
        if attempt == PATIENCE {
            return Err("not every way has come to life; does the receiver say why?".into());
        }
        for end in ends.iter_mut() {
            send(end.as_mut(), 0)?;
        }
    }
    let mut sent = 0;
    for turn in 0.. {
        let due = arguments.round.min(arguments.count - sent);
        if due == 0 {
            break;
        }
        for place in 0..ends.len() {
            // Another way begins each turn, so that none always follows the same one.
            let chosen = (turn + place) % ends.len();
            for number in 0..WARM_UP + due {
                send(ends[chosen].as_mut(), u64::from(number >= WARM_UP))?;
            }
        }
        sent += due;
    }
    Ok(())
}

/// The other process, ended with this one.
struct Receiver(Child);

impl Receiver {
    fn start(prefix: &str) -> Result<Self, Failure> {
        let child = Command::new(std::env::current_exe()?)
            .args(std::env::args_os().skip(1))
            .args(["--receive", prefix])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        Ok(Self(child))
    }
}

impl Drop for Receiver {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
