//! A Python program in the nominal controller's place: from the beginning, and taken over while the robot drives.
//!
//! Needs `python3` and PyPI for `iceoryx2`; where the virtual environment cannot be made, the tests say so and end.

#[path = "stack/command.rs"]
mod command;
#[path = "stack/witness.rs"]
mod witness;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;

use command::{Said, at, cncbf, count, scratch};
use messages::{Controller, NominalCommand, SafeCommand, SafetyStatus};
use node_runtime::{Domain, ScopedDomain, members};
use recording::read_wire;
use rustix::process::{Pid, Signal, kill_process};
use witness::Witness;

/// What the example calls itself on the wire.
const PYTHON_CONTROLLER: u32 = 1000;
/// Ends a test in which nobody took over; the figure itself is printed.
const LONGEST_GAP_NS: u64 = 5_000_000_000;
/// How long the first controller drives before it is stopped, ns.
const DRIVE_NS: u64 = 2_000_000_000;

/// The interpreter of a virtual environment that holds this repository's package; `None` where none can be made.
fn python() -> Option<&'static Path> {
    static PYTHON: OnceLock<Option<PathBuf>> = OnceLock::new();
    PYTHON.get_or_init(|| make_venv().map_err(|why| println!("skipped: {why}")).ok()).as_deref()
}

fn make_venv() -> Result<PathBuf, String> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bindings_venv");
    let python = folder.join("bin/python");
    let run = |program: &Path, arguments: &[&str]| {
        let output = Command::new(program).args(arguments).stdin(Stdio::null()).output();
        let output = output.map_err(|error| format!("cannot run {}: {error}", program.display()))?;
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        output.status.success().then_some(()).ok_or(format!("{arguments:?}: {said}"))
    };
    if !python.exists() {
        run(Path::new("python3"), &["-m", "venv", &folder.to_string_lossy()])?;
    }
    run(&python, &["-m", "pip", "install", "--quiet", "iceoryx2>=0.10,<0.11", "hatchling"])?;
    let package = concat!(env!("CARGO_MANIFEST_DIR"), "/bindings/python");
    let install = [
        "-m",
        "pip",
        "install",
        "--quiet",
        "--no-build-isolation",
        "--no-deps",
        "--force-reinstall",
        package,
    ];
    // What it needs is there, so that from here on a failure is the package's own.
    run(&python, &install).expect("the package installs");
    Ok(python)
}

/// A program of the package that does not outlive its test.
struct Example(Option<Child>);

impl Drop for Example {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

impl Example {
    /// Waits for its end and returns what it said.
    fn ended(mut self) -> Said {
        let child = self.0.take().expect("an example ends once");
        Said::of(child.wait_with_output().expect("the example ends"))
    }

