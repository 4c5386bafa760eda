//! `cncbf profile` on the project's own recording, through the four processes: what it counts, writes and refuses. No time is
//! asserted, only that every cycle and every frame is accounted for.

#[path = "stack/command.rs"]
mod command;

use std::ffi::OsStr;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use bytemuck::Zeroable;
use command::{Said, at, cncbf, count, scratch};
use latency::ProfileFigures;
use messages::{Cycle, Detections, ProcessId, RobotState, SafeCommand};
use node_runtime::{Clock, RealClock, ScopedDomain, members};
use recording::{Recorder, RecordingInfo, read_wire};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

/// Longest wait for anything, ns. Generous: it only has to end a test that has failed.
const PATIENCE_NS: u64 = 60_000_000_000;

/// The project's own recording: eight seconds of a simulated crowd.
fn demo() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("recordings/demo_crowd.mcap")
}

/// Profiles `file` in a domain of its own; everything is written to `folder/report`.
fn profile(folder: &Path, file: &Path, arguments: &[&str]) -> Said {
    let domain = ScopedDomain::new();
    let report = folder.join("report");
    let mut all: Vec<&dyn AsRef<OsStr>> = vec![&"profile", &file, &"--report", &report];
    all.extend(arguments.iter().map(|argument| argument as &dyn AsRef<OsStr>));
    Said::by(cncbf(&domain, folder), &all)
}

/// Asserts that every cycle the filter ever ran is either recorded or counted as lost, and that the record has the last one.
fn assert_counts_are_conserved(profile: &Value) {
    for (repeat, note) in at(profile, "/repeats")
        .as_array()
        .expect("repeats")
        .iter()
        .zip(at(profile, "/notes").as_array().expect("notes"))
    {
        let file = Path::new(at(note, "/recording").as_str().expect("a file"));
        let commands = read_wire::<SafeCommand>(file).expect("a readable record");
        let last = commands.last().expect("commands").1.sequence;
        assert_eq!(commands[0].1.sequence, 1, "the record lacks what came first");
        let counted =
            |key: &str| count(repeat, &format!("/{key}")) + count(repeat, &format!("/start_up/{key}"));
        assert_eq!(counted("cycles"), commands.len() as u64, "cycles in the figures and in the record");
        assert_eq!(
            counted("cycles") + counted("lost_commands"),
            last,
            "cycles recorded and lost, and the last sequence"
        );
        assert_eq!(at(note, "/ends_unknown"), &Value::Array(Vec::new()), "the record lacks what came last");
        assert_eq!(count(note, "/crashes"), 0);

        let cycles = read_wire::<Cycle>(file).expect("a readable record");
        for process in [ProcessId::Bridge, ProcessId::Estimator, ProcessId::Nominal, ProcessId::Filter] {
            let own = cycles.iter().filter(|(_, cycle)| cycle.process == process.code());
            assert!(own.count() > 0, "no cycle of {process} is on record");
        }
    }
}

fn trace_is_valid(file: &Path) {
    let text = std::fs::read_to_string(file).expect("the trace");
    let trace: Value = serde_json::from_str(&text).expect("JSON");
    let events = at(&trace, "/traceEvents").as_array().expect("events");
    assert!(events.len() > 100, "only {} events", events.len());
    for event in events {
        let kind = at(event, "/ph").as_str().expect("a kind");
        assert!(at(event, "/pid").is_u64() && at(event, "/name").is_string(), "{event}");
        assert!(kind == "M" || at(event, "/ts").as_f64().is_some_and(|ts| ts >= 0.0), "{event}");
        assert!(kind != "X" || at(event, "/dur").as_f64().is_some_and(|length| length >= 0.0), "{event}");
    }
}

