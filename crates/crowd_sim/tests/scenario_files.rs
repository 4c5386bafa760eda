//! Scenario files: what is written is read back bit for bit, and what is wrong is said by name.
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use std::path::Path;

use crowd_sim::{
    CrowdKind, Motion, Person, RobotLimits, SCENARIO_FORMAT, Scenario, ScenarioFileError, ScenarioRequest,
    parse_scenarios, read_scenario, read_scenarios, write_scenarios,
};
use rand::RngExt;
use rand_pcg::Pcg64;
use serde_json::{Value, json};
use settings::ClassName;

/// A scenario with people of all kinds and numbers with all their digits.
fn random_scenario(random: &mut Pcg64, index: usize) -> Scenario {
    let seed = random.random();
    let crowd = if random.random() { CrowdKind::SocialForce } else { CrowdKind::Bounce };
    let count = random.random_range(0..20);
    let mut scenario =
        ScenarioRequest { crowd, ..ScenarioRequest::evaluation(seed, count) }.generate().unwrap();
    scenario.name = format!("scenario-{index}");
    scenario.goal_heading_rad = random.random_range(-4.0..4.0);
    scenario.robot_limits = random.random::<bool>().then(|| RobotLimits {
        input_min: [-random.random::<f64>(), 0.0],
        input_max: [random.random(), 0.0],
        axis_speed_mps: random.random::<bool>().then(|| random.random_range(0.1..3.0)),
    });
    for k in 0..random.random_range(0..5) {
        let mut time_s = random.random_range(-10.0..10.0);
        let times_s: Vec<f64> = (0..random.random_range(2..50))
            .map(|_| {
                time_s += random.random_range(0.01..1.0);
                time_s
            })
            .collect();
        let positions_m =
            times_s.iter().map(|_| [random.random_range(-9.0..9.0), 1e-9 * random.random::<f64>()]).collect();
        let motion = Motion::Track { times_s, positions_m };
        let class = [ClassName::Pedestrian, ClassName::Cyclist, ClassName::Static, ClassName::Vehicle]
            [random.random_range(0..4)];
        let radius_m = random.random_range(0.1..1.0);
        scenario.people.push(Person { id: u64::MAX - k, radius_m, class, motion });
    }
    scenario
}

#[test]
fn what_is_written_is_read_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("crowds.json");
    let mut random = Pcg64::new(3, 5);
    for _ in 0..50 {
        let scenarios: Vec<_> = (0..4).map(|index| random_scenario(&mut random, index)).collect();
        write_scenarios(&file, &scenarios).unwrap();
        // Zero and minus zero are equal, so that the text is compared, too.
        let again = read_scenarios(&file).unwrap();
        assert!(again == scenarios && format!("{again:?}") == format!("{scenarios:?}"));
    }
    let of_name = read_scenario(&file, Some("scenario-2")).unwrap();
    assert_eq!(of_name.name, "scenario-2");
    assert_eq!(read_scenario(&file, None).unwrap().name, "scenario-0");
    let error = read_scenario(&file, Some("nobody")).unwrap_err().to_string();
    assert!(error.contains("nobody") && error.contains("scenario-3"), "{error}");
}

/// The example of docs/scenarios.md: the JSON block without its comments.
fn documented() -> Value {
    let text = include_str!("../../../docs/scenarios.md");
    let block = text.split("```jsonc\n").nth(1).and_then(|rest| rest.split("```").next()).expect("a block");
    let bare: Vec<_> = block.lines().map(|line| line.split("//").next().unwrap_or_default()).collect();
    serde_json::from_str(&bare.join("\n")).expect("the documented example is JSON")
}

fn parse(file: &Value) -> Result<Vec<Scenario>, ScenarioFileError> {
    parse_scenarios(&file.to_string(), Path::new("crowds.json"))
}

#[test]
fn the_documented_example_is_accepted_and_has_a_person_of_each_kind() {
    let scenarios = parse(&documented()).unwrap();
    let kinds: Vec<_> =
        scenarios[0].people.iter().map(|person| std::mem::discriminant(&person.motion)).collect();
    let classes: Vec<_> = scenarios[0].people.iter().map(|person| person.class).collect();
    assert_eq!(classes, [ClassName::Pedestrian, ClassName::Cyclist, ClassName::Pedestrian]);
    assert!(kinds.len() >= 3 && kinds[0] != kinds[1] && kinds[1] != kinds[2] && kinds[0] != kinds[2]);
}

/// What is said about the documented example with the value at `pointer` replaced, or taken away.
fn said(pointer: &str, value: Option<Value>) -> String {
    let mut file = documented();
    let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
    match (file.pointer_mut(parent).expect("exists"), value) {
        (Value::Object(object), Some(value)) => drop(object.insert(key.to_owned(), value)),
        (Value::Object(object), None) => drop(object.remove(key)),
        (Value::Array(array), Some(value)) => array[key.parse::<usize>().expect("an index")] = value,
        _ => panic!("{parent} holds nothing"),
    }
    let error = parse(&file).unwrap_err().to_string();
    assert!(error.starts_with("crowds.json: "), "{error}");
    error
}

