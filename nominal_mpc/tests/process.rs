//! The program itself, over shared memory: speaks while it is spoken to, falls silent with its input, ends on SIGTERM.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::process::{Child, Command};
use std::time::Duration;

use common::{goal, ground_robot, state};
use messages::{Goal, Health, Intent, NominalCommand, ProcessId, RobotState};
use node_runtime::{Clock, Domain, Node, ProcessLoop, RealClock, ScopedDomain, Tick};
use nominal_mpc::shell::NominalProcess;

const INSTANCE: &str = "nominal";

/// Ends the program with the test, however that ends.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended already; then there is nothing left to do.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn commands_flow_while_robot_states_do() {
    let domain = ScopedDomain::new();
    let node = Node::open_in(&domain, INSTANCE, ProcessId::Bridge).unwrap();
    let states = node.publisher::<RobotState>().unwrap();
    let goals = node.publisher::<Goal>().unwrap();
    let mut commands = node.subscriber::<NominalCommand>().unwrap();
    let config = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/ground_robot.toml");
    let child = Command::new(env!("CARGO_BIN_EXE_nominal_mpc"))
        .args(["--config", config, "--instance", INSTANCE])
        .env(Domain::VARIABLE, domain.prefix())
        .spawn()
        .unwrap();
    let mut running = Running(child);

    let mut received = Vec::new();
    for _ in 0..1_500 {
        let now_ns = RealClock.now_ns();
        let mut robot = state([0.0; 3], now_ns);
        robot.stamp.published_ns = now_ns;
        states.send(&robot).unwrap();
        // Repeated, as by the bridge: a late reader is handed the last goal only when its writer sends again.
        goals.send(&goal(10.0, 0.0)).unwrap();
        std::thread::sleep(Duration::from_millis(10));
        commands.drain(|command| received.push(*command));
        if received.len() >= 10 {
            break;
        }
    }
    assert!(received.len() >= 10, "{} commands in 15 s", received.len());
    for pair in received.windows(2) {
        assert_eq!(pair[1].stamp.sequence, pair[0].stamp.sequence + 1);
    }
    let last = received.last().unwrap();
    assert_eq!(last.intent, Intent::Drive.code());
    assert!(last.control[0] > 0.9, "{last:?}");
    assert!(last.received_ns >= last.bridge_published_ns && last.stamp.published_ns >= last.received_ns);

    // Long past the largest age of a state nothing may be said about it any more.
    std::thread::sleep(Duration::from_millis(400));
    commands.drain(|_| {});
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(commands.drain(|_| {}), 0);

    rustix::process::kill_process(
        rustix::process::Pid::from_child(&running.0),
        rustix::process::Signal::TERM,
    )
    .unwrap();
    assert!(running.0.wait().unwrap().success());
}

#[test]
fn a_state_that_comes_while_a_cycle_is_held_up_was_received_after_it_was_sent() {
    let domain = ScopedDomain::new();
    let bridge = Node::open_in(&domain, INSTANCE, ProcessId::Bridge).unwrap();
    let states = bridge.publisher::<RobotState>().unwrap();
    let goals = bridge.publisher::<Goal>().unwrap();
    let mut commands = bridge.subscriber::<NominalCommand>().unwrap();
    let node = Node::open_in(&domain, INSTANCE, ProcessId::Nominal).unwrap();
    let mut process = NominalProcess::open(&ground_robot(), &node).unwrap();
    let mut cycles = ProcessLoop::new(&node).unwrap();

    let began = Tick::event(RealClock.now_ns());
    std::thread::sleep(Duration::from_millis(20));
    let sent_ns = RealClock.now_ns();
    let mut robot = state([0.0; 3], sent_ns);
    robot.stamp.published_ns = sent_ns;
    states.send(&robot).unwrap();
    goals.send(&goal(10.0, 0.0)).unwrap();
    cycles.cycle(&mut process, &began);

    let command = commands.newest().expect("a command");
    assert_eq!(command.bridge_published_ns, sent_ns);
    assert!(command.received_ns >= sent_ns, "{command:?}");
    assert!(command.stamp.published_ns >= command.received_ns, "{command:?}");
}

#[test]
fn who_waits_for_the_place_says_so_and_then_takes_it() {
    let domain = ScopedDomain::new();
    let node = Node::open_in(&domain, INSTANCE, ProcessId::Launcher).unwrap();
    let mut reports = node.subscriber_all::<Health>().unwrap();
    let place = node.publisher::<NominalCommand>().unwrap();
    let config = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/ground_robot.toml");
    let child = Command::new(env!("CARGO_BIN_EXE_nominal_mpc"))
        .args(["--config", config, "--instance", INSTANCE])
        .env(Domain::VARIABLE, domain.prefix())
        .spawn()
        .unwrap();
    let running = Running(child);
    let mut wait_for = |what: &str, is_it: fn(&Health) -> bool| {
        let give_up_ns = RealClock.now_ns() + 15_000_000_000;
        let mut found = false;
        while !found {
            assert!(RealClock.now_ns() < give_up_ns, "{what}");
            std::thread::sleep(Duration::from_millis(10));
            reports.drain(|report| found |= is_it(report));
        }
    };
    wait_for("nobody says that it waits", |report| report.cycles == 0);
    drop(place);
    wait_for("nobody takes the place", |report| {
        report.cycles > 0 && report.process == ProcessId::Nominal.code()
    });
    drop(running);
}

#[test]
fn settings_that_cannot_be_read_end_the_program_with_one_clear_line() {
    let output = Command::new(env!("CARGO_BIN_EXE_nominal_mpc"))
        .args(["--config", "no/such/file.toml"])
        .output()
        .unwrap();
    assert!(!output.status.success());
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(text.contains("no/such/file.toml"), "{text}");
    assert!(!text.contains("panicked"), "{text}");
}
