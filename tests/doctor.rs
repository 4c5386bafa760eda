//! `cncbf doctor` as a whole program: what it says, in either form, with and without rights, beside a running process.

#[path = "stack/command.rs"]
mod command;

use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::CommandExt;
use std::process::Command;

use command::{Said, at, cncbf, count, scratch};
use node_runtime::{Domain, ScopedDomain};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

/// A user without rights.
const NOBODY: u32 = 65534;

/// What the doctor says in `domain`. It must come to a verdict, whichever.
fn doctor(domain: &Domain, arguments: &[&str]) -> Said {
    let mut command = cncbf(domain, &scratch(domain.prefix()));
    let said = Said::of(command.arg("doctor").args(arguments).output().expect("the command starts"));
    assert!(said.code == 0 || said.code == 1, "{said:?}");
    said
}

fn list<'a>(value: &'a Value, pointer: &str) -> &'a [Value] {
    at(value, pointer).as_array().unwrap_or_else(|| panic!("{pointer} is no list in {value}"))
}

#[test]
fn the_json_form_holds_findings_rights_ways_and_verdict() {
    let found = doctor(&ScopedDomain::new(), &["--seconds", "0.5", "--json"]).json();
    assert!(list(&found, "/findings").len() > 15, "{found}");
    for process in ["bridge", "estimator", "nominal", "filter"] {
        let grants = list(&found, &format!("/rights/{process}"));
        assert!(grants.iter().any(|grant| grant["what"] == "fifo"), "{process}: {grants:?}");
        for grant in grants {
            let advice = at(grant, "/advice").as_str().expect("text");
            assert_eq!(grant["granted"] == true, advice.is_empty(), "advice goes with a refusal: {grant}");
        }
    }
    let ways = list(&found, "/wake_up_lateness");
    assert_eq!(ways.len(), 5);
    for way in ways {
        assert!(count(way, "/count") >= 20, "{way}");
        assert!(way["max_us"].as_f64() >= way["p50_us"].as_f64(), "{way}");
    }
    assert!(at(&found, "/verdict/0").as_str().is_some_and(|text| text.starts_with("250 Hz")), "{found}");
    assert!(list(&found, "/running").is_empty(), "{found}");
}

#[test]
fn the_text_form_ends_in_plain_words_about_the_settings_own_rate() {
    let file = scratch("doctor_rate").join("slow.toml");
    let shipped = include_str!("../config/ground_robot.toml");
    let slow = shipped.replacen("period_ms = 4\n", "period_ms = 10\n", 1);
    assert_ne!(slow, shipped, "the shipped period is another one");
    std::fs::write(&file, slow).expect("a writable file");
    let path = file.to_str().expect("a plain path");
    let text = doctor(&ScopedDomain::new(), &["--seconds", "0.1", "--config", path]).out;
    for expected in [
        "This machine",
        "tried out and given back",
        "No running stack named cncbf",
        "over a period",
        "  100 Hz:",
        "PREEMPT_RT",
    ] {
        assert!(text.contains(expected), "no `{expected}` in:\n{text}");
    }
}

#[test]
fn a_time_that_is_none_is_refused() {
    let domain = ScopedDomain::new();
    for seconds in ["0", "-1", "nan", "inf", "soon"] {
        let said =
            Said::by(cncbf(&domain, &scratch("doctor_time")), &[&"doctor", &format!("--seconds={seconds}")]);
        assert_eq!(said.code, 2, "{seconds}: {said:?}");
    }
}

#[test]
fn a_running_process_tells_what_it_asked_and_got() {
    let domain = ScopedDomain::new();
    let filter = cncbf(&domain, &scratch("doctor_filter"))
        .args(["filter", "--instance", "patient"])
        .env("RUST_LOG", "info")
        .spawn()
        .expect("the filter starts");
    let mut found = Value::Null;
    // It may still be opening its ports, or be about to ask.
    for _ in 0..50 {
        found = doctor(&domain, &["--seconds", "0.05", "--json", "--instance", "patient"]).json();
        if found["running"][0]["asked"].as_array().is_some_and(|asked| !asked.is_empty()) {
            break;
        }
    }
    kill_process(Pid::from_child(&filter), Signal::TERM).expect("the filter runs");
    let pid = filter.id();
    let log = Said::of(filter.wait_with_output().expect("the filter ends")).err;
    assert_eq!(log.matches("the kernel granted").count(), 1, "what was granted is logged once: {log}");
    assert_eq!(at(&found, "/running/0/process"), "filter");
    assert_eq!(count(&found, "/running/0/pid"), u64::from(pid));
    let asked = list(&found, "/running/0/asked");
    assert!(asked.iter().any(|right| right == "fifo"), "{found}");
    // What the doctor is granted, the filter is granted.
    let grants = list(&found, "/rights/filter");
    assert_eq!(asked.len(), grants.len(), "{found}");
    let granted = grants.iter().filter(|grant| grant["granted"] == true).count();
    assert_eq!(list(&found, "/running/0/granted").len(), granted, "{found}");
}

#[test]
fn a_user_without_rights_gets_advice_instead_of_an_error() {
    if !rustix::process::geteuid().is_root() {
        println!("skipped: only root can become another user");
        return;
    }
    // A copy, since the build folder may be closed to others.
    let folder = std::env::temp_dir().join(format!("cncbf_doctor_{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a writable folder");
    std::fs::set_permissions(&folder, Permissions::from_mode(0o755)).expect("our own folder");
    let program = folder.join("cncbf");
    std::fs::copy(env!("CARGO_BIN_EXE_cncbf"), &program).expect("room for a copy");
    let domain = ScopedDomain::new();
    let mut command = Command::new(program);
    command.env(Domain::VARIABLE, domain.prefix()).current_dir(&folder).uid(NOBODY).gid(NOBODY);
    let said = Said::by(command, &[&"doctor", &"--seconds", &"0.1"]);
    std::fs::remove_dir_all(&folder).expect("our own folder");
    assert!(said.code == 0 || said.code == 1, "{said:?}");
    for expected in [
        "refused: SCHED_OTHER",
        "LimitRTPRIO=",
        "LimitMEMLOCK=",
        "Measured without what the kernel did not grant",
    ] {
        assert!(said.out.contains(expected), "no `{expected}` in:\n{}", said.out);
    }
}