#[test]
fn errors_name_file_scenario_and_field() {
    let first = "/scenarios/0";
    let cases: [(&str, Option<Value>, &[&str]); 15] = [
        ("/people/1/class", Some(json!("dragon")), &["people[1].class", "dragon", "cyclist"]),
        ("/people/0/radius_m", Some(json!("wide")), &["people[0].radius_m", "wide", "f64"]),
        ("/people/0/radius_m", Some(json!(-1)), &["people[0].radius_m", "greater than zero"]),
        ("/people/0/height_m", Some(json!(1.8)), &["people[0].height_m", "unknown field", "radius_m"]),
        ("/people/0/id", None, &["people[0]", "missing field `id`"]),
        (
            "/people/0/motion",
            Some(json!({"fly": {}})),
            &["people[0].motion", "fly", "social_force", "bounce"],
        ),
        ("/people/0/motion/social_force/goals_m", Some(json!([])), &["goals_m", "at least one"]),
        ("/people/0/motion/social_force/goals_m", Some(json!([[1, 2], [3]])), &["social_force.goals_m[1]"]),
        ("/people/1/motion/bounce/position_m/0", Some(json!(99)), &["people[1].motion.bounce", "outside"]),
        ("/people/1/id", Some(json!(0)), &["id 0", "from 1 on"]),
        ("/arena/x_m", Some(json!([3, 1])), &["arena", "smaller one first"]),
        ("/goal_m", None, &["missing field `goal_m`"]),
        ("/time_limit_s", Some(json!(0)), &["time_limit_s", "greater than zero"]),
        ("/goal_tolerance_m", Some(json!(1e300)), &["goal_tolerance_m", "beyond"]),
        ("/start", Some(json!(null)), &["start", "null"]),
    ];
    for (pointer, value, words) in cases {
        let error = said(&format!("{first}{pointer}"), value);
        assert!(error.contains("scenario three-of-a-kind"), "{pointer}: {error}");
        for word in words {
            assert!(error.contains(word), "{pointer}: {word:?} is not in: {error}");
        }
    }
    let error = said("/scenarios/1/people", Some(json!(7)));
    assert!(error.contains("scenario empty") && error.contains("people"), "{error}");
    let error = said("/scenarios/1/name", None);
    assert!(error.contains("scenarios[1]") && error.contains("missing field `name`"), "{error}");
    let error = said("/scenarios/1/name", Some(json!("three-of-a-kind")));
    assert!(error.contains("two scenarios are called three-of-a-kind"), "{error}");
    let error = said("/scenarios/1", Some(json!([1])));
    assert!(error.contains("scenarios[1]"), "{error}");
}

#[test]
fn other_formats_and_other_files_are_told_apart() {
    let error = said("/format", Some(json!("cncbf-scenarios/2")));
    assert!(error.contains("cncbf-scenarios/2") && error.contains(SCENARIO_FORMAT), "{error}");
    assert!(said("/format", None).contains("format is missing"));
    assert!(said("/scenarios", Some(json!([]))).contains("0 scenarios"));
    assert!(said("/scenarios", Some(json!({}))).contains("scenarios"));
    assert!(said("/people", Some(json!([]))).contains("unknown field `people`"));
    for text in ["", "[", "{\"format\": nonsense}", "[1, 2]", "null", &"[".repeat(100_000)] {
        assert!(parse_scenarios(text, Path::new("x.json")).is_err());
    }
    let twice = format!("{0}{0}", documented());
    assert!(matches!(parse_scenarios(&twice, Path::new("x.json")), Err(ScenarioFileError::Syntax { .. })));
}

#[test]
fn a_hostile_file_ends_in_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("huge.json");
    std::fs::File::create(&file).unwrap().set_len(1 << 40).unwrap();
    assert!(matches!(read_scenarios(&file), Err(ScenarioFileError::TooLarge { .. })));
    assert!(matches!(read_scenarios(folder.path()), Err(ScenarioFileError::Read { .. })));
    let points = vec![json!([1, 2]); 200_000];
    let error = said("/scenarios/0/people/0/motion/social_force/goals_m", Some(Value::Array(points)));
    assert!(error.contains("200000") && error.contains("at most 1000"), "{error}");
    let error = said("/scenarios/0/people/0/id", Some(json!(1e30)));
    assert!(error.contains("people[0].id"), "{error}");
}

#[test]
fn nothing_is_written_that_could_not_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = ScenarioRequest::demo(1).generate().unwrap();
    let file = folder.path().join("crowds.json");
    let twice = write_scenarios(&file, &[scenario.clone(), scenario.clone()]);
    assert!(matches!(twice, Err(ScenarioFileError::TwiceNamed { .. })));
    let broken = Scenario { goal_m: [f64::NAN, 0.0], ..scenario.clone() };
    assert!(matches!(write_scenarios(&file, &[broken]), Err(ScenarioFileError::Scenario { .. })));
    assert!(!file.exists());
    let nowhere = folder.path().join("no/such/folder.json");
    let error = write_scenarios(&nowhere, &[scenario]).unwrap_err();
    assert!(matches!(error, ScenarioFileError::Write { .. }), "{error}");
}
