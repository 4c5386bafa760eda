//! The C header, which C++ reads too.

use std::fmt::Write;

use crate::{Codes, Field, FieldType, Schema, Struct, docs::unlinked, names};

const HEAD: &str = r#"/* Wire types of cncbf: what travels between its processes through iceoryx2's shared memory.
 *
 * Generated from crates/messages by `cargo run -p bindings`; do not edit.
 *
 * The full name of a service is the stack's name, a slash and the service's name, for example "cncbf/robot_state". When a
 * port is opened, state the type name, sizeof the structure and an alignment of 8; iceoryx2 compares them.
 *
 * Fields that end in _ns are nanoseconds, all but source_ns on the stack clock, which is CLOCK_MONOTONIC; 0 means never.
 * odom is the fixed, locally continuous world frame; base is the robot's own, x forward, y left.
 */
#ifndef CNCBF_MESSAGES_H
#define CNCBF_MESSAGES_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
#define CNCBF_STATIC_ASSERT(condition, text) static_assert(condition, text)
#else
#define CNCBF_STATIC_ASSERT(condition, text) _Static_assert(condition, text)
#endif

"#;

/// The whole file.
pub(crate) fn text(schema: &Schema) -> String {
    let mut text = HEAD.to_owned();
    let mut put = |part: &str| text.push_str(part);
    put("/* Obstacles that one message can carry. */\n");
    put(&format!("#define CNCBF_MAX_OBSTACLES {}\n", schema.max_obstacles));
    for codes in &schema.codes {
        put(&enumeration(codes, schema));
        put(&labels(codes));
    }
    for flags in &schema.flags {
        put(&enumeration(flags, schema));
    }
    for structure in &schema.structs {
        put(&definition(structure, schema));
    }
    put("\n#endif /* CNCBF_MESSAGES_H */\n");
    text
}

/// Name of a structure in C.
fn type_name(name: &str) -> String {
    format!("cncbf_{}_t", names::snake(name))
}

fn constant(of: &str, name: &str) -> String {
    format!("CNCBF_{}_{}", names::screaming(of), names::screaming(name))
}

fn comment(doc: &[String], indent: &str, schema: &Schema) -> String {
    let named = |parts: &[&str]| match parts {
        [of, name] => constant(of, name),
        [name] if schema.structs.iter().any(|structure| structure.name == *name) => type_name(name),
        [name] if *name == "MAX_OBSTACLES" => "CNCBF_MAX_OBSTACLES".to_owned(),
        [name] => format!("cncbf_{}", names::snake(name)),
        other => other.join("::"),
    };
    let lines: Vec<String> = doc.iter().map(|line| unlinked(line, named)).collect();
    let mut text = String::new();
    for (index, line) in lines.iter().enumerate() {
        let begin = if index == 0 { "/*" } else { " *" };
        let end = if index + 1 == lines.len() { " */" } else { "" };
        let space = if line.is_empty() { "" } else { " " };
        let _ = writeln!(text, "{indent}{begin}{space}{line}{end}");
    }
    text
}

fn enumeration(codes: &Codes, schema: &Schema) -> String {
    let mut text =
        format!("\n{}enum cncbf_{} {{\n", comment(&codes.doc, "", schema), names::snake(&codes.name));
    for (index, choice) in codes.choices.iter().enumerate() {
        let comma = if index + 1 == codes.choices.len() { "" } else { "," };
        text += &comment(&choice.doc, "    ", schema);
        let _ = writeln!(text, "    {} = {}{comma}", constant(&codes.name, &choice.name), choice.code);
    }
    text + "};\n"
}

/// A function that names a code.
fn labels(codes: &Codes) -> String {
    let snake = names::snake(&codes.name);
    let mut text = format!(
        "\n/* Name of a code as logs and reports write it; \"?\" for a code that this version does not know. */\n\
         static inline const char *cncbf_{snake}_label(uint32_t code)\n{{\n    switch (code) {{\n"
    );
    for choice in &codes.choices {
        let _ =
            writeln!(text, "    case {}: return \"{}\";", constant(&codes.name, &choice.name), choice.label);
    }
    text + "    default: return \"?\";\n    }\n}\n"
}

fn definition(structure: &Struct, schema: &Schema) -> String {
    let name = type_name(&structure.name);
    let screaming = names::screaming(&structure.name);
    let mut text = format!("\n{}typedef struct {{\n", comment(&structure.doc, "", schema));
    for field in &structure.fields {
        text += &comment(&field.doc, "    ", schema);
        let _ = writeln!(text, "    {};", declaration(field));
    }
    let _ = writeln!(text, "}} {name};\n");
    let _ = writeln!(text, "#define CNCBF_{screaming}_TYPE_NAME \"{}\"", structure.type_name);
    if let Some(service) = &structure.service {
        let _ = writeln!(text, "#define CNCBF_{screaming}_SERVICE \"{service}\"");
    }
    let _ = writeln!(text, "CNCBF_STATIC_ASSERT(sizeof({name}) == {}, \"size of {name}\");", structure.size);
    for field in &structure.fields {
        let field_name = names::field(&field.name);
        let _ = writeln!(
            text,
            "CNCBF_STATIC_ASSERT(offsetof({name}, {field_name}) == {}, \"{name}.{field_name}\");",
            field.offset
        );
    }
    text
}

fn declaration(field: &Field) -> String {
    let (mut of, mut counts) = (&field.field_type, String::new());
    while let FieldType::Array(inner, count) = of {
        let _ = write!(counts, "[{count}]");
        of = inner;
    }
    let of = match of {
        FieldType::U32 => "uint32_t".to_owned(),
        FieldType::U64 => "uint64_t".to_owned(),
        FieldType::F64 => "double".to_owned(),
        FieldType::Struct(name) => type_name(name),
        FieldType::Array(..) => unreachable!("taken off above"),
    };
    format!("{of} {}{counts}", names::field(&field.name))
}
