//! The Python module: ctypes structures, checked when they are imported.

use std::fmt::Write;

use crate::{Codes, FieldType, Schema, Struct, docs::unlinked, names};

const HEAD: &str = r#""""Wire types of cncbf: what travels between its processes through iceoryx2's shared memory.

Generated from crates/messages by `cargo run -p bindings`; do not edit.

Fields that end in `_ns` are nanoseconds, all but `source_ns` on the stack clock, which is `time.monotonic_ns()`; 0 means
never. `odom` is the fixed, locally continuous world frame; `base` is the robot's own, x forward, y left. Numbers in
brackets after a field's name are how many values it holds.
"""

from __future__ import annotations

import ctypes
import enum


class Code(enum.IntEnum):
    """A code on the wire."""

    @property
    def label(self) -> str:
        """The name in logs and reports."""
        return self.name.lower()


def label_of(codes: type[Code], code: int) -> str:
    """The name of a code in logs and reports; `?` for one that this version does not know."""
    try:
        return codes(code).label
    except ValueError:
        return "?"


def _laid_out(structure: type[ctypes.Structure], size: int, offsets: dict[str, int]) -> None:
    """Refuses the import where this Python lays a structure out differently from the processes."""
    fields = {name: getattr(structure, name) for name, *_ in structure._fields_}
    found = {name: field.offset for name, field in fields.items()}
    whole = (ctypes.sizeof(structure), ctypes.alignment(structure), sum(field.size for field in fields.values()))
    if whole != (size, 8, size) or found != offsets:
        raise ImportError(f"{structure.__name__} is laid out differently here: {found}, {whole[0]} bytes")

"#;

/// The whole file.
pub(crate) fn text(schema: &Schema) -> String {
    let mut text = HEAD.to_owned();
    let _ = writeln!(
        text,
        "\n#: Obstacles that one message can carry.\nMAX_OBSTACLES = {}",
        schema.max_obstacles
    );
    for codes in &schema.codes {
        text += &enumeration(codes, "Code");
    }
    for flags in &schema.flags {
        text += &enumeration(flags, "enum.IntFlag");
    }
    for structure in &schema.structs {
        text += &class(structure);
    }
    text + &services(schema)
}

fn plain(line: &str) -> String {
    unlinked(line, |parts| parts.join("."))
}

/// A docstring of the given lines and sections.
fn docstring(lines: &[String]) -> String {
    let [only] = lines else {
        let mut text = format!("    \"\"\"{}\n", lines[0]);
        for line in &lines[1..] {
            let indent = if line.is_empty() { "" } else { "    " };
            let _ = writeln!(text, "{indent}{line}");
        }
        return text + "    \"\"\"\n";
    };
    format!("    \"\"\"{only}\"\"\"\n")
}

fn enumeration(codes: &Codes, base: &str) -> String {
    let doc: Vec<String> = codes.doc.iter().map(|line| plain(line)).collect();
    let mut text = format!("\n\nclass {}({base}):\n{}\n", codes.name, docstring(&doc));
    for choice in &codes.choices {
        for line in &choice.doc {
            let _ = writeln!(text, "    #: {}", plain(line));
        }
        let _ = writeln!(text, "    {} = {}", names::screaming(&choice.name), choice.code);
    }
    text
}

fn class(structure: &Struct) -> String {
    let name = &structure.name;
    let mut doc: Vec<String> = structure.doc.iter().map(|line| plain(line)).collect();
    doc.extend([String::new(), "Fields:".to_owned()]);
    for field in &structure.fields {
        let mut counts = String::new();
        let mut of = &field.field_type;
        while let FieldType::Array(inner, count) = of {
            let _ = write!(counts, " [{count}]");
            of = inner;
        }
        let said: Vec<String> = field.doc.iter().map(|line| plain(line)).collect();
        doc.push(format!("    {}{counts}: {}", names::field(&field.name), said.join(" ")));
    }
    let mut text = format!("\n\nclass {name}(ctypes.Structure):\n{}\n", docstring(&doc));
    if let Some(service) = &structure.service {
        let _ = writeln!(text, "    SERVICE = \"{service}\"");
    }
    let _ = writeln!(text, "    TYPE_NAME = \"{}\"\n    _fields_ = [", structure.type_name);
    for field in &structure.fields {
        let _ =
            writeln!(text, "        (\"{}\", {}),", names::field(&field.name), field_type(&field.field_type));
    }
    text += "    ]\n\n";
    for field in &structure.fields {
        let _ = writeln!(text, "    {}: {}", names::field(&field.name), hint(&field.field_type));
    }
    text += "\n    @staticmethod\n    def type_name() -> str:\n        \"\"\"What iceoryx2 compares when a port is opened.\"\"\"\n";
    let offsets: Vec<String> = structure
        .fields
        .iter()
        .map(|field| format!("    \"{}\": {},\n", names::field(&field.name), field.offset))
        .collect();
    let _ = write!(
        text,
        "        return {name}.TYPE_NAME\n\n\n_laid_out({name}, {}, {{\n{}}})\n",
        structure.size,
        offsets.concat()
    );
    text
}

fn field_type(of: &FieldType) -> String {
    match of {
        FieldType::U32 => "ctypes.c_uint32".to_owned(),
        FieldType::U64 => "ctypes.c_uint64".to_owned(),
        FieldType::F64 => "ctypes.c_double".to_owned(),
        FieldType::Struct(name) => name.clone(),
        FieldType::Array(of, count) => format!("{} * {count}", field_type(of)),
    }
}

/// What a type checker is told that reading a field gives.
fn hint(of: &FieldType) -> String {
    match of {
        FieldType::U32 | FieldType::U64 => "int".to_owned(),
        FieldType::F64 => "float".to_owned(),
        FieldType::Struct(name) => name.clone(),
        FieldType::Array(of, _) => format!("ctypes.Array[{}]", field_type(of)),
    }
}

/// Everything that travels by itself, and everything there is.
fn services(schema: &Schema) -> String {
    let names = schema.structs.iter().filter(|structure| structure.service.is_some());
    let names: Vec<&str> = names.map(|structure| structure.name.as_str()).collect();
    let quoted = |name: &str| format!("    \"{name}\",\n");
    let mut all: Vec<&str> = vec!["MAX_OBSTACLES", "MESSAGES", "label_of"];
    all.extend(schema.codes.iter().chain(&schema.flags).map(|codes| codes.name.as_str()));
    all.extend(schema.structs.iter().map(|structure| structure.name.as_str()));
    all.sort_unstable();
    format!(
        "\n\n#: Every type that travels on a service of its own.\nMESSAGES = ({})\n\n__all__ = [\n{}]\n",
        names.join(", "),
        all.into_iter().map(quoted).collect::<String>()
    )
}
