//! What came of a check: a table for a terminal, JSON for a program.

use core::fmt;

use serde::Serialize;

/// How one check ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The rule is kept.
    Pass,
    /// The rule is broken.
    Fail,
    /// There was nothing to judge, because of an earlier failure.
    NotRun,
}

/// One rule and what was measured.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Check {
    /// Short name.
    pub name: &'static str,
    /// Whether it is kept.
    pub outcome: Outcome,
    /// What was measured, with its limit.
    pub measured: String,
    /// What to do, where it failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub advice: Option<&'static str>,
}

impl Check {
    /// A rule that is kept if `kept`; `advice` is given where it is not.
    pub(crate) fn of(name: &'static str, kept: bool, measured: String, advice: &'static str) -> Self {
        let outcome = if kept { Outcome::Pass } else { Outcome::Fail };
        Self { name, outcome, measured, advice: (!kept).then_some(advice) }
    }

    /// A rule that could not be judged.
    pub(crate) fn not_run(name: &'static str, why: &str) -> Self {
        Self { name, outcome: Outcome::NotRun, measured: why.to_owned(), advice: None }
    }
}

/// Everything found out about a candidate. `Display` gives the table for the terminal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Findings {
    /// The command that was checked.
    pub command: String,
    /// Whether every rule is kept.
    pub passed: bool,
    /// Every rule, in the order of the script.
    pub checks: Vec<Check>,
    /// What is worth knowing and no failure.
    pub notes: Vec<String>,
    /// What the candidate printed; empty where everything passed.
    pub output: String,
}

impl Findings {
    pub(crate) fn new(command: String, checks: Vec<Check>, notes: Vec<String>, output: String) -> Self {
        let passed = checks.iter().all(|check| check.outcome == Outcome::Pass);
        Self { command, passed, checks, notes, output: if passed { String::new() } else { output } }
    }
}

impl fmt::Display for Findings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.command)?;
        for check in &self.checks {
            let outcome = match check.outcome {
                Outcome::Pass => "pass",
                Outcome::Fail => "FAIL",
                Outcome::NotRun => "-",
            };
            writeln!(f, "  {outcome:<5} {:<18} {}", check.name, check.measured)?;
            if let Some(advice) = check.advice {
                writeln!(f, "        {:<18} -> {advice}", "")?;
            }
        }
        for note in &self.notes {
            writeln!(f, "  note  {note}")?;
        }
        if !self.output.trim().is_empty() {
            writeln!(f, "what it printed:")?;
            for line in self.output.lines() {
                writeln!(f, "  | {line}")?;
            }
        }
        let count = |outcome| self.checks.iter().filter(|check| check.outcome == outcome).count();
        write!(
            f,
            "{}: {} passed, {} failed, {} not run",
            if self.passed { "every rule is kept" } else { "not ready to drive" },
            count(Outcome::Pass),
            count(Outcome::Fail),
            count(Outcome::NotRun)
        )
    }
}
