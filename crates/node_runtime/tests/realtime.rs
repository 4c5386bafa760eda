//! Rights are asked of the real kernel, with and without privileges, and read back by other means than the crate's own.
//!
//! Locked memory belongs to a whole process, so that each case runs in one of its own: this test binary again, with a role.

#![allow(clippy::unwrap_used)] // helpers of tests may panic as tests do

use std::{
    fmt::Write as _,
    fs::Permissions,
    os::unix::{fs::PermissionsExt, process::CommandExt},
    path::Path,
    process::{Command, Output},
    time::Duration,
};

use bytemuck::Zeroable;
use messages::{Detections, ProcessId, RealtimeFlags};
use node_runtime::{
    Domain, Node, Pacer, ScopedDomain, UsageMeter, Waiting,
    realtime::{Granted, Request, Right, Scheduler, enter, try_out},
};
use rustix::thread::{CapabilitySet, capabilities};

const ROLE: &str = "CNCBF_TEST_ROLE";
/// A user without rights.
const NOBODY: u32 = 65534;

fn everything() -> Request {
    Request {
        scheduler: Scheduler::Fifo { priority: 7 },
        processors: vec![0],
        lock_memory: true,
        timer_slack_ns: Some(1),
        cpu_dma_latency_us: Some(0),
    }
}

/// Field `number` of `/proc/.../stat`, counted as in proc(5).
fn stat_field(path: &str, number: usize) -> i64 {
    let text = std::fs::read_to_string(path).unwrap();
    // The name before may hold blanks; the third field follows its bracket.
    text.rsplit_once(')').unwrap().1.split_whitespace().nth(number - 3).unwrap().parse().unwrap()
}

/// Class (1 is SCHED_FIFO, 0 the default) and real-time priority of the calling thread.
fn class_and_priority() -> (i64, i64) {
    (stat_field("/proc/thread-self/stat", 41), stat_field("/proc/thread-self/stat", 40))
}

fn status_line(key: &str) -> String {
    let text = std::fs::read_to_string("/proc/thread-self/status").unwrap();
    text.lines().find_map(|line| line.strip_prefix(key)).unwrap().trim().to_owned()
}

/// What the kernel answered, one line each, for the test that started this process to read.
fn tell(granted: &Granted) {
    let mut text = String::new();
    for grant in granted.grants() {
        writeln!(text, "GRANT {}|{}|{}|{}", grant.what.label(), grant.granted, grant.got, grant.advice)
            .unwrap();
    }
    // The harness has begun a line.
    println!("\n{text}");
}

/// The other process. Without a role it is a test that passes.
#[test]
fn other_process() {
    let Ok(role) = std::env::var(ROLE) else { return };
    match role.as_str() {
        "everything" => {
            let helper = std::thread::spawn(|| {
                std::thread::park();
                class_and_priority()
            });
            let granted = enter(&everything());
            tell(&granted);
            assert_eq!(class_and_priority(), (1, 7), "this thread is FIFO");
            assert_eq!(status_line("Cpus_allowed_list:"), "0");
            assert_ne!(status_line("VmLck:"), "0 kB");
            helper.thread().unpark();
            assert_eq!(helper.join().unwrap(), (0, 0), "an older thread keeps its class");
            assert_eq!(
                std::thread::spawn(class_and_priority).join().unwrap(),
                (0, 0),
                "a new thread does not inherit it"
            );
            let child = Command::new("cat").arg("/proc/self/stat").output().unwrap();
            let text = String::from_utf8(child.stdout).unwrap();
            assert_eq!(
                text.rsplit_once(')').unwrap().1.split_whitespace().nth(41 - 3),
                Some("0"),
                "nor a child"
            );
        }
        "shared memory" => {
            let node = Node::open_in(&Domain::from_env().unwrap(), "demo", ProcessId::Bridge).unwrap();
            let port = node.publisher::<Detections>().unwrap();
            let mut reader = node.subscriber_all::<Detections>().unwrap();
            let message = Detections::zeroed();
            let granted = enter(&Request { lock_memory: true, ..Request::nothing() });
            tell(&granted);
            // The first sending makes the connection.
            port.send(&message).unwrap();
            reader.newest().unwrap();
            let mut usage = UsageMeter::new();
            // Queues that fill up walk through all the memory they have.
            for _ in 0..3 {
                for _ in 0..200 {
                    port.send(&message).unwrap();
                }
                assert!(reader.drain(|_| {}) > 30);
            }
            assert_eq!(usage.since_last().minor_faults, 0, "shared memory was there before the loop");
        }
        "nobody" => {
            let granted = enter(&everything());
            tell(&granted);
            assert_eq!(class_and_priority(), (0, 0));
            let mut timer = Pacer::every(Duration::from_millis(2), Waiting::ASLEEP);
            for _ in 0..5 {
                timer.wait();
            }
            println!("still runs");
        }
        "trial" => {
            let grants = try_out(&everything(), <[_]>::to_vec).unwrap();
            assert_eq!(grants.len(), Right::ALL.len());
            assert!(grants.iter().all(|grant| grant.granted), "{grants:?}");
            assert_eq!(class_and_priority(), (0, 0), "the caller keeps its class");
            assert_eq!(status_line("VmLck:"), "0 kB", "the lock was taken off again");
        }
        other => panic!("no such role: {other}"),
    }
}

