//! What ports promise between processes, one of which is killed, stopped or of another version.
//!
//! The other process is this test binary again, with a role in its environment.

#![allow(clippy::unwrap_used)] // helpers of tests may panic as tests do

mod common;

use std::{
    fs::Permissions,
    os::unix::fs::PermissionsExt,
    path::PathBuf,
    process::{Child, Command, Stdio},
    time::Duration,
};

use common::{PATIENCE, eventually, goal};
use messages::{Goal, ProcessId};
use node_runtime::{
    Domain, Node, Pacer, ScopedDomain, Shutdown, Subscriber, Waiting, clean_up, leftovers, members,
};
use rustix::process::{Pid, Signal, kill_process};

const ROLE: &str = "CNCBF_TEST_ROLE";

/// The other process: does what [`ROLE`] says until it is told to stop. Without a role it is a test that passes.
#[test]
fn other_process() {
    let Ok(role) = std::env::var(ROLE) else { return };
    let shutdown = Shutdown::install().unwrap();
    match role.as_str() {
        "sender" => {
            let node = Node::open("demo", ProcessId::Bridge).unwrap();
            let (port, waker) = (node.publisher::<Goal>().unwrap(), node.waker(ProcessId::Nominal).unwrap());
            let mut timer = Pacer::every(Duration::from_millis(2), Waiting::ASLEEP);
            let mut sequence = 0;
            while !shutdown.requested() {
                timer.wait();
                sequence += 1;
                port.send(&goal(sequence)).unwrap();
                waker.wake();
            }
        }
        "receiver" => {
            let node = Node::open("demo", ProcessId::Nominal).unwrap();
            let (mut goals, wake_up) = (node.subscriber_all::<Goal>().unwrap(), node.wake_up().unwrap());
            while !shutdown.requested() {
                wake_up.wait(Duration::from_millis(20));
                goals.drain(|_| {});
            }
        }
        other => panic!("no such role: {other}"),
    }
}

/// The other process, killed when the test ends.
struct Other(Child);

impl Other {
    fn start(role: &str, domain: &Domain) -> Self {
        let child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "other_process", "--nocapture"])
            .env(ROLE, role)
            .env(Domain::VARIABLE, domain.prefix())
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        Self(child)
    }

    fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.0), signal).unwrap();
    }

    fn kill(&mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }
}

