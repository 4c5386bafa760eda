//! One candidate from its start to its findings.

use std::ffi::{OsStr, OsString};
use std::time::Duration;

use crowd_sim::PlantError;
use node_runtime::{CleanUpError, Domain, NodeError, ScopedDomain, Shutdown, ShutdownError};
use settings::Settings;

use crate::bench::{Bench, Feed};
use crate::candidate::{Candidate, StartError};
use crate::findings::Findings;
use crate::rules;
use crate::script;

/// How long the bench speaks before the candidate is started: its goal is an old one then.
const HEAD_START: Duration = Duration::from_millis(300);

/// What is checked.
#[derive(Debug, Clone)]
pub struct Plan<'a> {
    /// The program and its arguments.
    pub command: &'a [OsString],
    /// Robot, rates and limits.
    pub settings: &'a Settings,
    /// Name of the stack whose services the program looks for.
    pub instance: &'a str,
    /// How long it may take until it speaks, s.
    pub patience_s: f64,
}

/// Why a candidate could not be checked. That it does not keep the rules is a finding.
#[derive(Debug, thiserror::Error)]
pub enum KitError {
    /// It could not be started.
    #[error(transparent)]
    Start(#[from] StartError),
    /// The bench could not open its services.
    #[error("the test bench: {0}")]
    Node(#[from] NodeError),
    /// The bench could not look at what the candidate left.
    #[error("the test bench: {0}")]
    CleanUp(#[from] CleanUpError),
    /// The settings describe no robot.
    #[error("the test bench: {0}")]
    Robot(#[from] PlantError),
    /// Signals cannot be handled.
    #[error(transparent)]
    Shutdown(#[from] ShutdownError),
    /// Somebody asked the check to end.
    #[error("interrupted; the candidate was ended")]
    Interrupted,
}

/// Starts the candidate in a domain of its own, leads it through everything, and judges it. `progress` is told what comes next.
///
/// Takes some thirty seconds, more where the candidate must be waited for.
///
/// # Errors
/// [`KitError`] if there is nothing to judge.
pub fn check(plan: &Plan<'_>, progress: &mut dyn FnMut(&str)) -> Result<Findings, KitError> {
    let shutdown = Shutdown::install()?;
    let domain = ScopedDomain::new();
    let mut bench = Bench::open(&domain, plan.instance, plan.settings, shutdown)?;
    bench.set_goal(script::FIRST_GOAL_M, 0.0);
    std::thread::sleep(HEAD_START);
    let environment = [(Domain::VARIABLE, OsStr::new(domain.prefix()))];
    let mut candidate = Candidate::start(plan.command, &environment)?;
    bench.seen.started_ns = node_runtime::Clock::now_ns(&node_runtime::RealClock);
    script::play(&mut bench, &mut candidate, plan.settings, plan.patience_s, progress)?;
    progress("asking it to end");
    script::say_farewell(&mut bench, &mut candidate, &domain)?;
    // What it said with its last breath.
    bench.play(&mut candidate, crate::observations::Phase::Ending, Feed::Nothing, 0.0, |_| true)?;
    let command = plan.command.iter().map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ");
    Ok(Findings::new(
        command,
        rules::judge(&bench.seen, plan),
        rules::notes(&bench.seen, plan.settings),
        candidate.output(),
    ))
}
