//! The pure steps may not come to need more instructions than the stored baseline says.
//!
//! Times on a shared machine prove nothing within a build; counts by callgrind do. The baseline,
//! `tests/data/instructions.json`, holds for one compiler, C library and set of build flags, which it names; elsewhere
//! the comparison is refused in plain words. To renew it after a change that is worth its instructions:
//!
//! ```text
//! CNCBF_RENEW_INSTRUCTIONS=1 cargo test --test instructions
//! ```
//!
//! Callgrind is driven directly because the harnesses built on it (gungraun, formerly iai-callgrind) need a runner of
//! exactly their version installed beside the toolchain, and keep baselines as callgrind's own files, with the paths of
//! the machine in them, instead of numbers that a change can be reviewed by.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde::{Deserialize, Serialize};

/// Growth of a count that is taken for chance: another order of blocks, another alignment.
const TOLERANCE: f64 = 0.03;
const RENEW: &str = "CNCBF_RENEW_INSTRUCTIONS";
/// Callgrind collects inside this function of the program and dumps at its end. Written in two ways, because callgrind
/// keeps one option for each pattern.
const COLLECTED: &str = "*counted_step*";
const DUMPED: &str = "*::counted_step*";

/// What the counts depend on besides the code.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Environment {
    rustc: String,
    libc: String,
    /// Sorted; empty where nothing overrides the manifest.
    build_flags: Vec<String>,
}

#[derive(Debug, Serialize, Deserialize)]
struct Baseline {
    made_by: String,
    environment: Environment,
    instructions: BTreeMap<String, u64>,
}

/// Past the test harness, which keeps what a passing test prints to itself.
fn say(line: &str) {
    writeln!(std::io::stderr(), "{line}").expect("standard error is open");
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn baseline_path() -> PathBuf {
    root().join("tests/data/instructions.json")
}

/// What a program prints, if it is there and succeeds.
fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn environment() -> Environment {
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let sets_flags = |name: &str| {
        name == "RUSTFLAGS" || name == "CARGO_ENCODED_RUSTFLAGS" || name.starts_with("CARGO_PROFILE_RELEASE")
    };
    let mut build_flags: Vec<_> = std::env::vars()
        .filter(|(name, _)| sets_flags(name))
        .map(|(name, value)| format!("{name}={value}"))
        .collect();
    build_flags.sort();
    Environment {
        rustc: output(&rustc, &["--version"]).expect("the compiler that built this test says its version"),
        libc: output("getconf", &["GNU_LIBC_VERSION"]).unwrap_or_else(|| "unknown".to_owned()),
        build_flags,
    }
}

/// Builds the program to be counted as it is shipped, whatever profile this test has.
fn build() -> PathBuf {
    let status = Command::new(env!("CARGO"))
        .args([
            "build",
            "--release",
            "--locked",
            "--quiet",
            "--package",
            "cncbf",
            "--example",
            "instructions",
        ])
        .current_dir(root())
        .status()
        .expect("cargo runs");
    assert!(
        status.success(),
        "the example `instructions` does not build; run `cargo build --release --examples`"
    );
    let metadata = cargo_metadata::MetadataCommand::new()
        .manifest_path(root().join("Cargo.toml"))
        .no_deps()
        .other_options(["--offline".to_owned(), "--locked".to_owned()])
        .exec()
        .expect("cargo metadata runs");
    metadata.target_directory.join("release/examples/instructions").into()
}

/// Runs the program under callgrind: the name of each step and the instructions it took.
fn count(program: &Path) -> BTreeMap<String, u64> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let counts = folder.path().join("counts");
    let run = Command::new("valgrind")
        .args(["--tool=callgrind", "--quiet"])
        .arg(format!("--callgrind-out-file={}", counts.display()))
        .arg(format!("--toggle-collect={COLLECTED}"))
        .arg(format!("--dump-after={DUMPED}"))
        .arg(program)
        .output()
        .expect("valgrind runs");
    assert!(run.status.success(), "callgrind failed: {}", String::from_utf8_lossy(&run.stderr));
    let names = String::from_utf8_lossy(&run.stdout);
    let dumps = names.lines().enumerate().map(|(index, name)| {
        let path = counts.with_extension((index + 1).to_string());
        let dump = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{name}: {error}"));
        (name.to_owned(), instructions(&dump).unwrap_or_else(|| panic!("{name}: no total in {dump}")))
    });
    dumps.collect()
}

