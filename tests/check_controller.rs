//! `cncbf check-controller` on good controllers, ours and Python's, and on bad ones, each of which breaks one rule.
//!
//! The bad ones are this test's own executable, started again with a vice in its environment: see `candidate`.

#[path = "stack/command.rs"]
#[expect(dead_code, reason = "other tests need the rest")]
mod command;
#[path = "stack/guests.rs"]
#[expect(dead_code, reason = "other tests need the rest")]
mod guests;

use std::ffi::OsStr;
use std::path::Path;

use command::{Said, at, cncbf, scratch};
use messages::{Goal, Intent, NominalCommand, ProcessId, RobotState};
use node_runtime::{Clock, Domain, Node, RealClock, Shutdown};
use nominal_mpc::{Inputs, NominalController};
use serde_json::Value;
use settings::{ControllerKind, Settings};

/// Tells the test's own executable to be a candidate, and which rule to break.
const VICE: &str = "CNCBF_TEST_VICE";
/// Time between two commands of the candidate, ms.
const PERIOD_MS: u64 = 50;
/// How old a robot state the candidate with the vice `stale` answers, ns.
const STALE_NS: u64 = 400_000_000;

/// The shipped settings with limits that a busy machine keeps.
fn settings_text() -> String {
    include_str!("../config/ground_robot.toml")
        .replacen("nominal_max_silence_ms = 80", "nominal_max_silence_ms = 250", 1)
        .replacen("max_state_age_ms = 100", "max_state_age_ms = 250", 1)
}

/// What the check says of `command`.
fn check(name: &str, vice: Option<&str>, command: &[&dyn AsRef<OsStr>]) -> (Said, Value) {
    let folder = scratch(name);
    let config = folder.join("settings.toml");
    std::fs::write(&config, settings_text()).expect("a writable folder");
    let mut program = cncbf(&Domain::isolated(), &folder);
    if let Some(vice) = vice {
        program.env(VICE, vice);
    }
    let mut arguments: Vec<&dyn AsRef<OsStr>> =
        vec![&"check-controller", &"--json", &"--patience", &"10", &"--config", &config, &"--"];
    arguments.extend(command);
    let said = Said::by(program, &arguments);
    let findings = said.json();
    (said, findings)
}

/// Names of the rules that ended with `outcome`.
fn rules<'a>(findings: &'a Value, outcome: &str) -> Vec<&'a str> {
    let checks = at(findings, "/checks").as_array().expect("a list of checks");
    let ended = checks.iter().filter(|check| check["outcome"] == outcome);
    ended.map(|check| check["name"].as_str().expect("a name")).collect()
}

/// Asserts that a controller keeps every rule.
fn assert_keeps_all(name: &str, command: &[&dyn AsRef<OsStr>]) {
    let (said, findings) = check(name, None, command);
    assert_eq!((said.code, rules(&findings, "fail")), (0, Vec::new()), "{findings:#}");
    assert_eq!(at(&findings, "/passed"), true);
    assert_eq!(rules(&findings, "pass").len(), 15, "{findings:#}");
    assert!(said.err.contains("driving to the first goal"), "no progress is told: {}", said.err);
}

/// Asserts that the candidate with `vice` breaks `rule` and no other.
fn assert_breaks(vice: &str, rule: &str) -> Value {
    let own = std::env::current_exe().expect("this test");
    let (said, findings) =
        check(&format!("check_{vice}"), Some(vice), &[&own, &"--exact", &"candidate", &"--nocapture"]);
    assert_eq!((said.code, rules(&findings, "fail")), (1, vec![rule]), "{findings:#}");
    let checks = at(&findings, "/checks").as_array().expect("checks");
    let failed = checks.iter().find(|check| check["outcome"] == "fail").expect("one");
    assert!(failed["advice"].as_str().is_some_and(|advice| advice.len() > 20), "{failed}");
    findings
}

#[test]
fn our_own_controllers_keep_every_rule() {
    let own = env!("CARGO_BIN_EXE_cncbf");
    for controller in ["pure_pursuit", "mpc"] {
        assert_keeps_all(&format!("check_{controller}"), &[&own, &"nominal", &"--controller", &controller]);
    }
}

#[test]
fn the_python_example_keeps_every_rule() {
    let Some(python) = guests::python() else { return };
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("bindings/python/examples/pure_pursuit.py");
    assert_keeps_all("check_python", &[&python, &example]);
}

#[test]
fn a_candidate_without_vices_keeps_every_rule() {
    let own = std::env::current_exe().expect("this test");
    let (said, findings) =
        check("check_none", Some("none"), &[&own, &"--exact", &"candidate", &"--nocapture"]);
    assert_eq!(said.code, 0, "the vices below would prove nothing: {findings:#}");
}

