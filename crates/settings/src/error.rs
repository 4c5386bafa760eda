//! What can be wrong with a settings file, and the checks that say so.

use std::path::PathBuf;

/// Why settings were refused.
#[derive(Debug, thiserror::Error)]
pub enum SettingsError {
    /// The file cannot be read.
    #[error("cannot read the settings file {}: {source}; check the path given with --config", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// No TOML, an unknown key, a missing key, or a value of the wrong type.
    #[error("{}: {source}", path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// What the parser says, with line and column.
        source: Box<toml::de::Error>,
    },
    /// A value out of its range.
    #[error("{key} = {value} is refused: it must be {requirement}")]
    Invalid {
        /// Full name of the key.
        key: String,
        /// The value found.
        value: String,
        /// What it should be.
        requirement: &'static str,
    },
    /// The settings cannot be written as TOML.
    #[error("the settings cannot be written as TOML: {source}")]
    Write {
        /// The serialiser's reason.
        source: Box<toml::ser::Error>,
    },
}

pub(crate) type Checked = Result<(), SettingsError>;

/// Refuses `value` unless `holds`.
pub(crate) fn require<V: core::fmt::Debug>(
    holds: bool,
    key: &'static str,
    value: V,
    requirement: &'static str,
) -> Checked {
    if holds { Ok(()) } else { Err(invalid(key, &value, requirement)) }
}

/// The refusal of `value`.
pub(crate) fn invalid<V: core::fmt::Debug>(key: &str, value: &V, requirement: &'static str) -> SettingsError {
    SettingsError::Invalid { key: key.to_owned(), value: format!("{value:?}"), requirement }
}

/// Refuses anything but a finite number > 0.
pub(crate) fn positive(key: &'static str, value: f64) -> Checked {
    require(value.is_finite() && value > 0.0, key, value, "finite and > 0")
}

/// Refuses anything but a finite number ≥ 0.
pub(crate) fn non_negative(key: &'static str, value: f64) -> Checked {
    require(value.is_finite() && value >= 0.0, key, value, "finite and >= 0")
}

/// Refuses a duration of zero.
pub(crate) fn positive_ms(key: &'static str, value: u64) -> Checked {
    require(value > 0, key, value, "at least 1 ms")
}

/// Refuses bounds that are not finite or where some minimum exceeds its maximum.
pub(crate) fn bounds(key: &'static str, min: &[f64], max: &[f64]) -> Checked {
    let ordered = min.iter().zip(max).all(|(lo, hi)| lo.is_finite() && hi.is_finite() && lo <= hi);
    require(
        ordered && min.len() == max.len(),
        key,
        (min, max),
        "finite, of equal length, each minimum <= its maximum",
    )
}
