//! `cncbf run --scenario`: a situation of a file, driven by the whole stack, and what is said where there is none.

#[path = "stack/command.rs"]
mod command;

use std::ffi::OsStr;
use std::path::Path;

use command::{Said, at, cncbf, count, scratch};
use node_runtime::Domain;

/// Two metres straight ahead; somebody stands beside the way.
const FILE: &str = r#"{"format": "cncbf-scenarios/1", "scenarios": [
    {"name": "elsewhere", "start": {"position_m": [0, 0], "heading_rad": 0}, "goal_m": [90, 0],
     "goal_tolerance_m": 0.3, "time_limit_s": 60, "robot_radius_m": 0.35,
     "arena": {"x_m": [0, 90], "y_m": [-5, 5]}, "people": []},
    {"name": "short", "start": {"position_m": [1, 0], "heading_rad": 0}, "goal_m": [3, 0],
     "goal_tolerance_m": 0.3, "time_limit_s": 60, "robot_radius_m": 0.35,
     "arena": {"x_m": [0, 9], "y_m": [-5, 5]},
     "people": [{"id": 4, "radius_m": 0.35, "motion": {"bounce": {"position_m": [2, 4], "velocity_mps": [0, 0]}}}]}
]}"#;

fn run(folder: &Path, arguments: &[&str]) -> Said {
    let mut all: Vec<&dyn AsRef<OsStr>> = vec![&"run", &"--json", &"--report", &"report"];
    all.extend(arguments.iter().map(|argument| argument as &dyn AsRef<OsStr>));
    Said::by(cncbf(&Domain::isolated(), folder), &all)
}

#[test]
fn the_scenario_named_is_driven() {
    let folder = scratch("scenario_run");
    std::fs::write(folder.join("crowds.json"), FILE).expect("a writable scratch folder");
    let said = run(&folder, &["--scenario", "crowds.json:short"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let figures = said.json();
    assert_eq!(count(&figures, "/collisions"), 0);
    let path_m = at(&figures, "/path_length_m").as_f64().expect("a length");
    assert!((1.6..2.2).contains(&path_m), "{path_m} m instead of 2 m less the tolerance");
    let page = std::fs::read_to_string(folder.join("report/report.html")).expect("a report");
    assert!(page.contains("scenario short"), "the report does not name the scenario");
}

#[test]
fn a_scenario_that_is_not_there_is_named_with_its_file() {
    let folder = scratch("scenario_missing");
    std::fs::write(folder.join("crowds.json"), FILE).expect("a writable scratch folder");
    std::fs::write(folder.join("broken.json"), FILE.replace("goal_m", "gaol_m")).expect("writable");
    for (arguments, words) in [
        (&["--scenario", "crowds.json:long"][..], &["crowds.json", "long", "elsewhere, short"][..]),
        (&["--scenario", "nowhere.json"], &["nowhere.json", "check the path"]),
        (&["--scenario", "broken.json"], &["broken.json", "scenario elsewhere", "gaol_m", "goal_m"]),
        (&["--scenario", "crowds.json", "--source", "ros2"], &["--scenario", "ros2"]),
        (&["--scenario", "crowds.json", "--people", "3"], &["--scenario", "--people"]),
    ] {
        let said = run(&folder, arguments);
        assert_eq!(said.code, 2, "{arguments:?}: {}", said.err);
        for word in words {
            assert!(said.err.contains(word), "{arguments:?}: {word} is not in: {}", said.err);
        }
    }
    assert!(!folder.join("report").exists(), "a refused run leaves nothing");
}