#[test]
fn a_silent_candidate_is_told_so_with_its_output() {
    let findings = assert_breaks("silent", "speaks");
    assert_eq!(rules(&findings, "pass"), ["stays", "ends"], "{findings:#}");
    let output = at(&findings, "/output").as_str().expect("text");
    assert!(output.contains("the vice is silent"), "{output}");
}

#[test]
fn each_vice_on_the_wire_breaks_its_own_rule() {
    for (vice, rule) in [("nan", "finite"), ("sequence", "stamps"), ("nobody", "codes"), ("stale", "age")] {
        assert_breaks(vice, rule);
    }
}

#[test]
fn each_vice_in_time_breaks_its_own_rule() {
    for (vice, rule) in [("slow", "rate"), ("goes_on", "silence"), ("ignores_sigterm", "ends")] {
        assert_breaks(vice, rule);
    }
}

#[test]
fn each_vice_about_goals_breaks_its_own_rule() {
    for (vice, rule) in
        [("forgets_old_goal", "late start"), ("never_stops", "stop at goal"), ("keeps_goal", "goal change")]
    {
        assert_breaks(vice, rule);
    }
}

#[test]
fn a_candidate_that_a_nan_silences_for_good_is_found() {
    assert_breaks("poisoned", "not a number");
}

#[test]
fn what_cannot_be_started_is_refused() {
    let folder = scratch("check_refused");
    let arguments: [&dyn AsRef<OsStr>; 3] = [&"check-controller", &"--", &"/nowhere/controller"];
    let said = Said::by(cncbf(&Domain::isolated(), &folder), &arguments);
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.err.contains("/nowhere/controller") && said.err.contains("installed"), "{}", said.err);
    let said = Said::by(cncbf(&Domain::isolated(), &folder), &[&"check-controller"]);
    assert_eq!(said.code, 2, "{said:?}");
}

/// Not a test unless it is told to be a candidate: a good controller with one vice.
#[test]
fn candidate() {
    let Ok(vice) = std::env::var(VICE) else { return };
    println!("the vice is {vice}");
    let shutdown = Shutdown::install().expect("signals");
    let node = Node::open("cncbf", ProcessId::Nominal).expect("a node");
    let mut states = node.subscriber::<RobotState>().expect("robot states");
    let mut goals = node.subscriber::<Goal>().expect("goals");
    let commands = node.publisher::<NominalCommand>().expect("the place");
    let mut settings =
        Settings::parse(&settings_text(), "test".as_ref(), ".".as_ref()).expect("shipped settings");
    settings.use_controller(ControllerKind::PurePursuit).expect("there is a table");
    let mut controller = NominalController::new(&settings).expect("a controller");
    let mut history: Vec<(RobotState, u64)> = Vec::new();
    let mut goal: Option<Goal> = None;
    let mut sent = 0;
    while !shutdown.requested() || vice == "ignores_sigterm" {
        let period_ms = if vice == "slow" { 500 } else { PERIOD_MS };
        std::thread::sleep(std::time::Duration::from_millis(period_ms));
        states.drain(|state| history.push((*state, RealClock.now_ns())));
        goals.drain(|newer| {
            if vice != "keeps_goal" || goal.is_none() {
                goal = Some(*newer);
            }
        });
        let now_ns = RealClock.now_ns();
        if vice == "poisoned" && history.iter().any(|(state, _)| !state.is_finite()) {
            continue;
        }
        let old_enough = |(state, _): &&(RobotState, u64)| match vice.as_str() {
            "stale" => state.stamp.valid_at_ns + STALE_NS <= now_ns,
            _ => true,
        };
        // Whoever is stale still falls silent where nothing comes any more.
        let newest_ns = history.last().map_or(0, |(state, _)| state.stamp.valid_at_ns);
        if vice == "stale" && now_ns - newest_ns > 100_000_000 {
            continue;
        }
        let Some((state, received_ns)) = history.iter().rfind(old_enough) else { continue };
        let believed_now_ns = match vice.as_str() {
            "stale" | "goes_on" => state.stamp.valid_at_ns,
            _ => now_ns,
        };
        let known = goal.filter(|goal| vice != "forgets_old_goal" || goal.stamp.sequence > 1);
        let inputs =
            Inputs { robot_state: Some(state), robot_state_received_ns: *received_ns, goal: known.as_ref() };
        let Ok(mut command) = controller.step(&inputs, believed_now_ns) else { continue };
        sent += 1;
        command.controller = 1234;
        match vice.as_str() {
            "silent" => continue,
            "nan" if sent == 20 => command.control[0] = f64::NAN,
            "sequence" => command.stamp.sequence = 1,
            "nobody" => command.controller = 7,
            "never_stops" if command.intent == Intent::Stop.code() => {
                (command.intent, command.control) = (Intent::Drive.code(), [0.3, 0.3]);
            }
            _ => {}
        }
        command.stamp.published_ns = RealClock.now_ns();
        commands.send(&command).expect("a command leaves");
    }
}
