//! Nominal controllers that follow each other while the robot drives, in three languages: nothing else is restarted, nobody is
//! touched, and the recording tells who commanded when.
//!
//! How long nobody commanded is printed and not judged: on a machine that runs other things no process is sure of its time.

#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

#[path = "stack/command.rs"]
mod command;
#[path = "stack/guests.rs"]
mod guests;
#[path = "stack/witness.rs"]
mod witness;

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Child, Command};

use command::{Said, at, cncbf, count, scratch};
use guests::{C_CONTROLLER, Guest, PYTHON_CONTROLLER, c_program, python};
use messages::{Controller, NominalCommand, SafeCommand, SafetyStatus};
use node_runtime::{Clock, Domain, RealClock, ScopedDomain, members};
use recording::read_wire;
use report::{Segment, commanders};
use rustix::process::{Pid, Signal, kill_process};
use witness::Witness;

/// How long each controller drives before it is stopped, ns.
const DRIVE_NS: u64 = 2_000_000_000;
/// Ends a test in which nobody took over; the figure itself is printed.
const LONGEST_GAP_NS: u64 = 5_000_000_000;
/// How often the launcher starts a process again within a minute.
const RESTARTS: usize = 10;
/// How long a guest may take until it has joined the stack.
const PATIENCE_NS: u64 = 30_000_000_000;

/// The demo with our own controller, driving.
struct Drive {
    run: Child,
    witness: Witness,
    since_ns: u64,
}

impl Drive {
    fn begin(domain: &Domain, folder: &Path) -> Self {
        let mut witness = Witness::join(domain, "cncbf");
        let run = cncbf(domain, folder)
            .args(["run", "--people", "4", "--report", "report", "--json"])
            .spawn()
            .expect("the command starts");
        let since_ns = witness.watch_until_it_drives(0);
        Self { run, witness, since_ns }
    }

    /// Lets the one who commands drive for a while, with the next one waiting beside it as `name`.
    fn drive_beside(&mut self, domain: &Domain, name: &str) {
        let give_up_ns = RealClock.now_ns() + PATIENCE_NS;
        self.witness.watch_until("the guest", |_| {
            assert!(RealClock.now_ns() < give_up_ns, "no {name} came");
            pid_of(domain, name).is_some()
        });
        self.since_ns = self.since_ns.max(RealClock.now_ns());
        self.witness.watch_until_a_cycle_after(self.since_ns + DRIVE_NS);
    }

    /// Waits until the filter follows somebody again.
    fn drives_again(&mut self) {
        self.since_ns = self.witness.watch_until_it_drives(RealClock.now_ns());
    }

    /// The end of the run, which must have reached its goal; who commanded when, and every command of the filter.
    fn ended(self, folder: &Path) -> (Said, Vec<Segment>, Vec<SafeCommand>) {
        drop(self.witness);
        let said = Said::of(self.run.wait_with_output().expect("the command ends"));
        assert_eq!(said.code, 0, "{} {}", said.out, said.err);
        let verdict = said.json();
        assert_eq!(at(&verdict, "/outcome"), "reached", "{verdict}");
        assert_eq!(count(&verdict, "/collisions"), 0);
        let recording = folder.join("report/run.mcap");
        (said, commanders(&said_in::<NominalCommand>(&recording)), said_in(&recording))
    }
}

/// Every message of one kind, in the order of the recording.
fn said_in<T: messages::Message>(recording: &Path) -> Vec<T> {
    let stamped = read_wire(recording).expect("a readable recording");
    stamped.into_iter().map(|(_, message)| message).collect()
}

/// The living member of the domain with this name, if there is one.
fn pid_of(domain: &Domain, name: &str) -> Option<Pid> {
    let members = members(domain).expect("a readable domain");
    let member = members.iter().find(|member| member.alive && member.name == name)?;
    Pid::from_raw(i32::try_from(member.pid).expect("a process id"))
}

/// Sends a signal to our own nominal controller.
fn signal_ours(domain: &Domain, signal: Signal) {
    let ours = pid_of(domain, "cncbf/nominal").expect("a nominal controller of ours");
    kill_process(ours, signal).expect("a running controller");
}

/// Our own controller, started by hand.
fn ours_by_hand(domain: &Domain, controller: &str) -> Guest {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cncbf"));
    Guest::start(command.args(["nominal", "--controller", controller]), domain)
}