#[test]
fn a_profile_accounts_for_every_cycle_and_serves_as_a_baseline() {
    let folder = scratch("profile_baseline");
    let trace = folder.join("trace.json");
    let trace_text = trace.display().to_string();
    let first =
        profile(&folder, &demo(), &["--repeat", "2", "--duration", "1.5", "--json", "--trace", &trace_text]);
    assert_eq!(first.code, 0, "{}", first.err);
    let figures = first.json();
    assert_eq!(at(&figures, "/repeats").as_array().map(Vec::len), Some(2));
    assert_counts_are_conserved(&figures);
    assert!(count(&figures, "/pooled/cycles") > 100, "{}", at(&figures, "/pooled/cycles"));
    for note in at(&figures, "/notes").as_array().expect("notes") {
        assert!(
            count(note, "/frames_used") > 0
                && count(note, "/frames_used") <= count(note, "/frames_published")
        );
    }
    trace_is_valid(&trace);

    let written = folder.join("report/profile.json");
    let file = std::fs::File::open(&written).expect("profile.json");
    let read = ProfileFigures::read(file).expect("a profile that can be a baseline");
    assert_eq!(read.repeats.len(), 2);
    assert!(read.resident_bytes().is_some_and(|bytes| bytes > 1_000_000), "{:?}", read.resident_bytes());
    let hlog = std::fs::read_to_string(folder.join("report/profile.hlog")).expect("profile.hlog");
    for tag in ["end_to_end", "filter_compute", "filter_loop_lateness"] {
        assert!(hlog.contains(&format!("Tag={tag}")), "{tag} is not in the log of histograms");
    }
    let page = std::fs::read_to_string(folder.join("report/profile.html")).expect("profile.html");
    assert!(page.contains("<svg") && page.contains("end to end"), "the page shows nothing");

    // The same figures as their own baseline, and then limits that cannot be kept, each in a run of its own.
    let again = folder.join("again");
    std::fs::create_dir_all(&again).expect("a folder");
    let baseline = written.display().to_string();
    let options = ["--repeat", "1", "--duration", "1.5", "--json", "--baseline", &baseline];
    let kept = profile(&again, &demo(), &[&options[..], &["--budget", "end_to_end.p50<=60s"]].concat());
    assert_eq!(kept.code, 0, "{}", kept.err);
    let compared = kept.json();
    assert!(at(&compared, "/comparison/quantities").as_array().is_some_and(|changes| !changes.is_empty()));
    assert_eq!(at(&compared, "/comparison/differences"), &Value::Array(Vec::new()));
    assert_eq!(at(&compared, "/budgets/0/outcome"), "kept");

    // Another machine: refused at once, marked if asked; and a budget that no machine keeps.
    let text = std::fs::read_to_string(&written).expect("profile.json");
    let mut other: Value = serde_json::from_str(&text).expect("JSON");
    other["conditions"]["machine"]["cpu_model"] = "abacus".into();
    let foreign = folder.join("foreign.json");
    std::fs::write(&foreign, other.to_string()).expect("a writable file");
    let foreign = foreign.display().to_string();
    let options = ["--repeat", "1", "--duration", "1.5", "--baseline", &foreign];
    let refused = profile(&again, &demo(), &options);
    assert_eq!(refused.code, 2, "{}", refused.err);
    assert!(refused.err.contains("abacus") && refused.err.contains("--across"), "{}", refused.err);
    let across = ["--across", "--budget", "end_to_end.p50<=1ns"];
    let marked = profile(&again, &demo(), &[&options[..], &across].concat());
    assert_eq!(marked.code, 1, "{}", marked.err);
    assert!(marked.out.contains("abacus") && marked.out.contains("BROKEN"), "{}", marked.out);
}

#[test]
fn at_another_rate_beside_other_work_the_bridge_plays_every_frame() {
    let folder = scratch("profile_rate");
    let options =
        ["--rate", "4", "--repeat", "1", "--load", "io", "--trigger", "both", "--wait", "listener", "--json"];
    let said = profile(&folder, &demo(), &options);
    assert_eq!(said.code, 0, "{}", said.err);
    let figures = said.json();
    assert_counts_are_conserved(&figures);
    let note = at(&figures, "/notes/0");
    assert_eq!(count(note, "/frames_published"), count(&figures, "/conditions/recording/detections"));
    assert!(count(note, "/load/iterations") > 0 && at(note, "/load/kind") == "io", "{note}");
    for (key, expected) in [("load", "io"), ("trigger", "both"), ("wait", "listener")] {
        assert_eq!(at(&figures, &format!("/conditions/{key}")), expected);
    }
    assert!(said.err.contains("other speeds"), "nothing was said about the rate: {}", said.err);
}

#[test]
fn another_transport_carries_the_same_stack() {
    let folder = scratch("profile_dds");
    let options = ["--transport", "dds", "--instance", "profile_over_dds", "--repeat", "1", "--json"];
    let said = profile(&folder, &demo(), &options);
    assert_eq!(said.code, 0, "{}", said.err);
    let figures = said.json();
    assert_eq!(at(&figures, "/conditions/transport"), "dds");
    assert!(count(&figures, "/notes/0/frames_used") > 0, "{}", at(&figures, "/notes"));
}

