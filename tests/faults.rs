//! `kill -9` of each process in a running stack: the robot brakes within 100 ms, and drives again after a restart.
//!
//! # How long is too long on a loaded machine
//! The bound is 100 ms from the kill to the beginning of the filter cycle that brakes. On a machine that runs other things,
//! a process can be kept off the processor for any time, and no deadline of a process that does not run can hold. What can:
//! * No cycle that begins later than 100 ms after the kill does anything but brake. This needs no allowance at all, since
//!   the filter judges by the time at which it woke.
//! * The first braking cycle begins at most 100 ms after the kill, plus the time that the filter itself slept beyond its
//!   period just before that cycle. The ledger of the commands tells: it is the distance of that cycle's beginning from the
//!   one before, less one period. In the same way the simulated robot is granted the lateness of its bridge.
//!
//! Whatever the test itself loses between asking the kernel to kill and the return of that call is granted as well.

#[path = "stack/live.rs"]
mod live;
#[path = "stack/witness.rs"]
mod witness;

use std::path::Path;
use std::time::Duration;

use live::{Kill, LiveStack};
use messages::{ProcessId, Reason, RobotState, SafeCommand, SafetyStatus};
use node_runtime::{ScopedDomain, leftovers};
use settings::Settings;
use witness::Witness;

/// Name of the stack within its own domain.
const INSTANCE: &str = "faults";
const MS: u64 = 1_000_000;
/// From the death of a process to a braking command, or to a robot that slows down.
const LIMIT_NS: u64 = 100 * MS;
/// How long a stack without one of its processes is watched.
const WATCH_NS: u64 = 350 * MS;
/// How long processes may take to end when they are asked to.
const STOP_TIMEOUT: Duration = Duration::from_secs(10);

/// The shipped settings with a few people and a goal that no test reaches.
fn settings() -> Settings {
    let text = include_str!("../config/ground_robot.toml");
    let mut settings =
        Settings::parse(text, Path::new("shipped settings"), Path::new(".")).expect("shipped settings");
    settings.simulation.people = 4;
    settings.simulation.goal = [400.0, 0.0, 0.0];
    settings.simulation.timeout_s = 600.0;
    settings
}

/// How soon something followed a kill.
struct Delay {
    /// From asking for the kill to the effect, ns.
    total_ns: u64,
    /// The part of it that a process was late for want of a processor, ns.
    late_ns: u64,
}

impl Delay {
    fn assert_in_time(&self, kill: Kill, effect: &str) {
        let limit_ns = LIMIT_NS + self.late_ns + (kill.done_ns - kill.asked_ns);
        assert!(self.total_ns <= limit_ns, "{effect} {self} after the kill");
    }
}

impl std::fmt::Display for Delay {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.1} ms ({:.1} ms of it late)", ms(self.total_ns), ms(self.late_ns))
    }
}

fn ms(ns: u64) -> f64 {
    ns as f64 * 1e-6
}

fn brakes(command: &SafeCommand) -> bool {
    [SafetyStatus::Braking.code(), SafetyStatus::Stopped.code()].contains(&command.status)
}

/// Asserts that the filter braked in time and said why.
fn assert_braked(commands: &[SafeCommand], kill: Kill, reason: Reason, period_ns: u64) -> Delay {
    let woke = |index: usize| commands[index].ledger.filter_woke_ns;
    let calm = commands.iter().rposition(|command| !brakes(command)).expect("the robot drove before");
    assert!(
        woke(calm) <= kill.done_ns + LIMIT_NS,
        "a cycle {:.1} ms after the kill did not brake: {:?}",
        ms(woke(calm) - kill.done_ns),
        commands[calm]
    );
    assert!(calm + 1 < commands.len(), "the filter fell silent too");
    // Where commands were lost on the way to this test, nothing is granted.
    let consecutive = commands[calm].sequence + 1 == commands[calm + 1].sequence;
    let gap_ns = if consecutive { woke(calm + 1) - woke(calm) } else { 0 };
    let delay = Delay {
        total_ns: woke(calm + 1).saturating_sub(kill.asked_ns),
        late_ns: gap_ns.saturating_sub(period_ns),
    };
    delay.assert_in_time(kill, "the filter braked");
    let reasons: Vec<_> =
        commands[calm + 1..].iter().map(|command| Reason::try_from(command.reason)).collect();
    assert!(reasons.contains(&Ok(reason)), "the filter braked for {reasons:?} instead of {reason}");
    for command in &commands[calm + 1..] {
        assert!(command.control.iter().all(|value| value.is_finite()), "{command:?}");
    }
    delay
}

