//! How often, how fresh, and when not.

use messages::Intent;
use settings::{FilterSettings, NominalSettings, Settings};

use super::SILENT;
use crate::findings::Check;
use crate::observations::{Observations, Phase};

const NS_PER_MS: u64 = 1_000_000;
/// Share of the time, or of the commands, that a busy machine may spoil.
const SPOILED_SHARE: f64 = 0.01;

/// A command at least as often as the filter's patience lasts, on the way to a goal.
pub(super) fn rate(seen: &Observations, filter: &FilterSettings) -> Check {
    let limit_ns = filter.nominal_max_silence_ms * NS_PER_MS;
    let (mut driven_ns, mut braked_ns, mut longest_ns, mut commands) = (0, 0, 0, 0_u64);
    for stretch in seen.stretches_of(Phase::Driving) {
        let mut last_ns = stretch.start_ns;
        let sent = seen.heard.iter().map(|heard| heard.received_ns);
        for now_ns in
            sent.filter(|ns| (stretch.start_ns..stretch.end_ns).contains(ns)).chain([stretch.end_ns])
        {
            let gap_ns = now_ns.saturating_sub(last_ns);
            longest_ns = longest_ns.max(gap_ns);
            braked_ns += gap_ns.saturating_sub(limit_ns);
            commands += u64::from(now_ns != stretch.end_ns);
            last_ns = now_ns;
        }
        driven_ns += stretch.end_ns - stretch.start_ns;
    }
    if seen.heard.is_empty() || driven_ns == 0 {
        return Check::not_run("rate", SILENT);
    }
    let share = braked_ns as f64 / driven_ns as f64;
    Check::of(
        "rate",
        share <= SPOILED_SHARE,
        format!(
            "{:.1} commands a second, longest gap {} ms; the filter would brake {:.2} % of the time (patience {} ms, at most 1 %)",
            commands as f64 / (driven_ns as f64 * 1e-9),
            longest_ns / NS_PER_MS,
            100.0 * share,
            filter.nominal_max_silence_ms
        ),
        "send a command at least every filter.nominal_max_silence_ms, from a timer and not from inputs; 20 Hz is customary",
    )
}

/// The answered robot state is a recent one.
pub(super) fn age(seen: &Observations, nominal: &NominalSettings) -> Check {
    let limit_ns = nominal.max_state_age_ms * NS_PER_MS;
    let ages_ns: Vec<_> = seen
        .during(Phase::Driving)
        .map(|heard| heard.received_ns.saturating_sub(heard.command.stamp.valid_at_ns))
        .collect();
    let Some(oldest_ns) = ages_ns.iter().max() else { return Check::not_run("age", SILENT) };
    let old = ages_ns.iter().filter(|&&age_ns| age_ns > limit_ns).count();
    let mean_ns = ages_ns.iter().sum::<u64>() / ages_ns.len() as u64;
    Check::of(
        "age",
        old as f64 <= SPOILED_SHARE * ages_ns.len() as f64,
        format!(
            "robot states answered were {} ms old on average and {} ms at most; {old} of {} above {} ms",
            mean_ns / NS_PER_MS,
            oldest_ns / NS_PER_MS,
            ages_ns.len(),
            nominal.max_state_age_ms
        ),
        "answer the newest robot state, empty the queue before computing, and copy its stamp into the command",
    )
}

/// No command to drive once the robot state has become old.
pub(super) fn silence(seen: &Observations, settings: &Settings) -> Check {
    const NAME: &str = "silence";
    let Some(stretch) = seen.stretches_of(Phase::NoStates).next() else {
        return Check::not_run(NAME, SILENT);
    };
    let last_state_ns =
        seen.sent.iter().map(|state| state.stamp.valid_at_ns).filter(|&ns| ns <= stretch.start_ns).max();
    let last_state_ns = last_state_ns.unwrap_or(stretch.start_ns);
    let limit_ms = settings.nominal.max_state_age_ms + settings.filter.nominal_max_silence_ms;
    let drives = seen.during(Phase::NoStates).filter(|heard| heard.command.intent == Intent::Drive.code());
    let last_ms = drives.map(|heard| heard.received_ns.saturating_sub(last_state_ns) / NS_PER_MS).max();
    let measured = match last_ms {
        Some(last_ms) => {
            format!("last command to drive {last_ms} ms after the last robot state (at most {limit_ms} ms)")
        }
        None => "no command to drive without robot states".to_owned(),
    };
    Check::of(
        NAME,
        last_ms.is_none_or(|last_ms| last_ms <= limit_ms),
        measured,
        "say nothing, or intent Stop, where the newest robot state is older than nominal.max_state_age_ms",
    )
}
