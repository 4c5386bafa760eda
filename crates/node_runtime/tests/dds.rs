//! What ports promise over DDS, between nodes of one process and between processes.
//!
//! The other process is this test binary again, with a role in its environment.

#![cfg(feature = "dds")]
#![allow(clippy::unwrap_used)] // helpers of tests may panic as tests do

mod common;

use std::{
    process::{Child, Command, Stdio},
    time::Duration,
};

use bytemuck::Zeroable;
use common::{PATIENCE, eventually, goal};
use messages::{Detections, Goal, Obstacles, ProcessId, SafeCommand};
use node_runtime::{
    Domain, Node, NodeError, Pacer, ScopedDomain, Shutdown, Subscriber, Transport, Waiting, Woken,
};

const ROLE: &str = "CNCBF_TEST_ROLE";
/// Pause between two sendings while the peers have not found each other.
const PAUSE: Duration = Duration::from_millis(5);

fn open(domain: &Domain, instance: &str, process: ProcessId) -> Node {
    Node::open_over(Transport::Dds, domain, instance, process).unwrap()
}

fn obstacles(sequence: u64) -> Obstacles {
    let mut message = Obstacles::zeroed();
    message.stamp.sequence = sequence;
    message.items[messages::MAX_OBSTACLES - 1].track_id = sequence;
    message
}

/// The other process: answers every goal with detections of the same sequence number until it is told to stop.
#[test]
fn other_process() {
    if std::env::var(ROLE).is_err() {
        return;
    }
    let shutdown = Shutdown::install().unwrap();
    let node = Node::open("demo", ProcessId::Bridge).unwrap();
    let mut goals = node.subscriber::<Goal>().unwrap();
    let (answers, waker) =
        (node.publisher::<Detections>().unwrap(), node.waker(ProcessId::Estimator).unwrap());
    let mut timer = Pacer::every(PAUSE, Waiting::ASLEEP);
    let mut answer = None;
    while !shutdown.requested() {
        timer.wait();
        answer = goals.newest().or(answer);
        if let Some(Goal { stamp, .. }) = answer {
            answers.send(&Detections { stamp, ..Detections::zeroed() }).unwrap();
            waker.wake();
        }
    }
}

/// The other process, killed when the test ends.
struct Other(Child);

impl Drop for Other {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn messages_cross_processes_both_ways_and_wake_the_one_they_are_for() {
    let domain = ScopedDomain::new();
    let node = open(&domain, "demo", ProcessId::Estimator);
    let wake_up = node.wake_up().unwrap();
    let mut detections = node.subscriber::<Detections>().unwrap();
    let goals = node.publisher::<Goal>().unwrap();
    // Before anyone listens: the other process joins late and is handed it nevertheless.
    goals.send(&goal(7)).unwrap();
    let _other = Other(
        Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "other_process", "--nocapture"])
            .env(ROLE, "bridge")
            .env(Domain::VARIABLE, domain.prefix())
            .env(Transport::VARIABLE, "dds")
            .stdout(Stdio::null())
            .spawn()
            .unwrap(),
    );
    assert_eq!(wake_up.wait(PATIENCE), Woken::Notified);
    let answer = eventually("detections", || detections.newest());
    assert_eq!(answer, Detections { stamp: goal(7).stamp, ..Detections::zeroed() });
}

#[test]
fn nodes_hear_their_own_instance_alone_in_order_and_are_woken_by_what_is_for_them() {
    let domain = ScopedDomain::new();
    let sender = open(&domain, "one", ProcessId::Estimator);
    let port = sender.publisher::<Obstacles>().unwrap();
    let receiver = open(&domain, "one", ProcessId::Filter);
    let (mut heard, wake_up) = (receiver.subscriber::<Obstacles>().unwrap(), receiver.wake_up().unwrap());
    let stranger = open(&domain, "two", ProcessId::Filter);
    let mut overheard = stranger.subscriber::<Obstacles>().unwrap();
    let refusal = receiver.wake_up().unwrap_err();
    assert!(matches!(refusal, NodeError::Taken { role: "listener", .. }), "{refusal:?}");

    let mut sent = 0;
    eventually("the reader to be found", || {
        sent += 1;
        port.send(&obstacles(sent)).unwrap();
        (wake_up.wait(PAUSE) == Woken::Notified).then_some(())
    });
    while wake_up.wait(100 * PAUSE) == Woken::Notified {}
    heard.drain(|_| {});
    assert_eq!(wake_up.look(), Woken::TimedOut);

    for sequence in sent + 1..=sent + 5 {
        port.send(&obstacles(sequence)).unwrap();
        let message = eventually("the next", || {
            assert_eq!(wake_up.wait(PATIENCE), Woken::Notified, "for {sequence}");
            heard.newest()
        });
        assert_eq!(message, obstacles(sequence));
    }
    for sequence in sent + 6..=sent + 9 {
        port.send(&obstacles(sequence)).unwrap();
    }
    let mut seen = Vec::new();
    eventually("the last", || {
        seen.extend(sequences(&mut heard));
        (seen.last() == Some(&(sent + 9))).then_some(())
    });
    assert!(seen.is_sorted(), "{seen:?}");
    assert_eq!((overheard.newest(), heard.failures()), (None, 0));
}

#[test]
fn a_stream_of_commands_is_not_held_up_by_nobody() {
    let domain = ScopedDomain::new();
    let node = open(&domain, "demo", ProcessId::Filter);
    let port = node.publisher::<SafeCommand>().unwrap();
    for _ in 0..20_000 {
        port.send(&SafeCommand::zeroed()).unwrap();
    }
}

fn sequences(subscriber: &mut Subscriber<Obstacles>) -> Vec<u64> {
    let mut seen = Vec::new();
    subscriber.drain(|message| seen.push(message.stamp.sequence));
    seen
}

#[test]
fn a_process_is_woken_by_its_own_threads() {
    let domain = ScopedDomain::new();
    let node = open(&domain, "own", ProcessId::Bridge);
    let (wake_up, waker) = (node.wake_up().unwrap(), node.waker(ProcessId::Bridge).unwrap());
    assert_eq!(wake_up.wait(Duration::ZERO), Woken::TimedOut);
    std::thread::scope(|threads| {
        threads.spawn(|| waker.wake());
        assert_eq!(wake_up.wait(PATIENCE), Woken::Notified);
    });
    assert_eq!(wake_up.wait(Duration::ZERO), Woken::TimedOut, "once");
}
