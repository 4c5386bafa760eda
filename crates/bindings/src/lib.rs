//! The wire types for other languages: reads the sources of `messages` and writes a C header and a Python module.
//!
//! [`schema`] reads, [`generate`] writes; `cargo run -p bindings` puts the result into `bindings/`. Offsets are computed here
//! by the rules of C and held against those that `messages` asserts at compile time, so that a header which disagrees with
//! the Rust compiler cannot be written; the generated code asserts them once more where it is compiled or imported.
//!
//! The header of the C ports is cbindgen's work, from the sources of `c_ports`. Python's ports are written by hand, on iceoryx2's
//! own client.

mod c_header;
mod docs;
mod layout;
mod names;
mod ports_header;
mod python_module;
mod read;
mod schema;

use std::path::Path;

pub use read::{ReadError, schema};
pub use schema::{Choice, Codes, Field, FieldType, Schema, Struct};

/// Path of the C header, from the root of the repository.
pub const C_HEADER: &str = "bindings/c/cncbf_messages.h";
/// Path of the C header of the ports, from the root of the repository.
pub const C_PORTS_HEADER: &str = "bindings/c/cncbf.h";
/// Path of the Python module, from the root of the repository.
pub const PYTHON_MODULE: &str = "bindings/python/src/cncbf/messages.py";

/// The generated files for the sources below `root`, the repository, as paths from there and contents.
///
/// # Errors
/// [`ReadError`] where the sources cannot be read or hold something that no other language could.
pub fn generate(root: &Path) -> Result<[(&'static str, String); 3], ReadError> {
    let schema = schema(&root.join("crates/messages/src"))?;
    Ok([
        (C_HEADER, c_header::text(&schema)),
        (C_PORTS_HEADER, ports_header::text(&root.join("crates/c_ports/src"))?),
        (PYTHON_MODULE, python_module::text(&schema)),
    ])
}
