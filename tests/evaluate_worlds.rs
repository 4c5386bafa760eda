//! `cncbf evaluate` in other worlds than the tables': scenario files of every kind of motion and class, people of a recording,
//! mixed crowds.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use evaluation::{Row, merged};

/// Scenarios with walls to bounce off, tracks to repeat, and all classes.
const WORLDS: &str = include_str!("data/evaluate_worlds.json");
const MIXED: &str = "simulation.classes={cyclist_share = 0.4, cyclist_speed_mps = [2.0, 4.0], cyclist_radius_m = 0.5, \
                     static_share = 0.3, static_radius_m = 0.35}";

fn cncbf(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cncbf"));
    for name in ["SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX", "JOB_COMPLETION_COUNT"] {
        command.env_remove(name);
    }
    command.args(arguments).current_dir(folder).output().expect("the command starts")
}

/// The rows that `evaluate` with `arguments` writes, and what it said.
fn rows(folder: &Path, out: &str, arguments: &[&str]) -> (Vec<Row>, String) {
    let output =
        cncbf(folder, &[&["evaluate", "--no-times", "--jobs", "2", "--out", out], arguments].concat());
    let told = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {told}");
    (merged(&[folder.join(out)]).expect("a table"), told)
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// An empty scratch folder of this test.
fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("evaluate_worlds").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a writable folder");
    folder
}

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn path(file: &Path) -> &str {
    file.to_str().expect("a plain path")
}

#[test]
fn a_file_of_walls_tracks_and_classes_gives_a_row_a_run_and_the_same_bytes_again() {
    let folder = scratch("file");
    std::fs::write(folder.join("worlds.json"), WORLDS).expect("a file");
    let arguments = ["--scenarios", "worlds.json", "--methods", "cn_cbf,sdf_mpc,no_filter"];
    let (rows, told) = rows(&folder, "a.parquet", &[&arguments[..], &["--report", "r"]].concat());
    assert!(rows.len() == 9 && told.contains("9 runs done"), "{told}");
    for (name, people, seed) in [("walls", 2, 3), ("replayed", 2, 0), ("head-on", 1, 0)] {
        let of_it: Vec<_> = rows.iter().filter(|row| row.scenario == name).collect();
        let mut methods: Vec<_> = of_it.iter().map(|row| row.method.as_str()).collect();
        methods.sort_unstable();
        assert_eq!(methods, ["cn_cbf", "no_filter", "sdf_mpc"], "{name}");
        assert!(of_it.iter().all(|row| row.people == people && row.seed == seed), "{name}");
    }
    // One line a method over the whole file, beside those of each crowd size.
    let tables = std::fs::read_to_string(folder.join("r/tables.md")).expect("a report");
    let whole = tables.split("\n#").find(|part| part.contains("All scenarios of the file")).expect("a table");
    assert!(whole.lines().any(|line| line.contains("cn_cbf") && line.contains("| 3 |")), "{whole}");
    // Nobody goes around somebody who stands in the way unless a method does.
    let head_on = |method: &str| {
        rows.iter().find(|row| row.scenario == "head-on" && row.method == method).expect("a row")
    };
    assert!(head_on("no_filter").collision_smaller && head_on("no_filter").cause == "not_filtered");
    assert!(!head_on("cn_cbf").collision_smaller, "{:?}", head_on("cn_cbf"));
    self::rows(&folder, "b.parquet", &arguments);
    let bytes = |name: &str| std::fs::read(folder.join(name)).expect("a table");
    assert!(bytes("a.parquet") == bytes("b.parquet"), "equal runs, other bytes");
}

#[test]
fn a_file_that_makes_no_sense_is_refused_by_scenario_and_field() {
    let folder = scratch("refused");
    for (from, to, words) in [
        (
            "\"class\": \"cyclist\"",
            "\"class\": \"dragon\"",
            &["walls", "people[1].class", "dragon", "cyclist"][..],
        ),
        (
            "[0.0, 2.0, 4.0, 6.0]",
            "[0.0, 2.0, 2.0, 6.0]",
            &["replayed", "people[0].motion.track.times_s[2]", "rise"],
        ),
        ("[0.0, 2.0, 4.0, 6.0]", "[0.0, 2.0, 4.0]", &["replayed", "people[0].motion.track"]),
        (
            "\"position_m\": [4.0, 2.0]",
            "\"position_m\": [4.0, 3.5]",
            &["walls", "people[0].motion.bounce", "outside"],
        ),
        ("\"id\": 9", "\"id\": 8", &["replayed", "id 8"]),
        ("\"head-on\"", "\"walls\"", &["two scenarios are called walls"]),
        ("\"bounce\"", "\"hover\"", &["walls", "people[0].motion", "hover"]),
        ("cncbf-scenarios/1", "cncbf-scenarios/9", &["cncbf-scenarios/9", "cncbf-scenarios/1"]),
        ("\"scenarios\": [", "\"scenarios\": [,", &["JSON"]),
    ] {
        assert!(WORLDS.contains(from), "{from}");
        std::fs::write(folder.join("bad.json"), WORLDS.replacen(from, to, 1)).expect("a file");
        let output = cncbf(&folder, &["evaluate", "--scenarios", "bad.json", "--methods", "cn_cbf"]);
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{to}: {told}");
        for word in ["bad.json"].iter().chain(words) {
            assert!(told.contains(word), "{to}: {word} is not in: {told}");
        }
    }
    let left = std::fs::read_dir(&folder).expect("a folder").count();
    assert_eq!(left, 1, "a refused table leaves nothing but the file of scenarios");
}

