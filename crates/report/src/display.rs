//! Numbers as people read them.

use core::fmt::Display;

/// A dash for what is unknown.
pub(crate) const UNKNOWN: &str = "unknown";

/// `value` with its unit, or "unknown".
pub(crate) fn or_unknown(value: Option<impl Display>, unit: &str) -> String {
    value.map_or_else(|| UNKNOWN.to_owned(), |value| format!("{value:.3}{unit}"))
}

/// A number with `digits` decimals, infinities by their sign.
pub(crate) fn number(value: f64, digits: usize) -> String {
    if value == f64::INFINITY {
        "∞".to_owned()
    } else if value == f64::NEG_INFINITY {
        "-∞".to_owned()
    } else {
        format!("{value:.digits$}")
    }
}

/// A share of 1 in percent.
pub(crate) fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}
