//! What happens to a candidate, in order.

use std::time::Duration;

use node_runtime::{Clock, Domain, RealClock, members};
use settings::Settings;

use crate::bench::{Bench, Feed};
use crate::candidate::Candidate;
use crate::check::KitError;
use crate::observations::{Attempt, Farewell, Phase};

/// Where the first goal lies, m ahead.
pub(crate) const FIRST_GOAL_M: f64 = 2.5;
/// Where each later one lies, m.
const NEXT_GOAL_M: f64 = 3.0;
/// How far to the left, then to the right, of where the robot looks, rad: behind its side, so that going on is no answer.
const ASIDE_RAD: f64 = 2.0;
/// A robot that has come so much nearer has turned to its goal, m.
const NEARER_M: f64 = 0.5;
/// Longest way to the first goal, s.
const DRIVE_S: f64 = 25.0;
/// Longest turn to a new goal, s.
const TURN_S: f64 = 12.0;
/// How long a halt at the goal is waited for, and how long it must last, s.
const HALT_S: f64 = 4.0;
const HALT_LASTS_S: f64 = 0.5;
/// How long robot states stay away, s.
const SILENCE_S: f64 = 1.0;
/// How long robot states are no numbers, s.
const NOT_A_NUMBER_S: f64 = 0.5;
/// How long it is waited until the candidate speaks again, s.
const RESUME_S: f64 = 3.0;
/// How long it drives on before the next disturbance, s.
const CALM_S: f64 = 0.5;
/// How long it may take to end.
pub(crate) const FAREWELL: Duration = Duration::from_secs(2);

/// Leads the candidate through everything; what it saw lies in the bench afterwards.
pub(crate) fn play(
    bench: &mut Bench,
    candidate: &mut Candidate,
    settings: &Settings,
    patience_s: f64,
    progress: &mut dyn FnMut(&str),
) -> Result<(), KitError> {
    progress("waiting for its first command");
    if !wait_for_a_word(bench, candidate, patience_s)? {
        return Ok(());
    }
    bench.repeats_goal = true;
    progress("driving to the first goal");
    let tolerance_m = settings.nominal.goal_tolerance_m;
    let arrived = attempt(bench, candidate, DRIVE_S, &mut |bench: &Bench| bench.distance_m() <= tolerance_m)?;
    bench.seen.first_goal = Some(arrived);
    if arrived.succeeded {
        progress("at the first goal");
        bench.seen.halted_after_s = halt(bench, candidate)?;
    }
    for (bearing_rad, what) in [(ASIDE_RAD, "a new goal on the left"), (-ASIDE_RAD, "another on the right")] {
        progress(what);
        bench.set_goal(NEXT_GOAL_M, bearing_rad);
        let enough_m = NEXT_GOAL_M - NEARER_M;
        let turned = attempt(bench, candidate, TURN_S, &mut |bench: &Bench| bench.distance_m() <= enough_m)?;
        bench.seen.turns.push(turned);
    }
    progress("no robot states");
    bench.play(candidate, Phase::NoStates, Feed::Nothing, SILENCE_S, |_| false)?;
    bench.seen.resumed_after_s = speaks_again(bench, candidate)?;
    progress("robot states that are no numbers");
    bench.play(candidate, Phase::Driving, Feed::States, CALM_S, |_| false)?;
    bench.play(candidate, Phase::NotANumber, Feed::NotANumber, NOT_A_NUMBER_S, |_| false)?;
    bench.seen.recovered_after_s = speaks_again(bench, candidate)?;
    Ok(())
}

/// Asks the candidate to end and looks at what it leaves.
pub(crate) fn say_farewell(
    bench: &mut Bench,
    candidate: &mut Candidate,
    domain: &Domain,
) -> Result<(), KitError> {
    if bench.seen.ended_early.is_some() {
        return Ok(());
    }
    let ending = candidate.end(FAREWELL);
    let dead = members(domain)?.iter().any(|member| !member.alive);
    bench.seen.farewell = Some(Farewell {
        after_ns: ending.after_ns,
        status: ending.status.map(|status| status.to_string()),
        is_clean: ending.status.is_some_and(|status| status.success()),
        place_is_free: !dead && bench.place_is_free(),
    });
    Ok(())
}

/// Waits for the first command; the goal was said before the candidate began. Where that is not enough, says it again.
fn wait_for_a_word(bench: &mut Bench, candidate: &mut Candidate, patience_s: f64) -> Result<bool, KitError> {
    let has_spoken = |bench: &Bench| !bench.seen.heard.is_empty();
    if bench.play(candidate, Phase::Waiting, Feed::States, patience_s, has_spoken)? {
        return Ok(true);
    }
    bench.seen.goal_repeated = true;
    bench.send_goal();
    bench.play(candidate, Phase::Waiting, Feed::States, RESUME_S, has_spoken)
}

fn attempt(
    bench: &mut Bench,
    candidate: &mut Candidate,
    limit_s: f64,
    met: &mut dyn FnMut(&Bench) -> bool,
) -> Result<Attempt, KitError> {
    let start_ns = RealClock.now_ns();
    let succeeded = bench.play(candidate, Phase::Driving, Feed::States, limit_s, met)?;
    let took_s = (RealClock.now_ns() - start_ns) as f64 * 1e-9;
    Ok(Attempt { succeeded, took_s, distance_m: bench.distance_m() })
}

/// Time until the candidate asks for a halt and does nothing else for a while, s.
fn halt(bench: &mut Bench, candidate: &mut Candidate) -> Result<Option<f64>, KitError> {
    let start_ns = RealClock.now_ns();
    let lasts_ns = (HALT_LASTS_S * 1e9) as u64;
    // The first of the unbroken row of stops that is heard now.
    let row_began_ns = |bench: &Bench| {
        let row =
            bench.seen.heard.iter().rev().take_while(|heard| heard.received_ns >= start_ns && heard.stops());
        row.last().map(|heard| heard.received_ns)
    };
    let halted = bench.play(candidate, Phase::AtGoal, Feed::States, HALT_S, |bench| {
        row_began_ns(bench).is_some_and(|began_ns| RealClock.now_ns() - began_ns >= lasts_ns)
    })?;
    let began_ns = row_began_ns(bench).filter(|_| halted);
    Ok(began_ns.map(|began_ns| (began_ns - start_ns) as f64 * 1e-9))
}

/// Time until the candidate speaks after robot states have returned, s.
fn speaks_again(bench: &mut Bench, candidate: &mut Candidate) -> Result<Option<f64>, KitError> {
    let (start_ns, heard) = (RealClock.now_ns(), bench.seen.heard.len());
    let spoke = bench
        .play(candidate, Phase::Again, Feed::States, RESUME_S, |bench| bench.seen.heard.len() > heard)?;
    Ok(spoke.then(|| (RealClock.now_ns() - start_ns) as f64 * 1e-9))
}
