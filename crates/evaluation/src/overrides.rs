//! Single keys of a settings file, changed from outside: `section.key=value`.

use std::path::Path;

use settings::SettingsError;
use toml::{Table, Value};

/// Why an override cannot be applied.
#[derive(Debug, thiserror::Error)]
pub enum OverrideError {
    /// It is not of the form `section.key=value`, or the value is no TOML.
    #[error(
        "`{0}` is no setting; write it as in a settings file: section.key=value, such as nominal.period_ms=50"
    )]
    Malformed(String),
    /// A part of the path names a value, not a table.
    #[error("`{text}`: {part} is a value and has no keys of its own")]
    NoTable {
        /// The override.
        text: String,
        /// The part.
        part: String,
    },
    /// The settings themselves are no TOML.
    #[error(transparent)]
    Settings(#[from] SettingsError),
}

/// `text`, a settings file, with each of `sets` applied in turn. Whether a key is known is said when it is parsed.
pub(crate) fn overridden(text: &str, origin: &Path, sets: &[&str]) -> Result<String, OverrideError> {
    let mut table: Table = toml::from_str(text)
        .map_err(|source| SettingsError::Parse { path: origin.to_owned(), source: Box::new(source) })?;
    for set in sets {
        apply(&mut table, set)?;
    }
    toml::to_string(&table).map_err(|source| SettingsError::Write { source: Box::new(source) }.into())
}

fn apply(table: &mut Table, set: &str) -> Result<(), OverrideError> {
    let malformed = || OverrideError::Malformed(set.to_owned());
    let (path, value) = set.split_once('=').ok_or_else(malformed)?;
    let parsed: Table = toml::from_str(&format!("value = {value}")).map_err(|_| malformed())?;
    let value = parsed.get("value").cloned().ok_or_else(malformed)?;
    let parts: Vec<&str> = path.split('.').map(str::trim).collect();
    let (key, sections) = parts.split_last().ok_or_else(malformed)?;
    if sections.is_empty() || parts.iter().any(|part| part.is_empty()) {
        return Err(malformed());
    }
    let mut table = table;
    for &section in sections {
        table = match table.entry(section).or_insert_with(|| Value::Table(Table::new())) {
            Value::Table(inner) => inner,
            _ => return Err(OverrideError::NoTable { text: set.to_owned(), part: section.to_owned() }),
        };
    }
    table.insert((*key).to_owned(), value);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change(set: &str) -> Result<String, OverrideError> {
        overridden("[a]\nx = 1\n[a.b]\ny = [1.0]\n", "test.toml".as_ref(), &[set])
    }

    #[test]
    fn keys_are_replaced_and_added_at_any_depth() {
        let text = change("a.b.y=[2.0, 3.0]").expect("a setting");
        assert!(text.contains("y = [2.0, 3.0]") && text.contains("x = 1"), "{text}");
        assert!(change("a.c.new=\"word\"").expect("a setting").contains("new = \"word\""));
    }

    #[test]
    fn what_is_no_setting_is_refused() {
        for wrong in ["a.x", "x=1", "a..x=1", "a.x=", "a.x=word", "=1"] {
            assert!(matches!(change(wrong), Err(OverrideError::Malformed(_))), "{wrong}");
        }
        assert!(matches!(change("a.x.deep=1"), Err(OverrideError::NoTable { .. })));
    }
}
