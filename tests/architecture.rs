//! The rules on who may import whom, held against `cargo metadata`; and the code map held against the workspace.

use std::collections::BTreeSet;
use std::path::Path;

use cargo_metadata::{Metadata, MetadataCommand, Package};

/// The four processes: they meet in shared memory, never in code.
const PROCESSES: [&str; 4] = ["perception_bridge", "obstacle_estimator", "nominal_mpc", "cbf_filter"];

/// Registry crate → the workspace crates that may name it.
const RESERVED: [(&str, &[&str]); 10] = [
    ("iceoryx2", &["node_runtime"]),
    ("iceoryx2-cal", &["node_runtime"]),
    ("iceoryx2-bb-container", &["node_runtime"]),
    ("iceoryx2-bb-system-types", &["node_runtime"]),
    ("iceoryx2-bb-derive-macros", &["messages", "node_runtime"]),
    ("iceoryx2-bb-elementary-traits", &["messages", "node_runtime"]),
    ("ros2-client", &["node_runtime", "perception_bridge"]),
    ("mcap", &["recording"]),
    ("clarabel", &["barrier", "optimal_control"]),
    ("faer", &["optimal_control", "barrier_training", "reachability"]),
];

fn metadata() -> Metadata {
    MetadataCommand::new()
        .manifest_path(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml"))
        .no_deps()
        .other_options(["--offline".to_owned(), "--locked".to_owned()])
        .exec()
        .expect("cargo metadata runs")
}

fn names(package: &Package) -> BTreeSet<&str> {
    package.dependencies.iter().map(|dependency| dependency.name.as_str()).collect()
}

#[test]
fn processes_never_import_each_other() {
    for package in &metadata().packages {
        if !PROCESSES.contains(&package.name.as_str()) {
            continue;
        }
        for other in PROCESSES {
            assert!(
                !names(package).contains(other),
                "{} imports {other}; let them meet in messages",
                package.name
            );
        }
    }
}

#[test]
fn reserved_crates_stay_behind_their_one_door() {
    let mut seen = BTreeSet::new();
    for package in &metadata().packages {
        for (reserved, allowed) in RESERVED {
            if names(package).contains(reserved) {
                seen.insert(reserved);
                let name = package.name.as_str();
                assert!(allowed.contains(&name), "{name} imports {reserved}, which only {allowed:?} may");
            }
        }
    }
    assert!(
        seen.contains("iceoryx2") && seen.contains("clarabel") && seen.contains("mcap"),
        "saw only {seen:?}"
    );
}

#[test]
fn libraries_import_no_process_except_the_virtual_stack() {
    for package in &metadata().packages {
        let name = package.name.as_str();
        if name == "cncbf" || name == "evaluation" {
            continue;
        }
        for process in PROCESSES {
            assert!(!names(package).contains(process), "{name} imports the process {process}");
        }
    }
}

#[test]
fn exactly_one_package_sets_default_run() {
    let metadata = metadata();
    let with_default_run: Vec<_> = metadata
        .packages
        .iter()
        .filter(|package| package.default_run.is_some())
        .map(|p| p.name.as_str())
        .collect();
    assert_eq!(with_default_run, ["cncbf"]);
}

#[test]
fn the_code_map_names_every_crate_and_no_other() {
    let metadata = metadata();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("ARCHITECTURE.md")).expect("ARCHITECTURE.md exists");
    let mapped: BTreeSet<&str> = text
        .lines()
        .filter_map(|line| line.strip_prefix("### `"))
        .filter_map(|rest| rest.split('`').next())
        .map(|path| path.trim_end_matches('/'))
        .collect();
    let members: BTreeSet<String> = metadata
        .packages
        .iter()
        .map(|package| {
            let folder = package.manifest_path.parent().expect("a manifest lies in a folder");
            let relative = folder.strip_prefix(root).expect("members lie in the workspace").to_string();
            if relative.is_empty() { "src".to_owned() } else { relative }
        })
        .collect();
    let members: BTreeSet<&str> = members.iter().map(String::as_str).collect();
    assert_eq!(mapped, members, "ARCHITECTURE.md's code map (left) against the workspace (right)");
}

#[test]
fn every_source_file_says_what_lives_in_it_and_stays_small() {
    let mut offenders = Vec::new();
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a readable folder").flatten() {
            let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
            if path.is_dir() {
                if !name.starts_with('.') && name != "target" && name != "runs" {
                    folders.push(path);
                }
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = std::fs::read_to_string(&path).expect("a readable file");
                if !text.starts_with("//!") || text.lines().count() > 600 {
                    offenders.push(path);
                }
            }
        }
    }
    assert!(offenders.is_empty(), "no `//!` header, or more than 600 lines: {offenders:?}");
}
