//! Scenarios as worlds: of files, and cut out of recordings.
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use std::path::{Path, PathBuf};

use crowd_sim::{Motion, PlantSettings, Scenario, ScenarioRequest, World, read_scenarios, write_scenarios};
use perception_bridge::{
    McapSource, Obedience, RecordedCrowd, RecordedCrowdError, SimulatedCrowd, SimulationError, Source,
    scenarios_of_recording,
};
use settings::{ScenarioSettings, Settings};

const MS: u64 = 1_000_000;

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

fn settings() -> Settings {
    Settings::load(&repository("config/ground_robot.toml")).unwrap()
}

#[test]
fn a_scenario_of_a_file_takes_the_place_of_the_drawn_one() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("two.json");
    let [calm, busy] = [3, 9].map(|count| Scenario {
        time_limit_s: 1.0,
        ..ScenarioRequest::evaluation(1, count).generate().unwrap()
    });
    write_scenarios(&file, &[calm, busy.clone()]).unwrap();
    let mut settings = settings();
    let open = |settings: &Settings| SimulatedCrowd::new(settings);
    settings.simulation.scenario = Some(ScenarioSettings { file: file.clone(), name: None });
    assert_eq!(open(&settings).unwrap().world().people().len(), 3);
    settings.simulation.scenario =
        Some(ScenarioSettings { file: file.clone(), name: Some(busy.name.clone()) });
    let mut named = open(&settings).unwrap();
    let mut given = SimulatedCrowd::in_scenario(&settings, &busy, Obedience::Filter).unwrap();
    assert_eq!(named.world().people().len(), 9);
    assert_eq!(named.world().goal_m(), [13.0, 0.0]);
    let mut events = 0;
    for tick in 0..2_000 {
        while let Some(event) = named.poll(tick * MS) {
            assert_eq!(given.poll(tick * MS), Some(event));
            events += 1;
        }
    }
    assert!(events > 100 && named.status(0).finished == 1, "the file's time limit holds");
    settings.simulation.scenario = Some(ScenarioSettings { file, name: Some("nobody".to_owned()) });
    let Err(error) = open(&settings) else { panic!("no such scenario") };
    assert!(matches!(error, SimulationError::File(_)) && error.to_string().contains("nobody"), "{error}");
}

/// Asserts what holds for scenarios of any recording; returns how many people they have in all.
fn assert_faithful(
    file: &Path,
    settings: &Settings,
    request: &RecordedCrowd,
    scenarios: &[Scenario],
) -> usize {
    let mut recorded = McapSource::open(file, settings, false).unwrap();
    // Everything recorded, as positions by identity and time: who is in a scenario was recorded there and then.
    let mut frames = Vec::new();
    let mut now_ns = 0;
    recorded.poll(0);
    while let Some(due_ns) = recorded.next_due_ns() {
        now_ns = due_ns.max(now_ns);
        while let Some(event) = recorded.poll(now_ns) {
            if let perception_bridge::BridgeEvent::Detections(frame) = event {
                frames.push((frame.stamp.valid_at_ns as f64 * 1e-9, frame));
            }
        }
    }
    for scenario in scenarios {
        let start_s: f64 = scenario.name.rsplit_once('-').unwrap().1.trim_end_matches('s').parse().unwrap();
        let way_m = (scenario.goal_m[0] - scenario.start.position_m[0])
            .hypot(scenario.goal_m[1] - scenario.start.position_m[1]);
        assert!((way_m - request.way_m).abs() < 1e-9);
        let mut world = World::new(scenario, PlantSettings::ground_robot()).unwrap();
        assert!(world.ledger().clearance_m() >= request.clear_of_start_m - 1.0, "{}", scenario.name);
        let frames = frames.iter().filter(|(time_s, _)| (start_s..start_s + 10.0).contains(time_s));
        let (mut checked, mut worst_m): (usize, f64) = (0, 0.0);
        for (time_s, frame) in frames {
            // Frames lie between the crowd's ticks, too.
            let wait_s = time_s - start_s - world.time_ns() as f64 * 1e-9;
            if wait_s < 1e-9 {
                continue;
            }
            world.step(wait_s, [0.0, 0.0]).unwrap();
            for detection in frame.as_slice() {
                let [x, y] = detection.position_in_odom_m;
                let nearest_m = world
                    .people()
                    .iter()
                    .map(|person| (person.position_m[0] - x).hypot(person.position_m[1] - y))
                    .fold(f64::INFINITY, f64::min);
                // At the very edges of a track, the crowd's ticks miss up to one of their periods.
                if nearest_m < 0.5 {
                    worst_m = worst_m.max(nearest_m);
                    checked += 1;
                }
            }
            let known = frame.as_slice().len();
            assert!(
                world.people().len().abs_diff(known) <= known.max(4),
                "{} of {known}",
                world.people().len()
            );
        }
        assert!(checked > 0 && worst_m < 0.05, "{}: {checked} checked, worst {worst_m} m", scenario.name);
    }
    scenarios.iter().map(|scenario| scenario.people.len()).sum()
}

#[test]
fn the_own_recording_becomes_scenarios() {
    let (file, settings) = (repository("recordings/demo_crowd.mcap"), settings());
    let request = RecordedCrowd { every_s: 2.0, crossing_s: 6.0, ..RecordedCrowd::EVERY_5_S };
    let scenarios = scenarios_of_recording(&file, "demo", &settings, &request).unwrap();
    assert!(scenarios.len() >= 2 && scenarios[0].name.starts_with("demo-"), "{}", scenarios.len());
    let people = assert_faithful(&file, &settings, &request, &scenarios);
    assert!(people >= 8 * scenarios.len(), "{people} people in {} scenarios", scenarios.len());
    // Bit for bit again from a file.
    let folder = tempfile::tempdir().unwrap();
    let written = folder.path().join("demo.json");
    write_scenarios(&written, &scenarios).unwrap();
    assert_eq!(read_scenarios(&written).unwrap(), scenarios);
}

#[test]
fn real_pedestrians_become_scenarios() {
    for (name, least) in [("eth_seq_eth", 30), ("eth_seq_hotel", 30)] {
        let file = repository(&format!("../shared/recordings/{name}.mcap"));
        if !file.exists() {
            println!("skipped: {name}.mcap is not beside this checkout");
            continue;
        }
        let (settings, request) = (settings(), RecordedCrowd::EVERY_5_S);
        let scenarios = scenarios_of_recording(&file, name, &settings, &request).unwrap();
        assert!((5..=9).contains(&scenarios.len()), "{} scenarios", scenarios.len());
        let people = assert_faithful(&file, &settings, &request, &scenarios);
        assert!(people >= least, "{people} people");
        let walking = scenarios[0].people.iter().all(|person| matches!(person.motion, Motion::Track { .. }));
        assert!(walking);
        println!("{name}: {} scenarios, {people} people", scenarios.len());
    }
}

#[test]
fn a_recording_too_short_is_said_to_be() {
    let (file, settings) = (repository("recordings/demo_crowd.mcap"), settings());
    let request = RecordedCrowd { crossing_s: 1e4, ..RecordedCrowd::EVERY_5_S };
    let error = scenarios_of_recording(&file, "demo", &settings, &request).unwrap_err();
    assert!(matches!(error, RecordedCrowdError::NoScenario { .. }), "{error}");
    let request = RecordedCrowd { every_s: 0.0, ..RecordedCrowd::EVERY_5_S };
    let error = scenarios_of_recording(&file, "demo", &settings, &request).unwrap_err();
    assert!(matches!(error, RecordedCrowdError::BadNumber { field: "every_s", .. }), "{error}");
}
