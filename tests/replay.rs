//! `cncbf replay` and `why` on recordings: the project's own, damaged copies of it, and foreign ones where they are.

#[path = "stack/command.rs"]
mod command;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use command::{Said, at, cncbf, count, scratch};
use node_runtime::Domain;
use serde_json::Value;

/// The project's own recording; `recordings/README.md` says how it was made.
fn demo() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("recordings/demo_crowd.mcap")
}

/// Replays `file` in lockstep with more `arguments`.
fn lockstep(folder: &Path, file: &Path, arguments: &[&str]) -> Said {
    let mut all: Vec<&dyn AsRef<OsStr>> = vec![&"replay", &file, &"--lockstep", &"--json"];
    all.extend(arguments.iter().map(|argument| argument as &dyn AsRef<OsStr>));
    Said::by(cncbf(&Domain::isolated(), folder), &all)
}

/// The figures of a replay that must succeed.
fn figures(folder: &Path, file: &Path, arguments: &[&str]) -> Value {
    let said = lockstep(folder, file, arguments);
    assert_eq!(said.code, 0, "{}", said.err);
    said.json()
}

/// Messages under all reasons of a JSON object of counts.
fn total(reasons: &Value) -> u64 {
    let reasons = reasons.as_object().unwrap_or_else(|| panic!("{reasons} is no object of counts"));
    reasons.values().map(|value| value.as_u64().expect("a count")).sum()
}

/// Asserts that no message of the file went astray.
fn assert_all_accounted_for(figures: &Value) {
    let sum = count(figures, "/intake/used")
        + count(figures, "/intake/not_needed")
        + total(at(figures, "/intake/unreadable"))
        + total(at(figures, "/intake/refused"));
    assert_eq!(count(figures, "/intake/found"), sum, "{}", at(figures, "/intake"));
}

#[test]
fn lockstep_gives_the_same_bytes_on_every_run() {
    let folder = scratch("replay_lockstep");
    for kernel in [&[][..], &["--kernel", "portable"]] {
        let hash = |repeat: &str| {
            let figures = figures(&folder, &demo(), &[kernel, &["--repeat", repeat]].concat());
            (at(&figures, "/commands_sha256").clone(), at(&figures, "/kernel").clone())
        };
        let (first, used) = hash("1");
        assert!(first.as_str().is_some_and(|hash| hash.len() == 64), "{first}");
        assert!(kernel.is_empty() || used == "portable", "{used} was used instead of the portable kernel");
        // In another process, and twice within that one.
        assert_eq!(hash("2"), (first, used), "kernel {kernel:?}");
    }
}

#[test]
fn the_own_recording_is_used_to_the_last_message() {
    let folder = scratch("replay_own");
    let figures = figures(&folder, &demo(), &[]);
    assert_all_accounted_for(&figures);
    assert_eq!(total(at(&figures, "/intake/unreadable")) + total(at(&figures, "/intake/refused")), 0);
    assert!(count(&figures, "/intake/used") > 500, "{}", at(&figures, "/intake"));
    assert_eq!(count(&figures, "/verdict/collisions"), 0);
    let filtered = at(&figures, "/verdict/time_shares/filtered").as_f64().expect("a share");
    assert!(filtered > 0.5, "the filter was at work in only {filtered} of the time");
    assert!(count(&figures, "/verdict/interventions/count") > 0, "a recording in which nothing happens");
}

#[test]
fn in_a_closed_loop_the_commands_matter() {
    let folder = scratch("replay_closed_loop");
    let open = figures(&folder, &demo(), &["--controller", "hold"]);
    let closed = figures(&folder, &demo(), &["--controller", "hold", "--closed-loop"]);
    assert_all_accounted_for(&closed);
    assert_eq!(count(&open, "/intake/replaced_by_simulation"), 0);
    assert!(count(&closed, "/intake/replaced_by_simulation") > 500);
    // The recorded robot drove; the simulated one obeys a controller that wants to stay where it is.
    let path_m = |figures: &Value| at(figures, "/verdict/path_length_m").as_f64().expect("a length");
    assert!(path_m(&open) > 3.0, "the recorded robot drove {} m", path_m(&open));
    assert!(path_m(&closed) < 0.1, "a robot that shall hold drove {} m", path_m(&closed));
}

