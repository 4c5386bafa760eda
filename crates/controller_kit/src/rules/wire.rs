//! What stands in a command.

use std::collections::HashMap;

use messages::{ControlKind, Controller, Intent, RobotState};

use super::SILENT;
use crate::findings::Check;
use crate::observations::{Heard, Observations, Phase};

/// Numbers from here on are free for controllers that are not ours.
const FIRST_EXTERNAL: u32 = 1_000;
/// A command cannot have been underway for longer, ns: its stamp is of another clock.
const LONGEST_WAY_NS: u64 = 1_000_000_000;

/// Identity and times of every command.
pub(super) fn stamps(seen: &Observations) -> Check {
    if seen.heard.is_empty() {
        return Check::not_run("stamps", SILENT);
    }
    let sent: HashMap<u64, &RobotState> =
        seen.sent.iter().map(|state| (state.stamp.published_ns, state)).collect();
    let mut wrong = 0;
    let mut first = None;
    let (mut sequence, mut published_ns) = (0, 0);
    for heard in &seen.heard {
        if let Some(fault) = fault(heard, sequence, published_ns, &sent) {
            wrong += 1;
            first.get_or_insert(fault);
        }
        sequence = heard.command.stamp.sequence;
        published_ns = heard.command.stamp.published_ns;
    }
    let count = seen.heard.len();
    Check::of(
        "stamps",
        wrong == 0,
        first.map_or_else(
            || format!("all of {count} commands count on and name the robot state they answer"),
            |fault| format!("{wrong} of {count} wrong, the first: {fault}"),
        ),
        "copy the robot state's stamp, count sequence from 1, set published_ns by the monotonic clock just before sending, \
         bridge_published_ns to the state's published_ns, received_ns to the clock as read after taking it",
    )
}

/// What is wrong with the stamp of one command that followed one with `sequence`, sent at `published_ns`.
fn fault(
    heard: &Heard,
    sequence: u64,
    published_ns: u64,
    sent: &HashMap<u64, &RobotState>,
) -> Option<String> {
    let command = &heard.command;
    let stamp = &command.stamp;
    if stamp.sequence != sequence + 1 {
        return Some(format!("sequence {} after {sequence}", stamp.sequence));
    }
    if stamp.published_ns <= published_ns {
        return Some("published_ns does not grow".to_owned());
    }
    // What was said on the way out waits until the candidate has ended.
    let may_wait = heard.phase == Phase::Ending;
    let way_ns = heard.received_ns.checked_sub(stamp.published_ns);
    if way_ns.is_none_or(|way_ns| way_ns > LONGEST_WAY_NS && !may_wait) {
        return Some(format!(
            "published_ns {} when the monotonic clock said {}",
            stamp.published_ns, heard.received_ns
        ));
    }
    let Some(state) = sent.get(&command.bridge_published_ns) else {
        return Some(format!("bridge_published_ns {} is of no robot state", command.bridge_published_ns));
    };
    let same = (stamp.source_ns, stamp.valid_at_ns, stamp.ingress_ns)
        == (state.stamp.source_ns, state.stamp.valid_at_ns, state.stamp.ingress_ns);
    if !same {
        return Some(
            "source_ns, valid_at_ns or ingress_ns is not that of the robot state it answers".to_owned(),
        );
    }
    // The moment at which a cycle began may count as when it took its inputs: some milliseconds are forgiven.
    let earliest_ns = command.bridge_published_ns.saturating_sub(5_000_000);
    if !(earliest_ns..=stamp.published_ns).contains(&command.received_ns) {
        return Some(format!(
            "received_ns {} is not between the robot state's {} and the command's {}",
            command.received_ns, command.bridge_published_ns, stamp.published_ns
        ));
    }
    None
}

/// Codes that the filter and the recording know.
pub(super) fn codes(seen: &Observations, kind: ControlKind) -> Check {
    if seen.heard.is_empty() {
        return Check::not_run("codes", SILENT);
    }
    let fault = seen.heard.iter().find_map(|heard| {
        let command = &heard.command;
        if ControlKind::try_from(command.control_kind) != Ok(kind) {
            return Some(format!(
                "control_kind {} for a robot of kind {} ({kind})",
                command.control_kind,
                kind.code()
            ));
        }
        if let Err(unknown) = Intent::try_from(command.intent) {
            return Some(format!("intent {}", unknown.code));
        }
        match Controller::try_from(command.controller) {
            Err(unknown) if unknown.code < FIRST_EXTERNAL => {
                Some(format!("controller {}, which is nobody's", unknown.code))
            }
            Ok(_) | Err(_) => None,
        }
    });
    let last = seen.heard.last().map_or(0, |heard| heard.command.controller);
    Check::of(
        "codes",
        fault.is_none(),
        fault.unwrap_or_else(|| format!("control_kind {kind}, controller {last}")),
        "set control_kind to the robot's, intent to Drive or Stop, controller to a number from 1000 on",
    )
}

/// Numbers, and no others.
pub(super) fn finite(seen: &Observations) -> Check {
    if seen.heard.is_empty() {
        return Check::not_run("finite", SILENT);
    }
    // What a NaN makes of it is a rule of its own.
    let judged: Vec<_> = seen.heard.iter().filter(|heard| heard.phase != Phase::NotANumber).collect();
    let wild = judged.iter().filter(|heard| !heard.is_finite()).count();
    Check::of(
        "finite",
        wild == 0,
        format!("{wild} of {} commands with a NaN or an infinity", judged.len()),
        "look for a division by zero, and do not send what is not finite: the filter refuses it and brakes",
    )
}