/// Asserts that the simulated robot slowed down in time, all by itself, down to a halt.
fn assert_slowed_down(states: &[RobotState], kill: Kill) -> Delay {
    let speed = |index: usize| states[index].velocity_in_base_mps[0];
    let halt = (1..states.len()).rev().find(|&index| speed(index - 1) > 0.0).expect("the robot drove before");
    let mut start = halt;
    while start > 0 && speed(start) < speed(start - 1) {
        start -= 1;
    }
    // `start` is the last state at full speed, the next one is the first that is slower.
    let slower = &states[start + 1].stamp;
    let late_ns = states.iter().filter(|state| {
        state.stamp.published_ns >= kill.asked_ns && state.stamp.valid_at_ns <= slower.valid_at_ns
    });
    let late_ns = late_ns.map(|state| state.stamp.published_ns - state.stamp.valid_at_ns).max().unwrap_or(0);
    let delay = Delay { total_ns: slower.valid_at_ns.saturating_sub(kill.asked_ns), late_ns };
    delay.assert_in_time(kill, "the robot slowed down");
    delay
}

#[test]
fn the_robot_brakes_without_any_one_process_and_drives_again_with_it() {
    let settings = settings();
    let period_ns = settings.filter.period_ms * MS;
    let domain = ScopedDomain::new();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("faults");
    std::fs::create_dir_all(&folder).expect("a writable folder");
    let mut witness = Witness::join(&domain, INSTANCE);
    let mut stack = LiveStack::start(&domain, INSTANCE, &settings, &folder);
    witness.watch_until_it_drives(0);

    for (victim, reason) in [
        (ProcessId::Bridge, Reason::StaleRobotState),
        (ProcessId::Estimator, Reason::SilentEstimator),
        (ProcessId::Nominal, Reason::StaleNominalCommand),
    ] {
        let kill = stack.kill(victim);
        witness.watch_until_a_cycle_after(kill.done_ns + WATCH_NS);
        let delay = assert_braked(&witness.commands, kill, reason, period_ns);
        let restarted_ns = stack.restart(victim);
        let drives_ns = witness.watch_until_it_drives(restarted_ns);
        println!(
            "without {victim}: brakes ({reason}) after {delay}; filtered again {:.1} ms after its restart",
            ms(drives_ns - restarted_ns)
        );
    }

    let kill = stack.kill(ProcessId::Filter);
    witness.watch_until("a robot that stands", |witness| {
        witness.states.last().is_some_and(|state| {
            state.stamp.valid_at_ns > kill.done_ns
                && state.velocity_in_base_mps.iter().all(|&speed| speed == 0.0)
        })
    });
    let delay = assert_slowed_down(&witness.states, kill);
    let last_command = witness.commands.last().expect("commands before the kill");
    assert!(last_command.ledger.filter_woke_ns <= kill.done_ns, "somebody commands without a filter");
    let restarted_ns = stack.restart(ProcessId::Filter);
    let drives_ns = witness.watch_until_it_drives(restarted_ns);
    println!(
        "without filter: the robot slows down after {delay}; filtered again {:.1} ms after its restart",
        ms(drives_ns - restarted_ns)
    );

    drop(witness);
    let report = stack.stop(STOP_TIMEOUT);
    assert_eq!(report.killed, [], "some processes did not end when asked");
    assert_eq!(leftovers(&domain).expect("a readable /dev/shm"), [], "the stack left something behind");
}