/// Prints each gap between two controllers with the rungs that the filter chose in it.
fn print_gaps(segments: &[Segment], safe: &[SafeCommand]) {
    for pair in segments.windows(2) {
        let inside = safe
            .iter()
            .filter(|command| (pair[0].end_ns..pair[1].start_ns).contains(&command.ledger.filter_woke_ns));
        let rungs: BTreeSet<_> = inside
            .map(|command| SafetyStatus::try_from(command.status).map_or("?", SafetyStatus::label))
            .collect();
        println!("{} -> {}: {:.1} ms, {rungs:?}", pair[0].name, pair[1].name, pair[1].gap_ns as f64 * 1e-6);
        assert!(pair[1].gap_ns < LONGEST_GAP_NS, "{pair:?}");
    }
}

#[test]
fn rust_python_c_and_rust_again_drive_one_run_to_its_goal() {
    let (Some(python), Some(program)) = (python(), c_program()) else { return };
    let domain = ScopedDomain::new();
    let folder = scratch("swap_languages");
    let mut drive = Drive::begin(&domain, &folder);
    // Not earlier: who waits before anybody has the place gets it.
    let in_python = Guest::python(python, &domain, "pure_pursuit.py", &[]);
    drive.drive_beside(&domain, "cncbf/nominal_python");
    signal_ours(&domain, Signal::TERM);
    drive.drives_again();

    let in_c = Guest::c(program, &domain);
    drive.drive_beside(&domain, "cncbf/nominal_c");
    in_python.end();
    drive.drives_again();

    let in_rust = ours_by_hand(&domain, "mpc");
    drive.drive_beside(&domain, "cncbf/nominal");
    in_c.end();
    drive.drives_again();

    let (said, segments, safe) = drive.ended(&folder);
    in_rust.end();
    assert!(!said.err.contains("ended unexpectedly"), "{}", said.err);
    print_gaps(&segments, &safe);
    let spoke: Vec<_> = segments.iter().map(|segment| segment.controller).collect();
    let mpc = Controller::Mpc.code();
    assert_eq!(spoke, [mpc, PYTHON_CONTROLLER, C_CONTROLLER, mpc], "{segments:?}");
    assert!(segments.iter().all(|segment| segment.commands > 20), "{segments:?}");

    let inspected = Said::by(cncbf(&domain, &folder), &[&"inspect", &"report/run.mcap", &"--json"]);
    let commanded = at(&inspected.json(), "/commanded_by").clone();
    let names: Vec<_> = (0..4).map(|index| at(&commanded, &format!("/{index}/controller")).clone()).collect();
    assert_eq!(names, ["mpc", "external 1000", "external 1001", "mpc"], "{commanded}");
}

#[test]
fn a_run_survives_controllers_that_are_killed_while_another_one_waits() {
    let Some(program) = c_program() else { return };
    let domain = ScopedDomain::new();
    let folder = scratch("swap_killed");
    let mut drive = Drive::begin(&domain, &folder);
    let in_c = Guest::c(program, &domain);
    drive.drive_beside(&domain, "cncbf/nominal_c");
    signal_ours(&domain, Signal::KILL);
    drive.drives_again();
    // Ours was started again and waits, or the other way round.
    drive.drive_beside(&domain, "cncbf/nominal");
    in_c.signal(Signal::KILL);
    drive.drives_again();

    let (said, segments, safe) = drive.ended(&folder);
    drop(in_c);
    assert!(said.err.contains("1 processes ended unexpectedly"), "{}", said.err);
    print_gaps(&segments, &safe);
    assert!(segments.len() > 1, "{segments:?}");
    let last = segments.last().expect("somebody commanded");
    assert_eq!(last.controller, Controller::Mpc.code(), "{segments:?}");
}

#[test]
fn a_run_goes_on_without_ours_while_somebody_else_commands() {
    let Some(program) = c_program() else { return };
    let domain = ScopedDomain::new();
    let folder = scratch("swap_given_up");
    let mut drive = Drive::begin(&domain, &folder);
    let in_c = Guest::c(program, &domain);
    drive.drive_beside(&domain, "cncbf/nominal_c");
    // As often as the launcher starts it again, and once more.
    let give_up_ns = RealClock.now_ns() + PATIENCE_NS;
    let mut killed = BTreeSet::new();
    drive.witness.watch_until("the end of the launcher's patience", |_| {
        assert!(RealClock.now_ns() < give_up_ns, "only {} were killed", killed.len());
        if let Some(ours) = pid_of(&domain, "cncbf/nominal")
            && killed.insert(ours.as_raw_nonzero())
        {
            kill_process(ours, Signal::KILL).expect("a running controller");
        }
        killed.len() > RESTARTS
    });

    let (said, segments, safe) = drive.ended(&folder);
    in_c.end();
    assert!(said.err.contains("somebody else commands"), "{}", said.err);
    print_gaps(&segments, &safe);
    assert_eq!(segments.last().map(|segment| segment.controller), Some(C_CONTROLLER), "{segments:?}");
}
