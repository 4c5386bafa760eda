//! Beginning, driving, halting, ending.

use super::SILENT;
use crate::findings::Check;
use crate::observations::{Attempt, Observations, Phase};
use crate::script::FAREWELL;

/// It may take so long to speak again once its inputs are good, s.
const RESUME_S: f64 = 1.0;

/// It speaks at all.
pub(super) fn speaks(seen: &Observations, patience_s: f64) -> Check {
    let first = seen.heard.first();
    let measured = match (first, &seen.ended_early) {
        (Some(first), _) => {
            let after_s = first.received_ns.saturating_sub(seen.started_ns) as f64 * 1e-9;
            format!("first command {after_s:.2} s after its start (at most {patience_s} s)")
        }
        (None, Some((status, _))) => format!("ended by itself without a word ({status})"),
        (None, None) => format!("no command within {patience_s} s"),
    };
    Check::of(
        "speaks",
        first.is_some(),
        measured,
        "open NAME/robot_state and NAME/goal for reading and NAME/nominal_command for writing, under the prefix in \
         CNCBF_IPC_PREFIX; its output may say why it does not",
    )
}

/// It takes the goal that was said before it began.
pub(super) fn late_start(seen: &Observations) -> Check {
    if seen.heard.is_empty() {
        return Check::not_run("late start", SILENT);
    }
    Check::of(
        "late start",
        !seen.goal_repeated,
        if seen.goal_repeated {
            "it spoke only once the goal had been said again".to_owned()
        } else {
            "it took the goal that had been said before it began".to_owned()
        },
        "ask for the last sample when subscribing to the goal (history of 1), and take it on the first cycle",
    )
}

/// It does not end by itself.
pub(super) fn stays(seen: &Observations) -> Check {
    let measured = match &seen.ended_early {
        None => "it ran until it was asked to end".to_owned(),
        Some((status, phase)) => format!("it ended by itself ({status}) {}", when(*phase)),
    };
    Check::of(
        "stays",
        seen.ended_early.is_none(),
        measured,
        "its output is below; an exception or a crash ends it",
    )
}

const fn when(phase: Phase) -> &'static str {
    match phase {
        Phase::Waiting => "before it spoke",
        Phase::Driving => "on the way to a goal",
        Phase::AtGoal => "at the goal",
        Phase::NoStates => "when robot states stayed away",
        Phase::Again => "when robot states returned",
        Phase::NotANumber => "when the robot state held a NaN",
        Phase::Ending => "at the end",
    }
}

/// It reaches a goal straight ahead.
pub(super) fn first_goal(seen: &Observations, tolerance_m: f64) -> Check {
    let Some(attempt) = seen.first_goal else { return Check::not_run("goal", SILENT) };
    let Attempt { succeeded, took_s, distance_m } = attempt;
    Check::of(
        "goal",
        succeeded,
        if succeeded {
            format!("reached within {tolerance_m} m after {took_s:.1} s")
        } else {
            format!("{distance_m:.2} m away from it after {took_s:.1} s (tolerance {tolerance_m} m)")
        },
        "positions are in odom, headings in rad, the control is [speed m/s, yaw rate rad/s] or [ax, ay] m/s² in odom",
    )
}

/// It asks for a halt at the goal.
pub(super) fn halt(seen: &Observations) -> Check {
    if !seen.first_goal.is_some_and(|attempt| attempt.succeeded) {
        return Check::not_run("stop at goal", "not run: no goal was reached");
    }
    Check::of(
        "stop at goal",
        seen.halted_after_s.is_some(),
        match seen.halted_after_s {
            Some(after_s) => {
                format!("intent Stop {after_s:.2} s after the arrival, and nothing else from then on")
            }
            None => "no lasting intent Stop within 4 s after the arrival".to_owned(),
        },
        "send intent Stop while the robot is within nominal.goal_tolerance_m of the goal, and go on sending it",
    )
}

/// It turns to a new goal, standing and driving.
pub(super) fn goal_change(seen: &Observations) -> Check {
    if seen.turns.is_empty() {
        return Check::not_run("goal change", SILENT);
    }
    let told: Vec<_> = seen
        .turns
        .iter()
        .map(|turn| {
            let what = if turn.succeeded { "turned after" } else { "did not turn within" };
            format!("{what} {:.1} s", turn.took_s)
        })
        .collect();
    Check::of(
        "goal change",
        seen.turns.iter().all(|turn| turn.succeeded),
        told.join(", then "),
        "take the newest goal in every cycle; a goal that was reached must not hold it back from the next one",
    )
}

/// It speaks again when robot states return.
pub(super) fn resumes(seen: &Observations) -> Check {
    again("resume", seen, Phase::NoStates, seen.resumed_after_s, "robot states returned")
}

/// It speaks again, and in numbers, after robot states that held a NaN.
pub(super) fn recovers(seen: &Observations) -> Check {
    const NAME: &str = "not a number";
    let wild = seen.during(Phase::NotANumber).filter(|heard| !heard.is_finite()).count();
    if wild > 0 {
        return Check::of(
            NAME,
            false,
            format!("{wild} commands with a NaN or an infinity in answer to a robot state that held one"),
            "leave a robot state with a value that is not finite unanswered",
        );
    }
    again(NAME, seen, Phase::NotANumber, seen.recovered_after_s, "robot states were numbers again")
}

fn again(
    name: &'static str,
    seen: &Observations,
    after: Phase,
    spoke_after_s: Option<f64>,
    when: &str,
) -> Check {
    if seen.stretches_of(after).next().is_none() {
        return Check::not_run(name, SILENT);
    }
    Check::of(
        name,
        spoke_after_s.is_some_and(|after_s| after_s <= RESUME_S),
        match spoke_after_s {
            Some(after_s) => format!("spoke {after_s:.2} s after {when} (at most {RESUME_S} s)"),
            None => format!("silent for 3 s after {when}"),
        },
        "keep no state that one bad input spoils for good",
    )
}

/// It ends when asked, and leaves its place.
pub(super) fn ends(seen: &Observations) -> Check {
    let Some(farewell) = &seen.farewell else {
        return Check::not_run("ends", "not run: it had ended by itself");
    };
    let after_s = farewell.after_ns as f64 * 1e-9;
    let measured = match &farewell.status {
        None => format!("still running {:.1} s after SIGTERM; killed", FAREWELL.as_secs_f64()),
        Some(status) if !farewell.is_clean => {
            format!("{status} {after_s:.2} s after SIGTERM; exit code 0 is asked")
        }
        Some(_) if !farewell.place_is_free => {
            format!("ended {after_s:.2} s after SIGTERM and left its place in shared memory taken")
        }
        Some(_) => format!("{after_s:.2} s after SIGTERM with exit code 0, its place is free"),
    };
    Check::of(
        "ends",
        farewell.status.is_some() && farewell.is_clean && farewell.place_is_free,
        measured,
        "handle SIGTERM: leave the loop, drop the ports and the node, return 0 within 2 s; the next controller waits for the place",
    )
}
