//! The header of the C ports, written by cbindgen.

use std::path::Path;

use cbindgen::{Builder, Config, DocumentationStyle, EnumConfig, ExportConfig, Language, RenameRule};

use crate::ReadError;

const HEAD: &str = r"/* Ports of cncbf for C and C++: read what the processes of a running stack say, and take the nominal controller's place.
 *
 * Generated from crates/c_ports by `cargo run -p bindings`; do not edit.
 *
 * cargo build --release -p c_ports       makes target/release/libcncbf.a and libcncbf.so
 * cc controller.c -Ibindings/c target/release/libcncbf.a -lpthread -ldl -lm
 *
 * Ownership: what a function fills in belongs to the caller until it is closed, once. Messages and texts are copied.
 * Threads:   a handle is used by one thread at a time, whichever; different handles may be used at the same time.
 * Processes: a child that was forked must use no handle of its parent.
 * Time:      opening and closing take milliseconds and memory. _newest, _wait and _send allocate nothing, but for the first call after
 *            a peer has come or gone.
 * Signals:   the library installs no handler. A program that is told to stop closes its handles and ends.
 *
 * bindings/c/examples/pure_pursuit.c is a whole controller; docs/own_controller.md says what is asked of one. */";

/// What cbindgen makes of an enumeration's name, and what the other header's style is.
const VARIANTS: (&str, &str) = ("CNCBF_RESULT_T_", "CNCBF_RESULT_");

/// The whole file, of the sources in `ports_src`.
pub(crate) fn text(ports_src: &Path) -> Result<String, ReadError> {
    let unfit = |error: cbindgen::Error| ReadError::Unfit {
        name: "c_ports".to_owned(),
        what: format!("is not what cbindgen can write down ({error})"),
    };
    let sources = ["failure.rs", "handles.rs"].map(|name| ports_src.join(name));
    let builder = sources.iter().fold(Builder::new().with_config(config()), Builder::with_src);
    let mut written = Vec::new();
    builder.generate().map_err(unfit)?.write(&mut written);
    let text = String::from_utf8_lossy(&written).replace(VARIANTS.0, VARIANTS.1);
    Ok(without_safety(&text))
}

fn config() -> Config {
    let renamed = [
        ("Node", "cncbf_node_t"),
        ("Reader", "cncbf_reader_t"),
        ("Nominal", "cncbf_nominal_t"),
        ("Result", "cncbf_result_t"),
        ("NominalCommand", "cncbf_nominal_command_t"),
    ];
    Config {
        language: Language::C,
        cpp_compat: true,
        header: Some(HEAD.to_owned()),
        include_guard: Some("CNCBF_H".to_owned()),
        no_includes: true,
        sys_includes: vec!["stddef.h".to_owned(), "stdint.h".to_owned()],
        includes: vec!["cncbf_messages.h".to_owned()],
        usize_is_size_t: true,
        documentation_style: DocumentationStyle::C,
        line_length: 130,
        enumeration: EnumConfig {
            rename_variants: RenameRule::QualifiedScreamingSnakeCase,
            ..EnumConfig::default()
        },
        export: ExportConfig {
            rename: renamed.map(|(from, to)| (from.to_owned(), to.to_owned())).into(),
            ..ExportConfig::default()
        },
        ..Config::default()
    }
}

/// Leaves out what Rust's callers are told of safety: to a C programmer the head says it.
fn without_safety(text: &str) -> String {
    let mut kept: Vec<&str> = Vec::new();
    let mut skipping = false;
    for line in text.lines() {
        if line.trim() == "# Safety" {
            skipping = true;
            // The empty line before it.
            kept.pop();
        }
        skipping &= line.trim() != "*/";
        if !skipping {
            kept.push(line);
        }
    }
    kept.join("\n") + "\n"
}