    /// Asks it to end; it must do so without complaint.
    fn end(self) {
        let child = self.0.as_ref().expect("an example ends once");
        kill_process(Pid::from_child(child), Signal::TERM).expect("the example still runs");
        let said = self.ended();
        assert!(said.code == 0 && !said.err.contains("Traceback"), "{said:?}");
    }
}

/// An example of the package, running in `domain`.
fn example(python: &Path, domain: &Domain, name: &str, arguments: &[&str]) -> Example {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("bindings/python/examples").join(name);
    let child = Command::new(python)
        .arg(file)
        .args(arguments)
        .env(Domain::VARIABLE, domain.prefix())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("python starts");
    Example(Some(child))
}

/// Everything the nominal controllers said, in the order of the recording, and every command of the filter.
fn recorded(recording: &Path) -> (Vec<NominalCommand>, Vec<SafeCommand>) {
    (said_in(recording), said_in(recording))
}

/// Every message of one kind, in the order of the recording.
fn said_in<T: messages::Message>(recording: &Path) -> Vec<T> {
    let stamped = read_wire(recording).expect("a readable recording");
    stamped.into_iter().map(|(_, message)| message).collect()
}

/// Asserts that the robot reached its goal and touched nobody.
fn assert_reached(said: &Said) {
    assert_eq!(said.code, 0, "{} {}", said.out, said.err);
    let verdict = said.json();
    assert_eq!(at(&verdict, "/outcome"), "reached", "{verdict}");
    assert_eq!(count(&verdict, "/collisions"), 0);
}

#[test]
fn a_python_controller_drives_the_demo_to_its_goal() {
    let Some(python) = python() else { return };
    let domain = ScopedDomain::new();
    let folder = scratch("bindings_external");
    let controller = example(python, &domain, "pure_pursuit.py", &[]);
    let reader = example(python, &domain, "watch_filter.py", &["--seconds", "8"]);
    let said = Said::by(
        cncbf(&domain, &folder),
        &[&"run", &"--controller", &"external", &"--people", &"4", &"--report", &"report", &"--json"],
    );
    controller.end();
    assert_reached(&said);
    assert!(!folder.join("report/nominal.log").exists(), "a nominal process of our own ran");
    let (nominal, safe) = recorded(&folder.join("report/run.mcap"));
    assert!(nominal.len() > 100, "only {} commands", nominal.len());
    assert!(nominal.iter().all(|command| command.controller == PYTHON_CONTROLLER));
    assert_eq!(nominal.last().map(|command| command.intent), Some(messages::Intent::Stop.code()));
    let filtered = safe.iter().filter(|command| command.status == SafetyStatus::Filtered.code()).count();
    assert!(filtered * 2 > safe.len(), "only {filtered} of {} commands rest on it", safe.len());
    let read = reader.ended();
    assert!(read.code == 0 && read.out.contains("filtered (none)"), "{read:?}");
}

#[test]
fn a_python_controller_takes_over_while_the_robot_drives() {
    let Some(python) = python() else { return };
    let domain = ScopedDomain::new();
    let folder = scratch("bindings_swap");
    let mut witness = Witness::join(&domain, "cncbf");
    let run = cncbf(&domain, &folder)
        .args(["run", "--people", "4", "--report", "report", "--json"])
        .spawn()
        .expect("the command starts");
    let since_ns = witness.watch_until_it_drives(0);
    // Not earlier: who waits before anybody has the place gets it.
    let controller = example(python, &domain, "pure_pursuit.py", &[]);
    witness.watch_until_a_cycle_after(since_ns + DRIVE_NS);
    let members = members(&domain).expect("a readable domain");
    assert!(members.iter().any(|member| member.name == "cncbf/nominal_python"), "{members:?}");
    let ours = members.iter().find(|member| member.alive && member.name == "cncbf/nominal");
    let ours = ours.unwrap_or_else(|| panic!("no nominal controller among {members:?}"));
    let pid = i32::try_from(ours.pid).ok().and_then(Pid::from_raw).expect("a process id");
    kill_process(pid, Signal::TERM).expect("a running controller");
    drop(witness);
    let said = Said::of(run.wait_with_output().expect("the command ends"));
    controller.end();
    assert_reached(&said);
    let (nominal, safe) = recorded(&folder.join("report/run.mcap"));
    let changed = nominal.iter().position(|command| command.controller == PYTHON_CONTROLLER);
    let changed = changed.expect("nobody took over");
    let (before, after) = nominal.split_at(changed);
    assert!(before.iter().all(|command| command.controller == Controller::Mpc.code()) && before.len() > 20);
    assert!(after.iter().all(|command| command.controller == PYTHON_CONTROLLER) && after.len() > 100);
    let last_ns = before.last().map_or(0, |command| command.stamp.published_ns);
    let first_ns = after[0].stamp.published_ns;
    let gap_ns = first_ns.saturating_sub(last_ns);
    let braked = safe.iter().filter(|command| {
        (last_ns..first_ns).contains(&command.ledger.filter_woke_ns)
            && command.status == SafetyStatus::Braking.code()
    });
    println!(
        "gap {} ms between the two controllers, {} braking commands",
        gap_ns / 1_000_000,
        braked.count()
    );
    assert!((1..LONGEST_GAP_NS).contains(&gap_ns), "{gap_ns} ns");
}
