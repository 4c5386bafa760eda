//! The offline half as a stranger meets it: settings in, a verified model and a picture out, and clear refusals on the way.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn cncbf(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cncbf"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the command starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// An empty scratch folder of this test.
fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a writable folder");
    folder
}

/// A small game: the shipped static obstacles on a coarse grid, few samples, few epochs.
fn small_settings() -> String {
    let shipped = include_str!("../config/static_obstacles.toml");
    let small = shipped
        .replace("count = [241, 241, 4, 4]", "count = [61, 61, 4, 4]")
        .replace("epochs = 60", "epochs = 6\nsamples = { count = 65536 }");
    assert_ne!(small, shipped);
    small
}

fn succeed(folder: &Path, arguments: &[&str]) -> Output {
    let output = cncbf(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
    output
}

#[test]
fn settings_become_a_verified_model_and_a_picture() {
    let folder = scratch("small_game");
    std::fs::write(folder.join("small.toml"), small_settings()).expect("a writable folder");
    succeed(&folder, &["train", "small.toml", "-o", "small.safetensors", "--no-verify"]);
    let game = "static_obstacles.value.true.safetensors";
    for file in ["static_obstacles.value.safetensors", game] {
        assert!(folder.join(file).exists(), "{file} is kept for next time");
    }
    let left: Vec<_> = std::fs::read_dir(&folder).expect("a folder").filter_map(Result::ok).collect();
    assert!(left.iter().all(|file| !file.path().to_string_lossy().contains("checkpoint")));

    let verify = ["verify", "small.safetensors", "--value", game, "--rollouts", "256", "--horizon", "1"];
    let prove = ["--prove", "0.9:1.1,0.6:0.8,-0.1:0.1,-0.1:0.1", "--epsilon", "5", "--minutes", "1"];
    let output = succeed(&folder, &[&verify[..], &prove[..]].concat());
    let report = text(&output.stdout);
    for part in ["(a) structure: holds", "(b) error", "(c)", "(d)", "(e)"] {
        assert!(report.contains(part), "the report lacks {part}:\n{report}");
    }
    let shown = succeed(&folder, &["inspect", "small.safetensors", "--json"]);
    let metadata: serde_json::Value = serde_json::from_slice(&shown.stdout).expect("JSON");
    for part in ["structural", "value_error", "condition", "scenario", "affine"] {
        assert!(metadata["verification"][part].is_object(), "{part} is not in the file");
    }
    assert_eq!(metadata["verification"]["scenario"]["settings"]["rollouts"], 256);

    succeed(&folder, &["inspect", "small.safetensors", "--plot", "small.svg", "--value", game]);
    let picture = std::fs::read_to_string(folder.join("small.svg")).expect("the picture");
    assert!(picture.starts_with("<svg") && picture.contains("obstacle at rest"));
}

#[test]
fn a_solve_goes_on_only_with_its_own_settings() {
    let folder = scratch("changed_game");
    std::fs::write(folder.join("small.toml"), small_settings()).expect("a writable folder");
    succeed(&folder, &["solve", "small.toml", "-o", "v.safetensors"]);
    // What an interrupted solve of these settings would have left, for all that the name says.
    std::fs::rename(folder.join("v.safetensors"), folder.join("w.checkpoint.safetensors")).expect("renamed");
    let output = cncbf(&folder, &["solve", "small.toml", "-o", "w.safetensors"]);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
    let said = text(&output.stderr);
    assert!(said.contains("w.checkpoint.safetensors"), "{said}");
    assert!(!folder.join("w.safetensors").exists());
}

#[test]
fn files_that_are_no_models_are_refused_before_any_work() {
    let folder = scratch("no_models");
    let model = include_bytes!("../models/ground_robot_paper.safetensors");
    std::fs::write(folder.join("truncated.safetensors"), &model[..model.len() / 2])
        .expect("a writable folder");
    std::fs::write(folder.join("text.safetensors"), "not a model").expect("a writable folder");
    for file in ["truncated.safetensors", "text.safetensors", "missing.safetensors"] {
        for subcommand in ["verify", "inspect"] {
            let output = cncbf(&folder, &[subcommand, file]);
            let said = text(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{subcommand} {file}: {said}");
            assert!(said.contains(file) && !said.contains("panicked"), "{subcommand} {file}: {said}");
        }
    }
    std::fs::write(folder.join("model.safetensors"), model).expect("a writable folder");
    for arguments in [
        ["verify", "model.safetensors", "--prove", "0:1,0:1,0:1"],
        ["verify", "model.safetensors", "--prove", "0:1,0:1,0:1,zero:1"],
        ["inspect", "model.safetensors", "--at", "1,2"],
    ] {
        assert_eq!(cncbf(&folder, &arguments).status.code(), Some(2), "{arguments:?}");
    }
}

#[test]
fn settings_that_make_no_game_are_refused_before_any_work() {
    let folder = scratch("no_game");
    let good = include_str!("../config/ground_robot.toml");
    for (name, from, to, expected) in [
        ("fast", "max_speed_mps = 1.5", "max_speed_mps = 3.0", "max_speed_mps"),
        ("bounds", "control_min = [0.25, -0.8]", "control_min = [2.0, -0.8]", "robot.control_min"),
        ("memory", "count = [100, 100, 60, 10]", "count = [8000, 8000, 600, 100]", "bytes"),
    ] {
        let changed = good.replacen(from, to, 1);
        assert_ne!(changed, good, "{from} is not in the settings");
        std::fs::write(folder.join(format!("{name}.toml")), changed).expect("a writable folder");
        let output = cncbf(&folder, &["train", &format!("{name}.toml")]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{name}: {said}");
        assert!(said.contains(expected) && !said.contains("panicked"), "{name}: {said}");
    }
}