/// The total of a dump. Callgrind writes it at the end, and at the start where it knew it then.
fn instructions(dump: &str) -> Option<u64> {
    dump.lines().find_map(|line| line.strip_prefix("totals: "))?.trim().parse().ok()
}

/// One line per step, and whether any of them has grown beyond the tolerance, has gone or has no baseline.
fn compare(baseline: &BTreeMap<String, u64>, counted: &BTreeMap<String, u64>) -> (Vec<String>, bool) {
    let mut broken = false;
    let names: std::collections::BTreeSet<_> = baseline.keys().chain(counted.keys()).collect();
    let lines = names.into_iter().map(|name| match (baseline.get(name), counted.get(name)) {
        (Some(&before), Some(&now)) => {
            let change = now as f64 / before as f64 - 1.0;
            broken |= change > TOLERANCE;
            let verdict = if change > TOLERANCE {
                "  MORE THAN THE BASELINE ALLOWS"
            } else if change < -TOLERANCE {
                "  fewer: renew the baseline to keep the gain"
            } else {
                ""
            };
            format!("{name:<28} {before:>9} -> {now:>9}  {:+6.2} %{verdict}", 100.0 * change)
        }
        (Some(before), None) => {
            broken = true;
            format!("{name:<28} {before:>9} ->      none  NOT COUNTED HERE")
        }
        (None, now) => {
            broken = true;
            format!("{name:<28}      none -> {:>9}  NOT IN THE BASELINE", now.copied().unwrap_or_default())
        }
    });
    (lines.collect(), broken)
}

#[test]
fn no_step_needs_more_instructions_than_its_baseline() {
    if output("valgrind", &["--version"]).is_none() {
        say(
            "skipped: instructions are not counted without valgrind; install it (Debian: apt install valgrind)",
        );
        return;
    }
    let environment = environment();
    if std::env::var_os(RENEW).is_some() {
        let instructions = count(&build());
        let made_by = "tests/instructions.rs".to_owned();
        let text =
            serde_json::to_string_pretty(&Baseline { made_by, environment, instructions }).expect("JSON");
        std::fs::write(baseline_path(), text + "\n").expect("the baseline can be written");
        say(&format!("renewed: {}", baseline_path().display()));
        return;
    }
    let text = std::fs::read_to_string(baseline_path())
        .unwrap_or_else(|error| panic!("no baseline ({error}); make one with {RENEW}=1"));
    let baseline: Baseline = serde_json::from_str(&text).expect("the baseline is JSON of this test's own");
    if baseline.environment != environment {
        say(&format!(
            "skipped: the baseline of instructions holds for {:?}, this is {environment:?}; to compare here, check out \
             the commit to compare with, renew the baseline with {RENEW}=1, and come back",
            baseline.environment
        ));
        return;
    }
    let (lines, broken) = compare(&baseline.instructions, &count(&build()));
    let table = lines.join("\n");
    assert!(
        !broken,
        "instructions per step, baseline -> now:\n{table}\nIf the change is worth it, renew: \
         {RENEW}=1 cargo test --test instructions"
    );
    println!("{table}");
}

#[test]
fn growth_a_missing_step_and_a_new_step_are_told_from_chance() {
    let counts = |entries: &[(&str, u64)]| entries.iter().map(|(k, v)| ((*k).to_owned(), *v)).collect();
    let baseline: BTreeMap<_, _> = counts(&[("a", 1_000), ("b", 2_000)]);
    for (now, expected) in [
        (counts(&[("a", 1_029), ("b", 1_000)]), false),
        (counts(&[("a", 1_031), ("b", 2_000)]), true),
        (counts(&[("a", 1_000)]), true),
        (counts(&[("a", 1_000), ("b", 2_000), ("c", 1)]), true),
    ] {
        assert_eq!(compare(&baseline, &now).1, expected, "{now:?}");
    }
    assert_eq!(instructions("events: Ir\nfn=x\n1 2\ntotals: 42\n"), Some(42));
    assert_eq!(instructions("events: Ir\n"), None);
}
