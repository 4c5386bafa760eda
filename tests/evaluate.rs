//! `cncbf evaluate` as a stranger meets it: tables and reports, clear refusals, nothing lost when killed, nothing done twice.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

/// A short way for every run.
const SHORT: [&str; 6] = [
    "--set",
    "simulation.goal=[1.0, 0.0, 0.0]",
    "--set",
    "simulation.timeout_s=8.0",
    "--set",
    "simulation.start_clearance_m=1.5",
];

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cncbf"));
    command.arg("evaluate").args(arguments).current_dir(folder);
    for name in ["SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX", "JOB_COMPLETION_COUNT"] {
        command.env_remove(name);
    }
    command
}

fn evaluate(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().expect("the command starts")
}

/// Short runs of two quadrotor methods with `arguments`, which succeed; what was said on standard error.
fn succeed(folder: &Path, arguments: &[&str]) -> String {
    let methods = ["--robot", "quadrotor", "--methods", "cn_cbf,no_filter", "--people", "3,6", "--jobs", "2"];
    let output = evaluate(folder, &[&methods[..], &SHORT, arguments].concat());
    let told = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {told}");
    told
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// An empty scratch folder of this test.
fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("evaluate").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a writable folder");
    folder
}

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn slices_of_a_cluster_merge_to_the_bytes_of_one_machine() {
    let folder = scratch("slices");
    succeed(&folder, &["--scenarios", "3", "--no-times", "--out", "whole.parquet", "--report", "whole"]);
    for index in ["1", "2"] {
        let methods =
            ["--robot", "quadrotor", "--methods", "cn_cbf,no_filter", "--people", "3,6", "--no-times"];
        let arguments = [&methods[..], &SHORT, &["--scenarios", "3", "--out", "slice.parquet"]].concat();
        let mut slice = command(&folder, &arguments);
        slice.env("SLURM_ARRAY_TASK_ID", index).env("SLURM_ARRAY_TASK_COUNT", "2");
        assert!(slice.status().expect("the command starts").success());
    }
    let merge = [
        "--merge",
        "slice.1-of-2.parquet",
        "slice.2-of-2.parquet",
        "--out",
        "all.parquet",
        "--report",
        "all",
    ];
    let output = evaluate(&folder, &merge);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(bytes(&folder, "all.parquet") == bytes(&folder, "whole.parquet"));
    for name in ["tables.md", "summary.json", "quadrotor_success.svg", "quadrotor_time.svg"] {
        assert!(bytes(&folder.join("all"), name) == bytes(&folder.join("whole"), name), "{name}");
    }
    let page = String::from_utf8(bytes(&folder.join("all"), "evaluation.html")).expect("a page is text");
    assert!(page.contains("<svg") && page.contains("cn_cbf") && page.contains("no_filter"));
}

#[test]
fn nothing_is_computed_twice_and_more_can_be_added() {
    let folder = scratch("again");
    let first = succeed(&folder, &["--scenarios", "2", "--out", "t.parquet"]);
    assert!(first.contains("8 runs done, 0 were there"), "{first}");
    let again = succeed(&folder, &["--scenarios", "2", "--out", "t.parquet"]);
    assert!(again.contains("0 runs done, 8 were there"), "{again}");
    let more = succeed(&folder, &["--scenarios", "3", "--out", "t.parquet"]);
    assert!(more.contains("4 runs done, 8 were there"), "{more}");
    // The same names under other settings are other runs.
    let other = [
        "--robot",
        "quadrotor",
        "--methods",
        "cn_cbf",
        "--people",
        "3",
        "--scenarios",
        "1",
        "--out",
        "t.parquet",
    ];
    let output = evaluate(&folder, &other);
    let told = text(&output.stderr);
    assert!(output.status.code() == Some(2) && told.contains("settings") && told.contains("--out"), "{told}");
}