#[test]
fn a_moment_is_explained() {
    let folder = scratch("replay_why");
    let ask = |time: &str, json: &[&str]| {
        let mut arguments: Vec<String> = vec!["why".into(), demo().display().to_string(), time.into()];
        arguments.extend(json.iter().map(|&argument| argument.to_owned()));
        let arguments: Vec<&dyn AsRef<OsStr>> =
            arguments.iter().map(|argument| argument as &dyn AsRef<OsStr>).collect();
        Said::by(cncbf(&Domain::isolated(), &folder), &arguments)
    };
    let text = ask("4", &[]);
    assert_eq!(text.code, 0, "{}", text.err);
    for word in ["status", "control", "barrier", "because of", "track"] {
        assert!(text.out.contains(word), "the explanation lacks {word}:\n{}", text.out);
    }
    let json = ask("4", &["--json"]);
    assert_eq!(json.code, 0, "{}", json.err);
    assert!(json.json().is_object());
    let outside = ask("4000", &[]);
    assert_eq!(outside.code, 2);
    assert!(outside.err.contains("4000") && outside.err.trim_end().lines().count() == 1, "{}", outside.err);
}

#[test]
fn a_recording_that_breaks_off_replays_what_it_holds() {
    let folder = scratch("replay_truncated");
    let bytes = std::fs::read(demo()).expect("the own recording");
    let whole_s = at(&figures(&folder, &demo(), &[]), "/verdict/duration_s").as_f64().expect("a duration");
    let mut shares = Vec::new();
    for eighths in 1..8 {
        let cut = folder.join(format!("{eighths}_eighths.mcap"));
        std::fs::write(&cut, &bytes[..bytes.len() * eighths / 8]).expect("a writable file");
        let said = lockstep(&folder, &cut, &[]);
        if said.code == 2 {
            assert_eq!(said.err.trim_end().lines().count(), 1, "{}", said.err);
            shares.push(0.0);
            continue;
        }
        assert_eq!(said.code, 0, "{}", said.err);
        assert_all_accounted_for(&said.json());
        shares.push(at(&said.json(), "/verdict/duration_s").as_f64().expect("a duration") / whole_s);
    }
    // A killed recorder loses what it had not flushed, a second or two; the rest must be there.
    for (index, share) in shares.iter().enumerate() {
        let held = (index + 1) as f64 / 8.0;
        assert!(*share > held - 2.5 / whole_s, "{held} of the file gave {share} of the time: {shares:?}");
    }
    assert!(shares.is_sorted(), "{shares:?}");
}

#[test]
fn a_corrupted_recording_is_counted_or_refused() {
    let folder = scratch("replay_corrupted");
    let bytes = std::fs::read(demo()).expect("the own recording");
    let mut random = 0x9E37_79B9_7F4A_7C15_u64;
    let mut next = |below: usize| {
        // Xorshift: positions that are spread out and the same on every run.
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        (random % below as u64) as usize
    };
    let mut replayed = 0;
    for case in 0..10 {
        let mut damaged = bytes.clone();
        for _ in 0..=case {
            let (at, length) = (next(damaged.len()), 1 << next(10));
            let end = (at + length).min(damaged.len());
            damaged[at..end].iter_mut().for_each(|byte| *byte = next(256) as u8);
        }
        let file = folder.join(format!("{case}.mcap"));
        std::fs::write(&file, damaged).expect("a writable file");
        let said = lockstep(&folder, &file, &["--duration", "1"]);
        match said.code {
            0 => {
                replayed += 1;
                assert_all_accounted_for(&said.json());
            }
            2 => assert_eq!(said.err.trim_end().lines().count(), 1, "case {case}: {}", said.err),
            code => panic!("case {case} ended with exit code {code}: {}", said.err),
        }
    }
    assert!(replayed > 0, "a few bad bytes made every recording useless");
}

#[test]
fn foreign_recordings_lose_no_message() {
    let folder = scratch("replay_foreign");
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/recordings");
    let mut files: Vec<PathBuf> = std::fs::read_dir(shared)
        .map(|entries| entries.flatten().map(|entry| entry.path()).collect())
        .unwrap_or_default();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "mcap"));
    if files.is_empty() {
        println!("skipped: foreign_recordings_lose_no_message needs ../shared/recordings");
        return;
    }
    for file in files {
        // The whole file is read and decoded before its first seconds are played.
        let figures = figures(&folder, &file, &["--duration", "5"]);
        assert_all_accounted_for(&figures);
        assert!(count(&figures, "/intake/used") > 0, "{}", file.display());
        assert!(count(&figures, "/verdict/latency/cycles") >= 1250, "{}", file.display());
        println!("{}: {}", file.file_name().unwrap_or_default().display(), at(&figures, "/intake"));
    }
}