#[test]
fn a_recording_becomes_scenarios_that_are_evaluated() {
    let folder = scratch("recording");
    let demo = repository("recordings/demo_crowd.mcap");
    let cut = ["scenarios", path(&demo), "--every", "4", "--crossing", "6", "--out", "demo.json"];
    let output = cncbf(&folder, &cut);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    let scenarios = crowd_sim::read_scenarios(&folder.join("demo.json")).expect("its own output");
    assert!(said.contains(&format!("{} scenarios", scenarios.len())) && said.contains("demo.json"), "{said}");
    let (rows, _) = rows(&folder, "t.parquet", &["--scenarios", "demo.json", "--methods", "cn_cbf"]);
    assert_eq!(rows.len(), scenarios.len());
    for (scenario, row) in scenarios.iter().zip(&rows) {
        assert!(
            scenario.name.starts_with("demo_crowd-") && rows.iter().any(|row| row.scenario == scenario.name)
        );
        assert!(row.cycles > 100 && row.min_distance_m.is_some(), "{row:?}");
    }
    for (arguments, words) in [
        (&["scenarios", "nowhere.mcap", "--out", "x.json"][..], &["nowhere.mcap"][..]),
        (
            &["scenarios", path(&demo), "--crossing", "1e4", "--out", "x.json"],
            &["demo_crowd.mcap", "crossing_s"],
        ),
        (&["scenarios", path(&demo), "--every", "-1", "--out", "x.json"], &["every_s", "-1"]),
        (&["scenarios", path(&demo), "--out", "no/such/x.json"], &["no/such/x.json", "--out"]),
        (&["scenarios", path(&demo)], &["--out"]),
        (&["scenarios", "--out", "x.json"], &["F.mcap"]),
    ] {
        let output = cncbf(&folder, arguments);
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
        for word in words {
            assert!(told.contains(word), "{arguments:?}: {word} is not in: {told}");
        }
    }
    assert!(!folder.join("x.json").exists());
}

#[test]
fn people_of_a_real_place_are_evaluated() {
    let folder = scratch("eth");
    let recordings = ["eth_seq_eth", "eth_seq_hotel"].map(|name| {
        let file = repository(&format!("../shared/recordings/{name}.mcap"));
        path(&file).to_owned()
    });
    if let Some(absent) = recordings.iter().find(|file| !Path::new(file).exists()) {
        println!("skipped: {absent} is not beside this checkout");
        return;
    }
    let [eth, hotel] = recordings.each_ref().map(String::as_str);
    let output = cncbf(&folder, &["scenarios", eth, hotel, "--every", "20", "--out", "eth.json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let (rows, _) = rows(&folder, "t.parquet", &["--scenarios", "eth.json", "--methods", "no_filter"]);
    for name in ["eth_seq_eth-", "eth_seq_hotel-"] {
        assert!(rows.iter().any(|row| row.scenario.starts_with(name) && row.people > 5), "{name}");
    }
}

#[test]
fn a_mixed_crowd_is_drawn_for_every_method_and_class_models_are_taken() {
    let folder = scratch("mixed");
    let mixed = format!("mixed={}", path(&repository("config/mixed_classes.toml")));
    let methods = format!("cn_cbf,{mixed},no_filter");
    let short = ["--set", "simulation.timeout_s=6.0", "--people", "10", "--scenarios", "2", "--seed", "1001"];
    let arguments = [&short[..], &["--methods", &methods, "--set", MIXED]].concat();
    let (among_all, _) = rows(&folder, "mixed.parquet", &arguments);
    let arguments = [&short[..], &["--methods", "no_filter"]].concat();
    let (among_pedestrians, _) = rows(&folder, "pedestrians.parquet", &arguments);
    let of = |rows: &[Row], method: &str| {
        let mut of_it: Vec<Row> = rows.iter().filter(|row| row.method == method).cloned().collect();
        of_it.sort_by(|a, b| a.scenario.cmp(&b.scenario));
        assert_eq!(of_it.len(), 2, "{method}");
        of_it
    };
    let nearest = |rows: &[Row]| rows.iter().map(|row| row.min_distance_m).collect::<Vec<_>>();
    assert_ne!(nearest(&of(&among_all, "no_filter")), nearest(&of(&among_pedestrians, "no_filter")));
    // The two differ in nothing but the models of classes: what they do differs if, and only if, these are used.
    let [one_model, class_models] = ["cn_cbf", "mixed"].map(|method| of(&among_all, method));
    assert_ne!(one_model[0].path_length_m.to_bits(), class_models[0].path_length_m.to_bits());
}