fn run(role: &str, program: &Path, domain: &Domain, prepare: impl Fn(&mut Command)) -> Output {
    let mut command = Command::new(program);
    command.args(["--exact", "other_process", "--nocapture", "--test-threads", "1"]);
    command.env(ROLE, role).env(Domain::VARIABLE, domain.prefix());
    prepare(&mut command);
    command.output().unwrap()
}

fn assert_success(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    text
}

/// Whether this test run may do what a robot's service may. Says so where it may not.
fn privileged() -> bool {
    let wanted = CapabilitySet::SYS_NICE | CapabilitySet::IPC_LOCK | CapabilitySet::SETUID;
    let privileged = capabilities(None).unwrap().effective.contains(wanted)
        && std::fs::File::options().write(true).open("/dev/cpu_dma_latency").is_ok();
    if !privileged {
        println!("skipped: needs CAP_SYS_NICE, CAP_IPC_LOCK, CAP_SETUID and /dev/cpu_dma_latency");
    }
    privileged
}

fn this_program() -> std::path::PathBuf {
    std::env::current_exe().unwrap()
}

#[test]
fn everything_is_granted_to_the_control_thread_alone() {
    if !privileged() {
        return;
    }
    let domain = ScopedDomain::new();
    let text = assert_success(&run("everything", &this_program(), &domain, |_| {}));
    let grants: Vec<_> = text.lines().filter(|line| line.starts_with("GRANT")).collect();
    assert_eq!(grants.len(), Right::ALL.len(), "{text}");
    assert!(grants.iter().all(|line| line.contains("|true|")), "{text}");
    assert!(text.contains("SCHED_FIFO 7, not inherited"), "{text}");
}

#[test]
fn shared_memory_is_touched_and_locked_with_the_rest() {
    if !privileged() {
        return;
    }
    let domain = ScopedDomain::new();
    assert_success(&run("shared memory", &this_program(), &domain, |_| {}));
}

#[test]
fn a_trial_gives_everything_back() {
    if !privileged() {
        return;
    }
    let domain = ScopedDomain::new();
    assert_success(&run("trial", &this_program(), &domain, |_| {}));
}

#[test]
fn a_user_without_rights_runs_without_and_is_told_what_to_do() {
    if !privileged() {
        return;
    }
    // A copy, since the build folder may be closed to others.
    let folder = std::env::temp_dir().join(format!("cncbf_realtime_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::set_permissions(&folder, Permissions::from_mode(0o755)).unwrap();
    let program = folder.join("test");
    std::fs::copy(this_program(), &program).unwrap();
    let domain = ScopedDomain::new();
    let output = run("nobody", &program, &domain, |command| {
        command.uid(NOBODY).gid(NOBODY).current_dir(&folder);
    });
    std::fs::remove_dir_all(&folder).unwrap();
    let text = assert_success(&output);
    assert!(text.contains("still runs"), "{text}");
    for what in [Right::Fifo, Right::MemoryLock, Right::CpuDmaLatency] {
        let line = text.lines().find(|line| line.starts_with(&format!("GRANT {}|", what.label()))).unwrap();
        let fields: Vec<_> = line.split('|').collect();
        assert_eq!(fields[1], "false", "{line}");
        assert!(!fields[2].is_empty() && fields[3].len() > 20, "{line}");
    }
    for what in [Right::Processors, Right::Prefault, Right::TimerSlack] {
        assert!(
            text.contains(&format!("GRANT {}|true|", what.label())),
            "nobody needs rights for {what:?}: {text}"
        );
    }
}

#[test]
fn what_the_machine_does_not_have_is_refused_and_said() {
    let granted =
        std::thread::spawn(|| enter(&Request { processors: vec![0, 100_000], ..Request::nothing() }));
    let granted = granted.join().unwrap();
    assert_eq!(granted.flags(), (RealtimeFlags::PROCESSORS, 0));
    assert!(!granted.grants()[0].advice.is_empty());
    assert_eq!(enter(&Request::nothing()).flags(), (0, 0));
}
