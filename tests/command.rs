//! The command as a stranger meets it: help, and one clear line with exit code 2 for whatever cannot be used.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn cncbf(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cncbf")).args(arguments).output().expect("the command starts")
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A scratch folder of this test.
fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("a writable folder");
    folder
}

/// Asserts that the command refuses its arguments in one line that says what is wrong.
fn assert_refused(arguments: &[&str], expected: &str) {
    let output = cncbf(arguments);
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
    assert!(text.contains(expected), "{arguments:?} said: {text}");
    assert!(!text.contains("panicked"), "{arguments:?} panicked: {text}");
    assert_eq!(text.trim_end().lines().count(), 1, "{arguments:?} said more than one line: {text}");
}

#[test]
fn help_shows_every_subcommand_and_examples() {
    let text = String::from_utf8(cncbf(&["--help"]).stdout).expect("text");
    for word in [
        "run",
        "replay",
        "why",
        "solve",
        "train",
        "verify",
        "inspect",
        "doctor",
        "record",
        "Examples:",
        "Exit code",
    ] {
        assert!(text.contains(word), "help lacks {word}:\n{text}");
    }
    for subcommand in ["run", "replay", "why", "solve", "train", "verify", "inspect"] {
        let text = String::from_utf8(cncbf(&[subcommand, "--help"]).stdout).expect("text");
        assert!(text.contains("Example"), "{subcommand} --help has no example:\n{text}");
    }
}

#[test]
fn settings_that_cannot_be_used_are_named() {
    let folder = scratch("settings");
    let good = include_str!("../config/ground_robot.toml");
    let write = |name: &str, text: &str| {
        let file = folder.join(name);
        std::fs::write(&file, text).expect("a writable file");
        file.to_str().expect("a plain path").to_owned()
    };
    assert_refused(&["filter", "--config", "nowhere.toml"], "nowhere.toml");
    let negative = write("negative.toml", &good.replacen("radius_m = 0.35", "radius_m = -0.35", 1));
    assert_refused(&["filter", "--config", &negative], "robot.radius_m");
    let output = cncbf(&[
        "filter",
        "--config",
        &write("unknown.toml", &good.replace("[robot]", "[robot]\ncolour = 1")),
    ]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("colour"), "{}", stderr(&output));
}

#[test]
fn a_model_that_does_not_fit_is_refused() {
    let folder = scratch("models");
    let good = include_str!("../config/ground_robot.toml");
    let settings = |name: &str, from: &str, to: &str| {
        let text = good.replacen(from, to, 1);
        assert_ne!(text, good, "{from} is not in the settings");
        let file = folder.join(name);
        std::fs::write(&file, text).expect("a writable file");
        file.to_str().expect("a plain path").to_owned()
    };
    let bounds = settings("bounds.toml", "control_max = [1.0, 0.8]", "control_max = [0.9, 0.8]");
    assert_refused(&["filter", "--config", &bounds], "control box");
    let radius = settings("radius.toml", "radius_m = 0.35", "radius_m = 0.45");
    assert_refused(&["filter", "--config", &radius], "radius");
    let missing = settings("missing.toml", "embedded:ground_robot", "no_such_model.safetensors");
    assert_refused(&["filter", "--config", &missing], "no_such_model.safetensors");
    let unknown = settings("unknown.toml", "embedded:ground_robot", "embedded:hovercraft");
    assert_refused(&["filter", "--config", &unknown], "hovercraft");

    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/ground_robot.safetensors");
    let bytes = std::fs::read(shipped).expect("the shipped model");
    std::fs::write(folder.join("cut.safetensors"), &bytes[..bytes.len() / 2]).expect("a writable file");
    let cut = settings("cut.toml", "embedded:ground_robot", "cut.safetensors");
    assert_refused(&["filter", "--config", &cut], "cut.safetensors");
    let mut altered = bytes;
    let last = altered.len() - 3;
    altered[last] ^= 1;
    std::fs::write(folder.join("altered.safetensors"), altered).expect("a writable file");
    let altered = settings("altered.toml", "embedded:ground_robot", "altered.safetensors");
    assert_refused(&["filter", "--config", &altered], "the file was altered");
}

#[test]
fn recordings_that_cannot_be_used_are_named() {
    let folder = scratch("recordings");
    let file = |name: &str, bytes: &[u8]| {
        let file = folder.join(name);
        std::fs::write(&file, bytes).expect("a writable file");
        file.to_str().expect("a plain path").to_owned()
    };
    assert_refused(&["replay", "nowhere.mcap", "--lockstep"], "nowhere.mcap");
    assert_refused(&["replay", &file("empty.mcap", b""), "--lockstep"], "empty.mcap");
    assert_refused(
        &["replay", &file("text.mcap", b"this is no recording, but long enough to be read"), "--lockstep"],
        "text.mcap",
    );
    assert_refused(&["why", "nowhere.mcap", "1.0"], "nowhere.mcap");
}

#[test]
fn arguments_out_of_range_are_refused_by_the_parser() {
    for arguments in [
        &["replay", "x.mcap", "--rate", "-1"][..],
        &["replay", "x.mcap", "--repeat", "0"],
        &["run", "--source", "carrier-pigeon"],
        &["fly"],
    ] {
        assert_eq!(cncbf(arguments).status.code(), Some(2), "{arguments:?}");
    }
}
