//! Whether two definitions of a type put the same bytes on the wire.
//!
//! Packages change their messages without renaming them, and a recording carries the definition it was written with.
//! Reading such a message by today's definition gives garbage that decodes. Field names do not matter here, types and
//! their order do.

use std::collections::HashMap;

/// Deeper nesting than any real message has; a definition that uses itself ends here.
const MAX_DEPTH: usize = 32;

/// The primitives a `ros2msg` definition comes down to, in order, for example `int32,uint32,string,`.
///
/// `None` if the definition uses a type it does not define, or uses itself.
pub(crate) fn wire_signature(root_name: &str, definition: &str) -> Option<String> {
    let mut sections = HashMap::new();
    let mut name = root_name.replace("/msg/", "/");
    let mut fields = Vec::new();
    for line in definition.lines() {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.len() >= 3 && line.bytes().all(|byte| byte == b'=') {
            sections.insert(std::mem::take(&mut name), std::mem::take(&mut fields));
        } else if let Some(next) = line.strip_prefix("MSG:") {
            name = next.trim().replace("/msg/", "/");
        } else if let Some(kind) = field_type(line) {
            fields.push(kind);
        }
    }
    sections.insert(name, fields);
    let mut signature = String::new();
    flatten(&root_name.replace("/msg/", "/"), &sections, &mut signature, 0)?;
    Some(signature)
}

/// Type of the field that a line declares; `None` for blank lines and constants.
fn field_type(line: &str) -> Option<&str> {
    let (kind, rest) = line.split_once(char::is_whitespace)?;
    let is_constant = rest.contains('=');
    (!is_constant).then_some(kind)
}

fn flatten(
    name: &str,
    sections: &HashMap<String, Vec<&str>>,
    signature: &mut String,
    depth: usize,
) -> Option<()> {
    if depth > MAX_DEPTH {
        return None;
    }
    for kind in sections.get(name)? {
        let (element, array) = kind.find('[').map_or((*kind, ""), |at| kind.split_at(at));
        let element = element.split("<=").next().unwrap_or_default();
        if is_primitive(element) {
            *signature += element;
        } else {
            let child = qualified(element, name);
            signature.push('(');
            flatten(&child, sections, signature, depth + 1)?;
            signature.push(')');
        }
        // A bound changes nothing on the wire; a fixed length does.
        *signature += if array.starts_with("[<=") { "[]" } else { array };
        signature.push(',');
    }
    Some(())
}

fn is_primitive(kind: &str) -> bool {
    const PRIMITIVES: [&str; 15] = [
        "bool", "byte", "char", "float32", "float64", "int8", "uint8", "int16", "uint16", "int32", "uint32",
        "int64", "uint64", "string", "wstring",
    ];
    PRIMITIVES.contains(&kind)
}

/// Full name of a type used in a definition of `user`'s package.
fn qualified(kind: &str, user: &str) -> String {
    let kind = kind.replace("/msg/", "/");
    if kind.contains('/') {
        kind
    } else if kind == "Header" {
        "std_msgs/Header".to_owned()
    } else {
        let package = user.split('/').next().unwrap_or_default();
        format!("{package}/{kind}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ros2::{Odometry, PoseArray, Ros2Message};

    #[test]
    fn comments_names_constants_and_bounds_do_not_matter() {
        let written = "# a comment\nHeader header  # trailing\nint32 LIMIT=3\nPose[] poses_of_people\n===\n\
                       MSG: geometry_msgs/msg/Pose\nPoint p\nQuaternion q\n===\nMSG: geometry_msgs/Point\nfloat64 a\n\
                       float64 b\nfloat64 c\n===\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\n\
                       float64 w\n===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n===\n\
                       MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
        let ours = wire_signature(PoseArray::NAME, &PoseArray::definition());
        assert!(ours.is_some());
        assert_eq!(wire_signature("geometry_msgs/msg/PoseArray", written), ours);
    }

    #[test]
    fn another_field_order_or_length_is_another_signature() {
        let ours = Odometry::definition();
        let moved = ours.replacen("string child_frame_id\n", "", 1) + "string child_frame_id\n";
        let shorter = ours.replace("float64[36]", "float64[9]");
        let signature = wire_signature(Odometry::NAME, &ours);
        assert!(signature.is_some());
        for other in [moved, shorter] {
            assert_ne!(wire_signature(Odometry::NAME, &other), signature);
        }
    }

    #[test]
    fn a_definition_that_uses_itself_or_the_unknown_has_no_signature() {
        assert_eq!(wire_signature("a/B", "a/B self\n"), None);
        assert_eq!(wire_signature("a/B", "a/C other\n"), None);
    }
}
