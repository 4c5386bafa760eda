//! What on this machine would spoil a run: findings with advice, changed by nobody here; how late threads wake up, measured;
//! and what the processes of a running stack were granted.

mod kernel;
mod lateness;
mod processors;
mod quota;
mod resources;
mod rights;
mod running;
mod verdict;
mod ways;

pub use lateness::{Lateness, measure_wake_up_lateness};
pub use running::{RunningProcess, running};
pub use verdict::{Verdict, judge};
pub use ways::{Way, WayLateness, measure_ways};

use crate::Domain;

/// How much a finding matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// As it should be.
    Good,
    /// Worth knowing; a run works.
    Note,
    /// A run will miss deadlines or fail.
    Warning,
}

impl Severity {
    /// The name in tables and JSON.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Note => "note",
            Self::Warning => "warning",
        }
    }
}

/// One thing that was looked at.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// How much it matters.
    pub severity: Severity,
    /// What was found, in one line.
    pub what: String,
    /// What to do about it; empty where nothing is to be done.
    pub advice: String,
}

impl Finding {
    fn good(what: impl Into<String>) -> Self {
        Self { severity: Severity::Good, what: what.into(), advice: String::new() }
    }

    fn note(what: impl Into<String>, advice: impl Into<String>) -> Self {
        Self { severity: Severity::Note, what: what.into(), advice: advice.into() }
    }

    fn warning(what: impl Into<String>, advice: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, what: what.into(), advice: advice.into() }
    }
}

/// Looks at the kernel, the clock, the processors, the rights of this user, and the shared memory of `domain`.
///
/// Takes a few milliseconds and changes nothing.
pub fn probe(domain: &Domain) -> Vec<Finding> {
    let mut findings = kernel::probe();
    findings.extend(processors::probe());
    findings.extend(rights::probe());
    findings.extend(resources::probe(domain));
    findings
}

/// The first line of a small file of the kernel, if it can be read.
fn line_of(path: impl AsRef<std::path::Path>) -> Option<String> {
    let text = std::fs::read_to_string(path).ok()?;
    text.lines().next().map(|line| line.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_finding_that_is_not_good_comes_with_advice() {
        let findings = probe(&Domain::isolated());
        assert!(findings.len() >= 15, "{findings:?}");
        for finding in findings {
            assert_eq!(finding.severity == Severity::Good, finding.advice.is_empty(), "{finding:?}");
            assert!(!finding.what.is_empty() && !finding.what.contains('\n'));
        }
    }
}