#[test]
fn a_run_without_the_load_that_was_asked_for_is_no_measurement() {
    let folder = scratch("profile_no_load");
    // A real-time policy, which the load generator inherits and refuses.
    let domain = ScopedDomain::new();
    let mut command = Command::new("chrt");
    command
        .args(["--rr", "1", env!("CARGO_BIN_EXE_cncbf")])
        .current_dir(&folder)
        .env(node_runtime::Domain::VARIABLE, domain.prefix());
    if !Command::new("chrt").args(["--rr", "1", "true"]).output().is_ok_and(|output| output.status.success())
    {
        println!("skipped: a real-time policy cannot be had here");
        return;
    }
    let said =
        Said::by(command, &[&"profile", &demo(), &"--load", &"cpu", &"--report", &folder.join("report")]);
    assert_eq!(said.code, 2, "{}", said.err);
    assert!(said.err.contains("freeze the machine") && said.err.contains("ended"), "{}", said.err);
}

/// A recording that drives and, with `frames`, perceives that nobody is there.
fn empty_world(file: &Path, frames: bool) {
    let info =
        RecordingInfo { odom_frame: "odom".into(), base_frame: "base".into(), ..RecordingInfo::default() };
    let mut recorder = Recorder::create(file, info).expect("a writable file");
    for step in 1..=20_u64 {
        let at_ns = 1_000_000_000 + step * 50_000_000;
        let mut state = RobotState::zeroed();
        (state.stamp.published_ns, state.stamp.valid_at_ns) = (at_ns, at_ns);
        assert!(recorder.record(at_ns, state));
        if frames {
            let mut nobody = Detections::zeroed();
            (nobody.stamp.published_ns, nobody.stamp.valid_at_ns) = (at_ns, at_ns);
            assert!(recorder.record(at_ns, nobody));
        }
    }
    recorder.finish().expect("a complete file");
}

#[test]
fn what_cannot_be_profiled_is_refused_before_anything_runs() {
    let folder = scratch("profile_refused");
    let (no_detections, nobody) = (folder.join("no_detections.mcap"), folder.join("nobody.mcap"));
    empty_world(&no_detections, false);
    empty_world(&nobody, true);
    let garbage = folder.join("garbage.json");
    std::fs::write(&garbage, "{\"format\": \"cncbf-profile/0\"}").expect("a writable file");
    let garbage = garbage.display().to_string();
    let nowhere = folder.join("nowhere.mcap");
    let cases: [(&Path, &[&str], &str); 14] = [
        (&no_detections, &[], "detections"),
        (&nobody, &[], "holds anybody"),
        (&nowhere, &[], "nowhere.mcap"),
        (&demo(), &["--rate", "0"], "is no rate"),
        (&demo(), &["--rate", "-2"], "is no rate"),
        (&demo(), &["--duration", "0"], "is no time"),
        (&demo(), &["--budget", "end_to_end.p99<=+5%"], "--baseline"),
        (&demo(), &["--baseline", &garbage], "measure the baseline anew"),
        (&demo(), &["--budget", "end_to_end.p99"], "is no budget"),
        (&demo(), &["--across"], "--baseline"),
        (&demo(), &["--repeat", "0"], "--repeat"),
        (&demo(), &["--duration", "-1"], "is no time"),
        (&demo(), &["--trace", "/nowhere/trace.json"], "with --trace"),
        (&demo(), &["--instance", "two words"], "cannot name an instance"),
    ];
    for (file, arguments, hint) in cases {
        let said = profile(&folder, file, arguments);
        assert_eq!(said.code, 2, "{arguments:?}: {}", said.err);
        assert!(said.err.contains(hint), "{arguments:?}: {}", said.err);
        assert!(said.out.is_empty(), "{arguments:?}: {}", said.out);
        assert!(!folder.join("report").exists(), "{arguments:?} began to run");
    }
}

