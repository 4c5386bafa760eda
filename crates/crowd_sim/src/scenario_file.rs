//! Files of scenarios: JSON in, JSON out. docs/scenarios.md describes the format.
//!
//! A file is somebody else's word: it is read up to a size, every list in it has a longest length, and what is wrong is said
//! with the file's, the scenario's and the field's name.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_path_to_error::Segment;

use crate::scenario::Scenario;
use crate::scenario_error::ScenarioError;

/// What the key `format` of a scenario file says.
pub const SCENARIO_FORMAT: &str = "cncbf-scenarios/1";

/// Largest file read, bytes: thousands of drawn scenarios, or dozens of minutes of tracks.
const MOST_BYTES: u64 = 64 << 20;
/// Scenarios that one file may have.
const MOST_SCENARIOS: usize = 100_000;
/// Names shown where one is missing.
const NAMES_SHOWN: usize = 5;

/// Why scenarios could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioFileError {
    /// The file cannot be read.
    #[error("cannot read the scenario file {}: {source}; check the path", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The operating system's reason.
        source: io::Error,
    },
    /// The file is larger than any that is read.
    #[error("{} is larger than {} MiB; split it into several scenario files", path.display(), MOST_BYTES >> 20)]
    TooLarge {
        /// The file.
        path: PathBuf,
    },
    /// The file is no JSON.
    #[error("{}: no valid JSON: {source}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// What the parser says, with line and column.
        source: serde_json::Error,
    },
    /// The file says that it is in another format, or does not say in which.
    #[error("{}: format is {found}; this program reads \"{SCENARIO_FORMAT}\"", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What stands there.
        found: String,
    },
    /// A field is missing, unknown or of the wrong type.
    #[error("{}: {scenario}: {field}: {source}; docs/scenarios.md lists the fields", path.display())]
    Field {
        /// The file.
        path: PathBuf,
        /// The scenario's name or, if it has none, its place.
        scenario: String,
        /// Path of the field in the scenario.
        field: String,
        /// What the parser says, with line and column.
        source: serde_json::Error,
    },
    /// A scenario makes no sense.
    #[error("{}: scenario {name}: {source}", path.display())]
    Scenario {
        /// The file.
        path: PathBuf,
        /// Name of the scenario.
        name: String,
        /// What is wrong with it.
        source: ScenarioError,
    },
    /// Two scenarios have the same name.
    #[error("{}: two scenarios are called {name}; give each its own name", path.display())]
    TwiceNamed {
        /// The file.
        path: PathBuf,
        /// The name.
        name: String,
    },
    /// There are no scenarios, or far too many.
    #[error("{}: {found} scenarios; 1 to {MOST_SCENARIOS} make a file", path.display())]
    Count {
        /// The file.
        path: PathBuf,
        /// How many there are.
        found: usize,
    },
    /// The scenario asked for is not there.
    #[error("{} has no scenario {name}; it has {known}", path.display())]
    NotThere {
        /// The file.
        path: PathBuf,
        /// What was asked for.
        name: String,
        /// Some of the names it has.
        known: String,
    },
    /// The file cannot be written.
    #[error("cannot write the scenario file {}: {source}; name another place", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The operating system's reason.
        source: io::Error,
    },
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ScenarioFile {
    format: String,
    scenarios: Vec<Scenario>,
}

/// Reads all scenarios of a file, in its order. Each is valid and each has its own name.
///
/// # Errors
/// [`ScenarioFileError`] if the file cannot be read, is too large, no JSON, of another format, or has a scenario with an
/// unknown, missing or senseless field.
pub fn read_scenarios(path: &Path) -> Result<Vec<Scenario>, ScenarioFileError> {
    let read_error = |source| ScenarioFileError::Read { path: path.to_owned(), source };
    let mut text = String::new();
    let file = File::open(path).map_err(read_error)?;
    file.take(MOST_BYTES + 1).read_to_string(&mut text).map_err(read_error)?;
    if text.len() as u64 > MOST_BYTES {
        return Err(ScenarioFileError::TooLarge { path: path.to_owned() });
    }
    parse_scenarios(&text, path)
}

/// Reads one scenario of a file: the one called `name`, or the first.
///
/// # Errors
/// As [`read_scenarios`], or [`ScenarioFileError::NotThere`].
pub fn read_scenario(path: &Path, name: Option<&str>) -> Result<Scenario, ScenarioFileError> {
    let mut scenarios = read_scenarios(path)?;
    let wanted = |scenario: &Scenario| name.is_none_or(|name| scenario.name == name);
    if let Some(index) = scenarios.iter().position(wanted) {
        return Ok(scenarios.swap_remove(index));
    }
    let mut known: Vec<_> = scenarios.iter().take(NAMES_SHOWN).map(|scenario| &*scenario.name).collect();
    if scenarios.len() > NAMES_SHOWN {
        known.push("…");
    }
    let (path, name) = (path.to_owned(), name.unwrap_or_default().to_owned());
    Err(ScenarioFileError::NotThere { path, name, known: known.join(", ") })
}

