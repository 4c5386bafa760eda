//! Processes in JSON: by their names.

use messages::ProcessId;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serializer};

/// The process of that name.
pub(crate) fn named(name: &str) -> Option<ProcessId> {
    ProcessId::ALL.iter().copied().find(|process| process.label() == name)
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde's `with` passes a reference")]
pub(crate) fn serialize<S: Serializer>(process: &ProcessId, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(process.label())
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<ProcessId, D::Error> {
    let name = String::deserialize(deserializer)?;
    named(&name).ok_or_else(|| D::Error::custom(format!("there is no process named {name:?}")))
}
