//! A whole stack that was killed at once, its launcher included: the next one starts as if nothing had been, and a stack of another
//! name beside it is not disturbed.

#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

#[path = "stack/command.rs"]
mod command;
#[path = "stack/witness.rs"]
mod witness;

use std::path::Path;
use std::process::Child;

use command::{Said, at, cncbf, count, scratch};
use node_runtime::{Domain, Member, ScopedDomain, leftovers, members};
use rustix::process::{Pid, Signal, kill_process};
use witness::Witness;

/// How long a stack drives before it is killed, so that its recorder has written something, ns.
const DRIVE_NS: u64 = 3_000_000_000;

/// A stack called `instance`, once it drives.
fn driving(domain: &Domain, folder: &Path, instance: &str) -> (Child, Witness, u64) {
    let mut witness = Witness::join(domain, instance);
    let run = cncbf(domain, folder)
        .args(["run", "--instance", instance, "--people", "2", "--report", instance, "--json"])
        .spawn()
        .expect("the command starts");
    let since_ns = witness.watch_until_it_drives(0);
    (run, witness, since_ns)
}

fn pid(member: &Member) -> Pid {
    i32::try_from(member.pid).ok().and_then(Pid::from_raw).expect("a process id")
}

/// Kills a stack so that none of its processes does anything after any other has died.
fn kill_at_once(domain: &Domain, launcher: &mut Child, instance: &str) {
    let launcher_pid = Pid::from_child(launcher);
    // Or it would start its children again.
    kill_process(launcher_pid, Signal::STOP).expect("a running launcher");
    let own = Pid::from_raw(i32::try_from(std::process::id()).unwrap()).unwrap();
    let members = members(domain).expect("a readable domain");
    let children: Vec<_> = members
        .iter()
        .filter(|member| member.name.starts_with(&format!("{instance}/")))
        .map(pid)
        .filter(|pid| ![own, launcher_pid].contains(pid))
        .collect();
    assert_eq!(children.len(), 5, "{members:?}");
    for child in children {
        kill_process(child, Signal::KILL).expect("a running process");
    }
    kill_process(launcher_pid, Signal::KILL).expect("a stopped launcher");
    launcher.wait().expect("a dead launcher");
}

/// Asserts that only the living are listed, and that nothing of the dead is left.
fn assert_swept(domain: &Domain) {
    let members = members(domain).expect("a readable domain");
    assert!(members.iter().all(|member| member.alive), "{members:?}");
    assert_eq!(leftovers(domain).expect("a readable /dev/shm"), []);
}

#[test]
fn a_stack_that_was_killed_at_once_starts_again_cleanly() {
    let domain = ScopedDomain::new();
    let folder = scratch("leftovers_again");
    let (mut run, mut witness, since_ns) = driving(&domain, &folder, "robot");
    witness.watch_until_a_cycle_after(since_ns + DRIVE_NS);
    drop(witness);
    kill_at_once(&domain, &mut run, "robot");
    assert!(!leftovers(&domain).expect("a readable /dev/shm").is_empty(), "a crash leaves something");
    let inspected = Said::by(cncbf(&domain, &folder), &[&"inspect", &"robot/run.mcap", &"--json"]);
    assert_eq!(inspected.code, 0, "{}", inspected.err);
    assert!(count(&inspected.json(), "/messages") > 100, "{}", inspected.out);

    let (mut again, witness, _) = driving(&domain, &folder, "robot");
    assert_swept(&domain);
    drop(witness);
    kill_process(Pid::from_child(&again), Signal::INT).expect("a running stack");
    assert_eq!(again.wait().unwrap().code(), Some(1), "it was interrupted on its way");
    assert_eq!(leftovers(&domain).expect("a readable /dev/shm"), []);
}

#[test]
fn a_stack_of_another_name_drives_on_while_its_neighbour_dies_and_returns() {
    let domain = ScopedDomain::new();
    let folder = scratch("leftovers_neighbour");
    let (neighbour, mut watched, since_ns) = driving(&domain, &folder, "neighbour");
    let (mut run, witness, _) = driving(&domain, &folder, "robot");
    drop(witness);
    kill_at_once(&domain, &mut run, "robot");
    let (mut again, witness, returned_ns) = driving(&domain, &folder, "robot");
    assert_swept(&domain);
    drop(witness);
    watched.watch_until_a_cycle_after(returned_ns);
    // A filter that had been started again would count from the beginning.
    let commands = watched.commands.iter().filter(|command| command.ledger.filter_woke_ns > since_ns);
    assert!(commands.map(|command| command.sequence).is_sorted(), "the neighbour's filter was started again");
    drop(watched);
    for child in [&again, &neighbour] {
        kill_process(Pid::from_child(child), Signal::INT).expect("a running stack");
    }
    again.wait().unwrap();
    let said = Said::of(neighbour.wait_with_output().expect("the neighbour ends"));
    assert!(!said.err.contains("ended unexpectedly"), "{}", said.err);
    assert_eq!(count(&said.json(), "/latency/restarts"), 0, "{}", said.out);
    assert_eq!(at(&said.json(), "/outcome"), "not_reached");
    assert_eq!(leftovers(&domain).expect("a readable /dev/shm"), []);
}
