//! What is committed under `bindings/` is what the sources of `messages` say, and other compilers agree with it.

#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use std::{
    path::{Path, PathBuf},
    process::Command,
};

use bindings::{C_HEADER, C_PORTS_HEADER, PYTHON_MODULE, ReadError, Schema, generate, schema};
use messages::{
    Controller, Cycle, Detections, Goal, Health, MAX_OBSTACLES, Message, NominalCommand, Obstacles,
    RealtimeFlags, Reason, RobotState, SafeCommand, SourceStatus,
};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn sources() -> PathBuf {
    root().join("crates/messages/src")
}

/// Whether `program` runs at all; says so where it does not.
fn have(program: &str) -> bool {
    let runs = Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success());
    if !runs {
        println!("skipped: no `{program}` on this machine");
    }
    runs
}

fn succeeds(command: &mut Command) {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn the_committed_files_are_what_the_generator_writes() {
    for (path, text) in generate(&root()).unwrap() {
        let committed = std::fs::read_to_string(root().join(path)).unwrap_or_default();
        assert!(committed == text, "{path} is not up to date; run `cargo run -p bindings` and commit");
    }
}

/// Asserts that the generator saw what the compiler made of `T`.
fn agrees<T: Message>(schema: &Schema, name: &str) {
    let found = schema.structs.iter().find(|structure| structure.name == name).unwrap();
    assert_eq!(
        (found.size, found.type_name.as_str(), found.service.as_deref()),
        (size_of::<T>() as u64, T::TYPE_NAME, Some(T::SERVICE)),
        "{name}"
    );
}

#[test]
fn the_generator_sees_what_the_compiler_sees() {
    let schema = schema(&sources()).unwrap();
    agrees::<RobotState>(&schema, "RobotState");
    agrees::<Detections>(&schema, "Detections");
    agrees::<Obstacles>(&schema, "Obstacles");
    agrees::<Goal>(&schema, "Goal");
    agrees::<NominalCommand>(&schema, "NominalCommand");
    agrees::<SafeCommand>(&schema, "SafeCommand");
    agrees::<SourceStatus>(&schema, "SourceStatus");
    agrees::<Health>(&schema, "Health");
    agrees::<Cycle>(&schema, "Cycle");
    let travelling = schema.structs.iter().filter(|structure| structure.service.is_some());
    assert_eq!(travelling.count(), 9, "a new message is to be added here");
    assert_eq!(schema.max_obstacles, MAX_OBSTACLES as u64);
    let choices = |name: &str| &schema.codes.iter().find(|codes| codes.name == name).unwrap().choices;
    let seen: Vec<_> = choices("Reason").iter().map(|choice| (choice.code, choice.label.as_str())).collect();
    let said: Vec<_> = Reason::ALL.iter().map(|reason| (u64::from(reason.code()), reason.label())).collect();
    assert_eq!(seen, said);
    assert_eq!(choices("Controller").len(), Controller::ALL.len());
    let bits = &schema.flags.iter().find(|flags| flags.name == "RealtimeFlags").unwrap().choices;
    assert!(
        bits.iter().any(|bit| bit.name == "MEMORY_LOCK" && bit.code == u64::from(RealtimeFlags::MEMORY_LOCK))
    );
}

#[test]
fn a_label_is_its_name_in_small_letters_as_python_makes_it() {
    for codes in schema(&sources()).unwrap().codes {
        for choice in codes.choices {
            assert_eq!(choice.label.replace('_', ""), choice.name.to_lowercase(), "{}", codes.name);
        }
    }
}

/// A copy of the sources in which `from` reads `to`.
fn changed(file: &str, from: &str, to: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(sources()).unwrap().flatten() {
        std::fs::copy(entry.path(), folder.path().join(entry.file_name())).unwrap();
    }
    let path = folder.path().join(file);
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{file} holds no `{from}`");
    std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
    folder
}

#[test]
fn what_other_languages_would_lay_out_differently_is_refused() {
    // The last field, narrowed: offsets and size stay, with padding behind it.
    let padded = changed("goal.rs", "pub heading_rad: f64", "pub heading_rad: u32");
    let foreign = changed("robot_state.rs", "pub yaw_rate_radps: f64", "pub yaw_rate_radps: bool");
    let moved = changed("goal.rs", "heading_rad: 56", "heading_rad: 40");
    for folder in [padded, foreign, moved] {
        let error = schema(folder.path()).unwrap_err();
        assert!(matches!(error, ReadError::Unfit { .. }), "{error}");
    }
    let renamed = changed("lib.rs", "mod goal;", "mod aim;");
    assert!(matches!(schema(renamed.path()), Err(ReadError::File { .. })));
}

#[test]
fn c_and_cpp_compilers_agree_with_every_offset() {
    let header = root().join(C_HEADER);
    for (compiler, standard) in [("cc", "-std=c11"), ("c++", "-std=c++11")] {
        if !have(compiler) {
            continue;
        }
        let folder = tempfile::tempdir().unwrap();
        let language = if compiler == "cc" { "c" } else { "c++" };
        let check = |text: &str| {
            let source = folder.path().join("check");
            std::fs::write(&source, text).unwrap();
            let mut command = Command::new(compiler);
            command.args([
                standard,
                "-Wall",
                "-Wextra",
                "-Werror",
                "-pedantic",
                "-fsyntax-only",
                "-x",
                language,
            ]);
            command.arg(&source);
            command
        };
        let text = std::fs::read_to_string(&header).unwrap();
        let uses = "const char *label(void) { return cncbf_reason_label(CNCBF_REASON_NO_GOAL); }\n";
        succeeds(&mut check(&format!("{text}\nconst char *label(void);\n{uses}")));
        let moved =
            text.replacen("    double position_in_odom_m[2];", "    double position_in_odom_m[3];", 1);
        assert!(
            moved != text && !check(&moved).output().unwrap().status.success(),
            "a moved field was not noticed"
        );
    }
}

#[test]
fn c_and_cpp_compilers_read_the_header_of_the_ports() {
    for (compiler, language, standard) in [("cc", "c", "-std=c11"), ("c++", "c++", "-std=c++11")] {
        if !have(compiler) {
            continue;
        }
        let flags = ["-Wall", "-Wextra", "-Werror", "-pedantic", "-fsyntax-only", "-x", language, standard];
        let folder = tempfile::tempdir().unwrap();
        let source = folder.path().join("reads");
        let uses = "cncbf_result_t send(cncbf_nominal_t *place, const cncbf_nominal_command_t *command);\n\
            cncbf_result_t send(cncbf_nominal_t *place, const cncbf_nominal_command_t *command)\n\
            { return cncbf_nominal_send(place, command); }\n";
        let header = root().join(C_PORTS_HEADER).canonicalize().unwrap();
        std::fs::write(&source, format!("#include \"{}\"\n{uses}", header.display())).unwrap();
        succeeds(Command::new(compiler).args(flags).arg(&source));
    }
    let text = std::fs::read_to_string(root().join(C_PORTS_HEADER)).unwrap();
    assert!(
        text.contains("CNCBF_RESULT_TAKEN") && !text.contains("# Safety") && !text.contains("[`"),
        "{text}"
    );
}

#[test]
fn python_agrees_with_every_offset() {
    if !have("python3") {
        return;
    }
    let module = root().join(PYTHON_MODULE);
    let import = |file: &Path| {
        let mut command = Command::new("python3");
        command.args(["-B", "-O", "-c", "import runpy, sys; runpy.run_path(sys.argv[1])"]).arg(file);
        command
    };
    succeeds(&mut import(&module));
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(&module).unwrap();
    let moved = text.replacen("(\"heading_rad\", ctypes.c_double)", "(\"heading_rad\", ctypes.c_float)", 1);
    let file = folder.path().join("moved.py");
    std::fs::write(&file, &moved).unwrap();
    let output = import(&file).output().unwrap();
    assert!(moved != text && String::from_utf8_lossy(&output.stderr).contains("laid out differently"));
}