#[test]
fn columns_stand_in_line_whatever_methods_are_called() {
    let folder = scratch("columns");
    let methods =
        ["--robot", "quadrotor", "--methods", "no_filter,cn_cbf_onboard_difference", "--people", "3"];
    let output = evaluate(&folder, &[&methods[..], &SHORT, &["--scenarios", "1"]].concat());
    let shown = text(&output.stdout);
    let widths: Vec<usize> = shown.lines().map(|line| line.chars().count()).collect();
    assert!(widths.len() == 3 && widths.iter().all(|width| *width == widths[0]), "{shown}");
}

/// Waits until the table of `child` has a part.
fn until_something_is_done(folder: &Path, child: &mut Child) {
    for _ in 0..6_000 {
        let parts = std::fs::read_dir(folder.join("t.parquet.parts")).into_iter().flatten().flatten();
        let whole = parts.filter(|part| part.path().extension().is_some_and(|ending| ending == "parquet"));
        if whole.count() > 0 {
            return;
        }
        assert!(child.try_wait().expect("a child").is_none(), "it ended before anything was done");
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("nothing was done within a minute");
}

/// Begins more runs than can be done at once.
fn begin(folder: &Path) -> Child {
    let methods = ["--robot", "quadrotor", "--methods", "cn_cbf", "--people", "6", "--scenarios", "1000"];
    let arguments = [&methods[..], &["--out", "t.parquet", "--jobs", "1"]].concat();
    command(folder, &arguments)
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .expect("the command starts")
}

/// Goes on with the first few of them; what was said.
fn go_on(folder: &Path) -> String {
    let methods = ["--robot", "quadrotor", "--methods", "cn_cbf", "--people", "6", "--scenarios", "2"];
    let output = evaluate(folder, &[&methods[..], &["--out", "t.parquet"]].concat());
    let told = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{told}");
    told
}

#[test]
fn what_a_kill_leaves_is_gone_on_with() {
    let folder = scratch("killed");
    let mut child = begin(&folder);
    until_something_is_done(&folder, &mut child);
    child.kill().expect("a child to kill");
    child.wait().expect("a child to wait for");
    let told = go_on(&folder);
    assert!(!told.contains("2 runs done"), "{told}");
    assert!(folder.join("t.parquet").exists() && !folder.join("t.parquet.parts").exists());
}

#[test]
fn an_interrupt_ends_soon_and_says_how_to_go_on() {
    let folder = scratch("interrupted");
    let mut child = begin(&folder);
    until_something_is_done(&folder, &mut child);
    let pid = rustix::process::Pid::from_child(&child);
    rustix::process::kill_process(pid, rustix::process::Signal::INT).expect("a child to interrupt");
    let status = child.wait().expect("a child to wait for");
    let mut told = String::new();
    child.stderr.take().expect("piped").read_to_string(&mut told).expect("text");
    assert!(status.code() == Some(1) && told.contains("the same command goes on"), "{told}");
    assert!(!go_on(&folder).contains("2 runs done"));
}

#[test]
fn what_cannot_work_is_refused_before_anything_is_computed() {
    let folder = scratch("refused");
    std::fs::write(folder.join("bad.json"), "{\"format\": \"cncbf-scenarios/1\", \"scenarios\": [{}]}")
        .expect("a file");
    std::fs::write(folder.join("no.parquet"), "this is no table").expect("a file");
    std::fs::write(folder.join("quadrotor.toml"), include_str!("../config/quadrotor.toml")).expect("a file");
    for (arguments, words) in [
        (&["--methods", "nonsense"][..], &["nonsense", "sdf_mpc", "cn_cbf"][..]),
        (&["--methods", "c3bf"], &["ground"]),
        (&["--methods", "cn_cbf,cn_cbf"], &["twice"]),
        (&["--methods", "mine=nowhere.toml"], &["nowhere.toml"]),
        (&["--methods", "mine=quadrotor.toml"], &["quadrotor.toml", "ground"]),
        (&["--scenarios", "bad.json"], &["bad.json"]),
        (&["--scenarios", "nowhere.json"], &["nowhere.json"]),
        (&["--scenarios", "bad.json", "--people", "5"], &["--people"]),
        (&["--scenarios", "0"], &["at least one"]),
        (&["--seed", "18446744073709551615"], &["--seed"]),
        (&["--set", "filter.beta=4"], &["beta"]),
        (&["--set", "filter"], &["section.key=value"]),
        (&["--partition", "slice:3/2"], &["slice:i/n"]),
        (&["--jobs", "0"], &["--jobs"]),
        (&["--out", "no/such/folder/t.parquet"], &["no/such/folder", "--out"]),
        (&["--out", "no.parquet"], &["no.parquet"]),
        (&["--report", "no.parquet"], &["--report"]),
        (&["--merge", "nowhere.parquet", "--out", "all.parquet"], &["nowhere.parquet"]),
        (&["--merge", "no.parquet"], &["--out"]),
    ] {
        let output = evaluate(&folder, arguments);
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
        for word in words {
            assert!(told.contains(word), "{arguments:?} lacks {word}: {told}");
        }
    }
    let output = command(&folder, &[]).env("JOB_COMPLETION_INDEX", "0").output().expect("the command starts");
    assert!(output.status.code() == Some(2) && text(&output.stderr).contains("JOB_COMPLETION_COUNT"));
    assert!(!folder.join("evaluation_ground.parquet").exists() && !folder.join("all.parquet").exists());
}

#[test]
fn scenarios_of_a_file_are_run_by_their_names() {
    let folder = scratch("file");
    std::fs::write(folder.join("mine.json"), include_str!("data/evaluate_scenarios.json")).expect("a file");
    let arguments =
        ["--methods", "cn_cbf", "--scenarios", "mine.json", "--out", "t.parquet", "--report", "r"];
    let output = evaluate(&folder, &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("2 runs done"), "{}", text(&output.stderr));
    // The same names with other contents are other scenarios.
    let moved = include_str!("data/evaluate_scenarios.json").replace("\"seed\": 7", "\"seed\": 8");
    std::fs::write(folder.join("mine.json"), moved).expect("a file");
    let output = evaluate(&folder, &arguments);
    assert!(output.status.code() == Some(2) && text(&output.stderr).contains("another scenario"));
}

#[test]
fn the_files_for_clusters_say_what_the_program_understands() {
    let read = |name: &str| {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("deploy").join(name);
        std::fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
    };
    for script in ["evaluate.sbatch", "merge.sh"] {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("deploy").join(script);
        let parsed = Command::new("bash").arg("-n").arg(&file).status().expect("bash starts");
        assert!(parsed.success(), "{script}");
    }
    let array = read("evaluate.sbatch");
    assert!(array.lines().any(|line| line.starts_with("#SBATCH --array=1-")));
    let job = read("evaluate.yaml");
    let value = |key: &str| {
        let line = job.lines().find_map(|line| line.trim().strip_prefix(key)).unwrap_or_default();
        line.trim().trim_matches('"').to_owned()
    };
    assert!(job.contains("completionMode: Indexed") && job.contains("name: JOB_COMPLETION_COUNT"));
    assert!(!value("completions:").is_empty() && value("completions:") == value("value:"), "{job}");
    assert!(!job.contains('\t'), "YAML is indented with spaces");
    let help = text(&evaluate(Path::new("."), &["--help"]).stdout);
    for file in [array, job, read("merge.sh")] {
        let options =
            file.split(|c: char| c.is_whitespace() || c == '"').filter(|word| word.starts_with("--"));
        for option in options.filter(|option| !file.contains(&format!("#SBATCH {option}"))) {
            let option = option.split('=').next().unwrap_or_default();
            assert!(help.contains(option) || option == "--array", "{option} is no option of evaluate");
        }
    }
}