impl Drop for Other {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn hear(goals: &mut Subscriber<Goal>) -> Goal {
    eventually("a goal", || goals.newest())
}

#[test]
fn a_message_crosses_processes_intact_and_wakes_the_receiver() {
    let domain = ScopedDomain::new();
    let node = Node::open_in(&domain, "demo", ProcessId::Nominal).unwrap();
    let (mut goals, wake_up) = (node.subscriber::<Goal>().unwrap(), node.wake_up().unwrap());
    let _sender = Other::start("sender", &domain);
    let heard = eventually("a woken goal", || {
        wake_up.wait(PATIENCE);
        goals.newest()
    });
    assert!(heard.stamp.sequence > 0);
    assert_eq!(heard, goal(heard.stamp.sequence));
}

#[test]
fn a_killed_sender_is_heard_again_after_its_restart() {
    let domain = ScopedDomain::new();
    let node = Node::open_in(&domain, "demo", ProcessId::Nominal).unwrap();
    let mut goals = node.subscriber::<Goal>().unwrap();
    for _ in 0..3 {
        let mut sender = Other::start("sender", &domain);
        hear(&mut goals);
        sender.kill();
        while goals.newest().is_some() {}
        // The slot of the single writer is still taken by the dead process; its successor frees it.
        let _successor = Other::start("sender", &domain);
        assert!(hear(&mut goals).stamp.sequence < 1_000, "a restarted sender counts from the beginning");
    }
}

#[test]
fn a_stopped_and_then_killed_receiver_never_blocks_the_sender() {
    let domain = ScopedDomain::new();
    let node = Node::open_in(&domain, "demo", ProcessId::Bridge).unwrap();
    let (port, waker) = (node.publisher::<Goal>().unwrap(), node.waker(ProcessId::Nominal).unwrap());
    let mut receiver = Other::start("receiver", &domain);
    let send_many = || {
        for sequence in 0..3_000 {
            port.send(&goal(sequence)).unwrap();
            waker.wake();
        }
    };
    send_many();
    std::thread::sleep(Duration::from_millis(300));
    send_many();
    receiver.signal(Signal::STOP);
    send_many();
    receiver.kill();
    send_many();
    let _successor = Other::start("receiver", &domain);
    send_many();
}

#[test]
fn what_killed_processes_leave_behind_is_found_and_removed() {
    let domain = ScopedDomain::new();
    let mut others = [Other::start("sender", &domain), Other::start("receiver", &domain)];
    eventually("both to live", || {
        let members = members(&domain).unwrap();
        (members.iter().filter(|member| member.alive).count() == 2).then_some(())
    });
    assert_eq!(leftovers(&domain).unwrap(), [], "what the living use is no leftover");
    assert_eq!(clean_up(&domain).unwrap(), [], "nor is it removed");
    for other in &mut others {
        other.kill();
    }
    let found = leftovers(&domain).unwrap();
    let segments = found.iter().filter(|leftover| leftover.path.starts_with("/dev/shm")).count();
    assert!(segments > 0 && found.len() > segments, "{found:?}");
    assert_eq!(clean_up(&domain).unwrap(), found);
    assert_eq!(leftovers(&domain).unwrap(), []);
    assert_eq!(members(&domain).unwrap(), []);
}

#[test]
fn a_process_killed_while_it_starts_spoils_nothing() {
    let domain = ScopedDomain::new();
    let node = Node::open_in(&domain, "demo", ProcessId::Nominal).unwrap();
    let mut goals = node.subscriber::<Goal>().unwrap();
    for delay_ms in 0..20 {
        let mut sender = Other::start("sender", &domain);
        std::thread::sleep(Duration::from_millis(delay_ms));
        sender.kill();
    }
    while goals.newest().is_some() {}
    let _sender = Other::start("sender", &domain);
    hear(&mut goals);
}

#[test]
fn a_segment_whose_creator_was_killed_before_it_had_a_size_stops_nobody() {
    let domain = ScopedDomain::new();
    let node = Node::open_in(&domain, "demo", ProcessId::Nominal).unwrap();
    let mut goals = node.subscriber::<Goal>().unwrap();
    let mut sender = Other::start("sender", &domain);
    hear(&mut goals);
    // The connection as a sender leaves it that dies between making it and giving it a size.
    let segments = std::fs::read_dir("/dev/shm").unwrap().map(|entry| entry.unwrap().path());
    let ours = |path: &PathBuf| path.to_string_lossy().contains(domain.prefix());
    let connection =
        segments.filter(ours).find(|path| path.extension().is_some_and(|end| end == "connection"));
    let connection = connection.expect("a heard sender is connected");
    sender.kill();
    while goals.newest().is_some() {}
    drop(goals);
    std::fs::write(&connection, "").unwrap();
    std::fs::set_permissions(&connection, Permissions::from_mode(0o200)).unwrap();
    // Both clean up after the dead sender, whose connection has no size.
    let _sender = Other::start("sender", &domain);
    hear(&mut node.subscriber::<Goal>().unwrap());
    drop(node);
    assert!(!connection.exists());
}

#[test]
fn a_service_whose_creator_was_killed_half_way_is_created_anew() {
    let domain = ScopedDomain::new();
    let node = Node::open_in(&domain, "demo", ProcessId::Bridge).unwrap();
    let file = {
        let _living = node.publisher::<Goal>().unwrap();
        let services = std::fs::read_dir("/tmp/iceoryx2/services").unwrap();
        let mut paths = services.map(|entry| entry.unwrap().path());
        paths.find(|path| path.to_string_lossy().contains(domain.prefix())).unwrap()
    };
    assert!(!file.exists());
    // What iceoryx2 leaves: a description without content that may still be written.
    std::fs::write(&file, "").unwrap();
    std::fs::set_permissions(&file, Permissions::from_mode(0o600)).unwrap();
    let port = node.publisher::<Goal>().unwrap();
    let mut goals = node.subscriber::<Goal>().unwrap();
    port.send(&goal(1)).unwrap();
    assert_eq!(goals.newest(), Some(goal(1)));
}
