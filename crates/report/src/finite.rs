//! JSON has no infinity: values that are not finite become `null` and come back as `None`.

use serde::Serializer;

/// The value, or nothing if it is infinite or NaN.
pub(crate) fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// `value` with `digits` decimals, or nothing if it is not finite. Keeps embedded data short.
pub(crate) fn rounded(value: f64, digits: i32) -> Option<f64> {
    let scale = 10f64.powi(digits);
    finite(value).map(|value| (value * scale).round() / scale + 0.0)
}

/// Serialises a number that may be infinite.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde's `serialize_with` passes a reference")]
pub(crate) fn or_null<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    serde::Serialize::serialize(&finite(*value), serializer)
}
