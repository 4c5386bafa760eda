//! The launcher with real children: shells that end, hang, fail and log.

#![allow(clippy::unwrap_used)] // helpers of tests may panic as tests do

use std::{ffi::OsString, path::Path, process::Command, time::Duration};

use launcher::{Child, Event, LaunchError, Launcher, Plan, RestartPolicy};
use messages::ProcessId;
use node_runtime::{Clock, Domain, Node, RealClock, Shutdown, leftovers};

const PATIENCE: Duration = Duration::from_secs(20);
const ROLE: &str = "CNCBF_TEST_ROLE";

fn shell(id: ProcessId, script: &str) -> Child {
    Child {
        id,
        program: "/bin/sh".into(),
        args: vec!["-c".into(), script.into()],
        env: vec![],
        restart: quick(2),
    }
}

fn quick(limit: u32) -> RestartPolicy {
    RestartPolicy::OnFailure {
        limit,
        window: Duration::from_secs(60),
        first_pause: Duration::from_millis(1),
        longest_pause: Duration::from_millis(2),
    }
}

/// This test binary as a child, doing what [`member`] or [`inner_launcher`] say.
fn myself(id: ProcessId, role: &str) -> Child {
    let args = ["--exact", role, "--nocapture"].map(OsString::from).to_vec();
    Child {
        id,
        program: std::env::current_exe().unwrap(),
        args,
        env: vec![(ROLE.into(), role.into())],
        restart: quick(2),
    }
}

fn plan(children: Vec<Child>) -> Plan {
    Plan { domain: Domain::isolated(), children, log_dir: None }
}

/// Polls until `enough` is content with all events so far.
fn watch(launcher: &mut Launcher, enough: impl Fn(&[Event]) -> bool) -> Vec<Event> {
    let mut events = Vec::new();
    patiently("an event", || {
        events.extend(launcher.poll());
        enough(&events)
    });
    events
}