#[test]
fn a_duration_that_ends_before_the_first_detections_is_told_so() {
    let folder = scratch("profile_too_short");
    let file = folder.join("late_detections.mcap");
    let info =
        RecordingInfo { odom_frame: "odom".into(), base_frame: "base".into(), ..RecordingInfo::default() };
    let mut recorder = Recorder::create(&file, info).expect("a writable file");
    for step in 1..=600_u64 {
        let at_ns = 1_000_000_000 + step * 50_000_000;
        let mut state = RobotState::zeroed();
        (state.stamp.published_ns, state.stamp.valid_at_ns) = (at_ns, at_ns);
        assert!(recorder.record(at_ns, state));
        if step > 590 {
            let mut somebody = Detections::zeroed();
            (somebody.stamp.published_ns, somebody.stamp.valid_at_ns) = (at_ns, at_ns);
            somebody.count = 1;
            somebody.items[0].radius_m = 0.3;
            assert!(recorder.record(at_ns, somebody));
        }
    }
    recorder.finish().expect("a complete file");
    let said = profile(&folder, &file, &["--duration", "0.5", "--repeat", "1"]);
    assert_eq!(said.code, 2, "{}", said.err);
    assert!(
        said.err.contains("no detections were played") && said.err.contains("--duration"),
        "{}",
        said.err
    );
}

#[test]
fn an_interrupted_profile_keeps_what_it_has_measured() {
    let folder = scratch("profile_interrupted");
    let (domain, report) = (ScopedDomain::new(), folder.join("report"));
    let child = cncbf(&domain, &folder)
        .args([OsStr::new("profile"), demo().as_os_str(), OsStr::new("--report"), report.as_os_str()])
        .args(["--repeat", "3", "--duration", "1", "--json"])
        .spawn()
        .expect("the command starts");
    wait_until("the second repeat begins", &|| report.join("repeat_2/run.mcap").exists());
    kill_process(Pid::from_child(&child), Signal::INT).expect("it runs");
    let said = Said::of(child.wait_with_output().expect("it ends"));
    assert_eq!(said.code, 1, "{}", said.err);
    assert!(said.err.contains("repeat 2: interrupted"), "{}", said.err);
    let repeats = at(&said.json(), "/repeats").as_array().map_or(0, Vec::len);
    assert!((1..=2).contains(&repeats), "{repeats} repeats");
    assert!(report.join("profile.html").exists());
}

#[test]
fn a_second_stack_of_the_same_name_is_refused() {
    let folder = scratch("profile_second");
    let domain = ScopedDomain::new();
    let mut filter = cncbf(&domain, &folder).arg("filter").spawn().expect("the filter starts");
    wait_until("the filter joins", &|| {
        members(&domain).is_ok_and(|members| members.iter().any(|member| member.name == "cncbf/filter"))
    });
    let said = Said::by(cncbf(&domain, &folder), &[&"profile", &demo(), &"--duration", &"1"]);
    kill_process(Pid::from_child(&filter), Signal::TERM).expect("the filter runs");
    filter.wait().expect("the filter ends");
    assert_eq!(said.code, 2, "{}", said.err);
    assert!(said.err.contains("cncbf/filter is already running"), "{}", said.err);
    assert!(said.err.contains("--instance"), "{}", said.err);
}

fn wait_until(what: &str, met: &dyn Fn() -> bool) {
    let give_up_ns = RealClock.now_ns() + PATIENCE_NS;
    while !met() {
        assert!(RealClock.now_ns() < give_up_ns, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn load_ends_with_whoever_started_it_even_if_that_is_killed() {
    let folder = scratch("profile_load");
    // A shell in the place of `cncbf profile`: it starts load and is then killed.
    let mut parent = Command::new("sh")
        .args([
            "-c",
            "CNCBF_PARENT_PID=$$ \"$0\" load-generator cpu & echo $!; wait",
            env!("CARGO_BIN_EXE_cncbf"),
        ])
        .current_dir(&folder)
        .stdout(Stdio::piped())
        .spawn()
        .expect("a shell");
    let mut line = String::new();
    BufReader::new(parent.stdout.take().expect("a pipe")).read_line(&mut line).expect("a line");
    let pid: i32 = line.trim().parse().expect("a process id");
    let runs = || {
        let stat = procfs::process::Process::new(pid).and_then(|process| process.stat());
        stat.is_ok_and(|stat| stat.state != 'Z')
    };
    wait_until("the load begins", &|| {
        let process = procfs::process::Process::new(pid).and_then(|process| process.stat());
        process.is_ok_and(|stat| stat.utime > 0)
    });
    assert!(runs());
    parent.kill().expect("a shell that runs");
    parent.wait().expect("a shell that was killed");
    wait_until("the load ends", &|| !runs());
}