/// The same for a file given as text; `origin` only names it in errors.
///
/// # Errors
/// As [`read_scenarios`], but for what concerns reading.
pub fn parse_scenarios(text: &str, origin: &Path) -> Result<Vec<Scenario>, ScenarioFileError> {
    let mut json = serde_json::Deserializer::from_str(text);
    let parsed: Result<ScenarioFile, _> = serde_path_to_error::deserialize(&mut json);
    let file = parsed.map_err(|error| explain(text, origin, error))?;
    json.end().map_err(|source| ScenarioFileError::Syntax { path: origin.to_owned(), source })?;
    refuse_other_format(&file.format, origin)?;
    check(&file.scenarios, origin)?;
    Ok(file.scenarios)
}

/// Writes scenarios to a file, one on each line, such that [`read_scenarios`] gives back every bit of them.
///
/// # Errors
/// [`ScenarioFileError`] if they could not be read back, or the file cannot be written.
pub fn write_scenarios(path: &Path, scenarios: &[Scenario]) -> Result<(), ScenarioFileError> {
    check(scenarios, path)?;
    let write_error = |source| ScenarioFileError::Write { path: path.to_owned(), source };
    let lines: Result<Vec<_>, _> = scenarios.iter().map(serde_json::to_string).collect();
    let lines = lines.map_err(|error| write_error(error.into()))?.join(",\n");
    let text = format!("{{\"format\": \"{SCENARIO_FORMAT}\", \"scenarios\": [\n{lines}\n]}}\n");
    if text.len() as u64 > MOST_BYTES {
        return Err(ScenarioFileError::TooLarge { path: path.to_owned() });
    }
    std::fs::write(path, text).map_err(write_error)
}

fn refuse_other_format(format: &str, origin: &Path) -> Result<(), ScenarioFileError> {
    if format == SCENARIO_FORMAT {
        Ok(())
    } else {
        Err(ScenarioFileError::Format { path: origin.to_owned(), found: format!("{format:?}") })
    }
}

fn check(scenarios: &[Scenario], origin: &Path) -> Result<(), ScenarioFileError> {
    let path = || origin.to_owned();
    if !(1..=MOST_SCENARIOS).contains(&scenarios.len()) {
        return Err(ScenarioFileError::Count { path: path(), found: scenarios.len() });
    }
    let mut names = BTreeSet::new();
    for (index, scenario) in scenarios.iter().enumerate() {
        scenario.validate().map_err(|source| ScenarioFileError::Scenario {
            path: path(),
            name: match source {
                ScenarioError::BadName { .. } => format!("{index}"),
                _ => scenario.name.clone(),
            },
            source,
        })?;
        if !names.insert(&*scenario.name) {
            return Err(ScenarioFileError::TwiceNamed { path: path(), name: scenario.name.clone() });
        }
    }
    Ok(())
}

/// What is read of a file that could not be read, to say what is wrong with it.
#[derive(Deserialize)]
struct Format {
    format: Option<String>,
}

#[derive(Deserialize)]
struct Names {
    scenarios: Vec<Name>,
}

#[derive(Deserialize)]
struct Name {
    name: Option<String>,
}

fn explain(
    text: &str,
    origin: &Path,
    error: serde_path_to_error::Error<serde_json::Error>,
) -> ScenarioFileError {
    let path = origin.to_owned();
    let segments: Vec<String> = error.path().iter().map(ToString::to_string).collect();
    let index = match error.path().iter().nth(1) {
        Some(Segment::Seq { index }) => Some(*index),
        _ => None,
    };
    let source = error.into_inner();
    if !source.is_data() {
        return ScenarioFileError::Syntax { path, source };
    }
    // Another format has other fields: that it is another one is the better news.
    match serde_json::from_str(text) {
        Ok(Format { format: Some(format) }) if format == SCENARIO_FORMAT => {}
        Ok(Format { format }) => {
            let found = format.map_or_else(|| "missing".to_owned(), |format| format!("{format:?}"));
            return ScenarioFileError::Format { path, found };
        }
        Err(_) => {}
    }
    let Some(index) = index else {
        let field = segments.first().cloned().unwrap_or_else(|| "the whole file".to_owned());
        return ScenarioFileError::Field { path, scenario: "file".to_owned(), field, source };
    };
    let name = serde_json::from_str(text)
        .ok()
        .and_then(|Names { scenarios }| scenarios.into_iter().nth(index).and_then(|scenario| scenario.name));
    let scenario = match name {
        Some(name) => format!("scenario {}", name.chars().take(64).collect::<String>()),
        None => format!("scenarios[{index}]"),
    };
    let field = match &segments[2..] {
        [] => "the whole scenario".to_owned(),
        fields => join(fields),
    };
    ScenarioFileError::Field { path, scenario, field, source }
}

/// `people`, `[2]`, `radius_m` as `people[2].radius_m`.
fn join(segments: &[String]) -> String {
    segments.iter().fold(String::new(), |path, segment| {
        let dot = if path.is_empty() || segment.starts_with('[') { "" } else { "." };
        path + dot + segment
    })
}