fn patiently(what: &str, mut met: impl FnMut() -> bool) {
    let start_ns = RealClock.now_ns();
    while !met() {
        assert!(RealClock.now_ns() - start_ns < PATIENCE.as_nanos() as u64, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn lives(pid: u32) -> bool {
    // A process that has ended but was not reaped by its new parent yet is a zombie.
    std::fs::read_to_string(format!("/proc/{pid}/stat"))
        .is_ok_and(|stat| !stat.rsplit(')').next().unwrap_or_default().starts_with(" Z"))
}

/// Role: joins shared memory until told to stop. Without the role it is a test that passes.
#[test]
fn member() {
    if std::env::var(ROLE).is_ok_and(|role| role == "member") {
        let shutdown = Shutdown::install().unwrap();
        let node = Node::open("demo", ProcessId::Filter).unwrap();
        let _port = node.publisher::<messages::SafeCommand>().unwrap();
        while !shutdown.requested() {
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

/// Role: a launcher with one [`member`], to be killed.
#[test]
fn inner_launcher() {
    if std::env::var(ROLE).is_ok_and(|role| role == "inner_launcher") {
        let domain = Domain::from_env().unwrap();
        let children = vec![myself(ProcessId::Filter, "member")];
        let mut launcher = Launcher::start(Plan { domain, children, log_dir: None }).unwrap();
        loop {
            launcher.poll();
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

#[test]
fn a_child_that_ends_well_is_left_alone() {
    let mut launcher = Launcher::start(plan(vec![shell(ProcessId::Bridge, "exit 0")])).unwrap();
    let events = watch(&mut launcher, |events| !events.is_empty());
    assert_eq!(events, [Event::Finished { id: ProcessId::Bridge }]);
    assert!(!launcher.any_running());
    assert_eq!(launcher.pid(ProcessId::Bridge), None);
}

#[test]
fn a_child_that_keeps_failing_is_given_up() {
    let mut launcher = Launcher::start(plan(vec![shell(ProcessId::Nominal, "exit 3")])).unwrap();
    let events = watch(&mut launcher, |events| matches!(events.last(), Some(Event::GaveUp { .. })));
    let restarts = events.iter().filter(|event| matches!(event, Event::Restarted { .. })).count();
    assert_eq!(restarts, 2, "{events:?}");
    assert!(events.iter().all(|event| event.id() == ProcessId::Nominal));
    assert!(events.last().unwrap().to_string().contains("exit code 3"), "{events:?}");
    assert!(!launcher.any_running());
}

#[test]
fn a_killed_child_runs_again_under_a_new_process_id() {
    let children =
        vec![shell(ProcessId::Filter, "exec sleep 1000"), shell(ProcessId::Bridge, "exec sleep 1000")];
    let mut launcher = Launcher::start(plan(children)).unwrap();
    let (before, bridge) = (launcher.pid(ProcessId::Filter).unwrap(), launcher.pid(ProcessId::Bridge));
    assert!(launcher.poll().is_empty());
    assert!(launcher.kill(ProcessId::Filter));
    assert!(!launcher.kill(ProcessId::Recorder), "not part of the plan");
    watch(&mut launcher, |events| matches!(events.last(), Some(Event::Restarted { .. })));
    let after = launcher.pid(ProcessId::Filter).unwrap();
    assert_ne!(before, after);
    assert_eq!(launcher.pid(ProcessId::Bridge), bridge, "the others go on");
    assert!(lives(after) && !lives(before));
    assert_eq!(launcher.stop(PATIENCE).killed, []);
    assert!(!lives(after));
}

#[test]
fn a_child_deaf_to_sigterm_is_killed_when_time_is_up() {
    let deaf =
        shell(ProcessId::Nominal, "trap '' TERM; echo deaf > \"$READY\"; while :; do sleep 0.01; done");
    let folder = tempfile::tempdir().unwrap();
    let ready = folder.path().join("ready");
    let deaf = Child { env: vec![("READY".into(), ready.clone().into())], ..deaf };
    let launcher = Launcher::start(plan(vec![deaf, shell(ProcessId::Bridge, "exec sleep 1000")])).unwrap();
    patiently("the trap", || ready.exists());
    let pid = launcher.pid(ProcessId::Nominal).unwrap();
    assert_eq!(launcher.stop(Duration::from_millis(50)).killed, [ProcessId::Nominal]);
    assert!(!lives(pid));
}

#[test]
fn dropping_the_launcher_stops_its_children() {
    let launcher = Launcher::start(plan(vec![shell(ProcessId::Bridge, "exec sleep 1000")])).unwrap();
    let pid = launcher.pid(ProcessId::Bridge).unwrap();
    drop(launcher);
    assert!(!lives(pid));
}

#[test]
fn logs_go_to_one_file_per_process() {
    let folder = tempfile::tempdir().unwrap();
    let log_dir = folder.path().join("logs");
    let children = vec![
        shell(ProcessId::Bridge, "echo out; echo err >&2"),
        shell(ProcessId::Filter, "echo \"$CNCBF_IPC_PREFIX\""),
    ];
    let plan = Plan { log_dir: Some(log_dir.clone()), ..plan(children) };
    let prefix = plan.domain.prefix().to_owned();
    let mut launcher = Launcher::start(plan).unwrap();
    watch(&mut launcher, |events| events.len() == 2);
    let text = |name: &str| std::fs::read_to_string(Path::new(&log_dir).join(name)).unwrap();
    assert_eq!(text("bridge.log"), "out\nerr\n");
    assert_eq!(text("filter.log"), format!("{prefix}\n"));
}

#[test]
fn a_plan_that_cannot_start_leaves_nothing_running() {
    let missing = Child { program: "/no/such/program".into(), ..shell(ProcessId::Filter, "") };
    let folder = tempfile::tempdir().unwrap();
    let pid_file = folder.path().join("pid");
    let first = Child {
        env: vec![("PID_FILE".into(), pid_file.clone().into())],
        ..shell(ProcessId::Bridge, "echo $$ > \"$PID_FILE\"; exec sleep 1000")
    };
    let error = Launcher::start(plan(vec![first, missing])).unwrap_err();
    assert!(matches!(error, LaunchError::Spawn { id: ProcessId::Filter, .. }), "{error:?}");
    assert!(error.to_string().contains("/no/such/program"), "{error}");
    if let Ok(pid) = std::fs::read_to_string(&pid_file) {
        assert!(!pid.trim().parse().is_ok_and(lives));
    }
    let twice = vec![shell(ProcessId::Bridge, ""), shell(ProcessId::Bridge, "")];
    assert!(matches!(Launcher::start(plan(twice)), Err(LaunchError::Twice { id: ProcessId::Bridge })));
}

#[test]
fn nothing_is_left_in_shared_memory_even_of_a_killed_member() {
    let plan = plan(vec![myself(ProcessId::Filter, "member")]);
    let domain = plan.domain.clone();
    let mut launcher = Launcher::start(plan).unwrap();
    let joined = |domain: &Domain| {
        node_runtime::members(domain)
            .unwrap()
            .iter()
            .any(|member| member.alive && member.name == "demo/filter")
    };
    patiently("the member", || joined(&domain));
    launcher.kill(ProcessId::Filter);
    watch(&mut launcher, |events| matches!(events.last(), Some(Event::Restarted { .. })));
    patiently("the member's successor", || joined(&domain));
    launcher.kill(ProcessId::Filter);
    let report = launcher.stop(PATIENCE);
    assert!(!report.removed.is_empty());
    assert_eq!(leftovers(&domain).unwrap(), []);
}

#[test]
fn children_die_with_a_killed_launcher() {
    let domain = Domain::isolated();
    let mut inner = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "inner_launcher", "--nocapture"])
        .env(ROLE, "inner_launcher")
        .env(Domain::VARIABLE, domain.prefix())
        .spawn()
        .unwrap();
    let member = |alive: bool| {
        node_runtime::members(&domain).unwrap().into_iter().find(|member| member.alive == alive)
    };
    let mut pid = 0;
    patiently("the member", || member(true).inspect(|member| pid = member.pid).is_some());
    inner.kill().unwrap();
    inner.wait().unwrap();
    patiently("the member's end", || !lives(pid));
    node_runtime::clean_up(&domain).unwrap();
    assert_eq!(leftovers(&domain).unwrap(), []);
}
