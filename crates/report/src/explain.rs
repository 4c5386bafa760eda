//! What the filter did at one time, and because of which obstacle.

use messages::{Obstacle, SafeCommand};
use serde::Serialize;

use crate::finite::or_null;
use crate::intervention::{INTERVENTION_TOLERANCE, correction};
use crate::spans::{Rung, rung_spans};
use crate::{Moment, RunRecord, words};

/// Why a moment cannot be explained.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ExplainError {
    /// There is nothing to explain.
    #[error("the record holds no safe commands; record a run with the filter running")]
    NoCommands,
    /// The time lies outside the run.
    #[error(
        "the run lasts from 0 s to {end_s:.3} s after its first safe command; {asked_s:.3} s lies outside"
    )]
    OutsideRun {
        /// The time asked for, s since the run began.
        asked_s: f64,
        /// When the run ended, s since it began.
        end_s: f64,
    },
}

/// What became of the CBF condition ḣ + α·h ≥ −s.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Constraint {
    /// No obstacle was near: nothing to satisfy.
    Absent,
    /// The nominal command satisfied it already.
    Inactive,
    /// The nominal command violated it; the command was moved onto its boundary.
    Active,
    /// No admissible command satisfied it; slack took the rest.
    Violated,
}

/// The barrier and the terms of its rate, ḣ = drift + L_g h·u.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BarrierTerms {
    /// Composite h, m; `null` with no obstacle.
    #[serde(serialize_with = "or_null")]
    pub h_m: f64,
    /// Smallest distance between the discs, buffer and growth by age included, m; `null` with no obstacle.
    #[serde(serialize_with = "or_null")]
    pub sdf_m: f64,
    /// L_f h + ∂h/∂t, m/s.
    pub drift_mps: f64,
    /// L_g h, m/s per unit of control.
    pub lg_h: [f64; 2],
    /// L_g h·u, m/s.
    pub lg_h_u_mps: f64,
    /// α·h, m/s; `null` with no obstacle.
    #[serde(serialize_with = "or_null")]
    pub alpha_h_mps: f64,
    /// ḣ + α·h with the command, m/s: at least −slack.
    #[serde(serialize_with = "or_null")]
    pub condition_mps: f64,
    /// ḣ + α·h with the nominal command, m/s: negative where the filter had to step in.
    #[serde(serialize_with = "or_null")]
    pub condition_nominal_mps: f64,
    /// Slack s, m/s.
    pub slack_mps: f64,
    /// Largest ḣ + α·h that any admissible control reaches, m/s; `null` with no obstacle.
    #[serde(serialize_with = "or_null")]
    pub hard_margin_mps: f64,
    /// What became of the condition.
    pub constraint: Constraint,
}

/// The obstacle that weighed most, predicted to the time of the cycle, relative to the robot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CriticalObstacle {
    /// Its track.
    pub track_id: u64,
    /// Its own h̄, m.
    #[serde(serialize_with = "or_null")]
    pub h_m: f64,
    /// Its weight in the composite's gradient, 0 to 1: exp(−β·(h̄ − h)).
    pub share: f64,
    /// Where it was. `None` if the record holds no such obstacle.
    pub place: Option<Place>,
}

/// Where an obstacle was and how it moved.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Place {
    /// Centre `[forward, left]` in `base`, m.
    pub position_in_base_m: [f64; 2],
    /// Distance between the centres, m.
    pub distance_m: f64,
    /// Distance between the discs without any buffer, m.
    pub clearance_m: f64,
    /// Its speed, m/s.
    pub speed_mps: f64,
    /// Rate at which the distance shrinks, m/s. `None` without a robot state.
    pub closing_speed_mps: Option<f64>,
    /// Its class.
    pub class: &'static str,
    /// How far its estimate can be trusted.
    pub quality: &'static str,
}

/// Ages of the inputs when the cycle began, ms since the bridge first saw them. `None` where none had arrived.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct InputAges {
    /// Robot state.
    pub robot_state_ms: Option<f64>,
    /// Detections behind the obstacles.
    pub detections_ms: Option<f64>,
    /// Nominal command, since it was published.
    pub nominal_ms: Option<f64>,
}

/// The filter a while before or after.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Neighbour {
    /// Seconds since the run began.
    pub time_s: f64,
    /// Rung of the ladder.
    pub status: Rung,
    /// Why.
    pub reason: String,
    /// Composite h, m; `null` with no obstacle or where it was not evaluated.
    #[serde(serialize_with = "or_null")]
    pub h_m: f64,
    /// The command u.
    pub control: [f64; 2],
    /// |u − u_nom|, Euclidean.
    pub correction: f64,
}

/// Everything about one cycle of the filter. `Display` gives the text for the terminal.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Explanation {
    /// Beginning of the cycle, s since the run began.
    pub time_s: f64,
    /// The same on the stack clock, ns.
    pub stack_time_ns: u64,
    /// Sequence number of the command.
    pub sequence: u64,
    /// Rung of the ladder.
    pub status: Rung,
    /// What that rung means.
    pub status_in_words: &'static str,
    /// Why this rung.
    pub reason: String,
    /// What that reason means.
    pub reason_in_words: String,
    /// Since when and until when the filter stayed on this rung, s since the run began.
    pub status_held_s: [f64; 2],
    /// Names of the control's components.
    pub control_components: [&'static str; 2],
    /// Units of the control's components.
    pub control_units: [&'static str; 2],
    /// u_nom.
    pub nominal: [f64; 2],
    /// u.
    pub control: [f64; 2],
    /// |u − u_nom|, Euclidean.
    pub correction: f64,
    /// Whether that is more than [`INTERVENTION_TOLERANCE`].
    pub corrected: bool,
    /// The barrier; `None` where the filter braked without evaluating it.
    pub barrier: Option<BarrierTerms>,
    /// Obstacles in the composite.
    pub obstacle_count: u32,
    /// Those outside the domain the model was trained on.
    pub outside_domain: u32,
    /// The obstacle that mattered most.
    pub critical: Option<CriticalObstacle>,
    /// How old the inputs were.
    pub ages: InputAges,
    /// One second before, if the run had begun.
    pub before: Option<Neighbour>,
    /// One second after, if the run still went on.
    pub after: Option<Neighbour>,
}

/// Explains the last cycle that had begun `time_s` seconds after the run began.
///
/// # Errors
/// [`ExplainError`] if the record holds no commands or the time lies outside the run.
pub fn explain(record: &RunRecord, time_s: f64) -> Result<Explanation, ExplainError> {
    if record.safe_commands.is_empty() {
        return Err(ExplainError::NoCommands);
    }
    let outside = ExplainError::OutsideRun { asked_s: time_s, end_s: record.duration_s() };
    // Half a period of grace: the end is printed to the millisecond and may be rounded up.
    let grace_s = 0.5e-9 * record.filter_period_ns as f64;
    if !(-grace_s..=record.duration_s() + grace_s).contains(&time_s) {
        return Err(outside);
    }
    let time_ns = record.stack_time_ns(time_s).max(record.start_ns());
    let moment = record.moment_at(time_ns).ok_or(outside)?;
    let command = moment.command;
    let status = Rung::of_code(command.status);
    let woke_s = record.seconds(command.ledger.filter_woke_ns);
    let held = rung_spans(record).into_iter().find(|span| span.start_s <= woke_s && woke_s < span.end_s);
    let components = words::control_components(command.control_kind);

    Ok(Explanation {
        time_s: woke_s,
        stack_time_ns: command.ledger.filter_woke_ns,
        sequence: command.sequence,
        status,
        status_in_words: words::rung(status),
        reason: words::reason_label(command.reason),
        reason_in_words: messages::Reason::try_from(command.reason)
            .map_or_else(|unknown| unknown.to_string(), |reason| words::reason(reason).to_owned()),
        status_held_s: held.map_or([woke_s; 2], |span| [span.start_s, span.end_s]),
        control_components: components.map(|(name, _)| name),
        control_units: components.map(|(_, unit)| unit),
        nominal: command.nominal,
        control: command.control,
        correction: correction(command),
        corrected: correction(command) > INTERVENTION_TOLERANCE,
        barrier: status.has_barrier().then(|| barrier_terms(command)),
        obstacle_count: command.obstacle_count,
        outside_domain: command.outside_domain,
        critical: (command.critical_track_id != 0).then(|| critical_obstacle(record, &moment)),
        ages: input_ages(command),
        before: neighbour(record, woke_s - 1.0),
        after: neighbour(record, woke_s + 1.0),
    })
}

/// The CBF condition of the paper, term by term: ∂h/∂t + L_f h + L_g h·u + α·h ≥ −s (eq. h_cn_to_h, softened).
fn barrier_terms(command: &SafeCommand) -> BarrierTerms {
    let along = |control: [f64; 2]| command.lg_h[0] * control[0] + command.lg_h[1] * control[1];
    let alpha_h_mps = command.alpha_per_s * command.h_m;
    let condition_mps = |control| command.drift_mps + along(control) + alpha_h_mps;
    let condition_nominal_mps = condition_mps(command.nominal);
    let constraint = if command.h_m == f64::INFINITY {
        Constraint::Absent
    } else if Rung::of_code(command.status) == Rung::Relaxed {
        Constraint::Violated
    } else if condition_nominal_mps < 0.0 {
        Constraint::Active
    } else {
        Constraint::Inactive
    };
    BarrierTerms {
        h_m: command.h_m,
        sdf_m: command.sdf_m,
        drift_mps: command.drift_mps,
        lg_h: command.lg_h,
        lg_h_u_mps: along(command.control),
        alpha_h_mps,
        condition_mps: condition_mps(command.control),
        condition_nominal_mps,
        slack_mps: command.slack_mps,
        hard_margin_mps: command.hard_margin_mps,
        constraint,
    }
}

fn critical_obstacle(record: &RunRecord, moment: &Moment<'_>) -> CriticalObstacle {
    let command = moment.command;
    let above_m = command.critical_h_m - command.h_m;
    let obstacle = moment.obstacles.and_then(|message| {
        message.as_slice().iter().find(|item| item.track_id == command.critical_track_id)
    });
    CriticalObstacle {
        track_id: command.critical_track_id,
        h_m: command.critical_h_m,
        share: (-record.beta_per_m * above_m).exp().min(1.0),
        place: obstacle.map(|obstacle| place(record, moment, obstacle)),
    }
}

fn place(record: &RunRecord, moment: &Moment<'_>, obstacle: &Obstacle) -> Place {
    let command = moment.command;
    let there = predicted_position_m(obstacle, command.ledger.filter_woke_ns);
    let here = command.robot_position_in_odom_m;
    let apart = [there[0] - here[0], there[1] - here[1]];
    let (sin, cos) = command.robot_heading_rad.sin_cos();
    let distance_m = apart[0].hypot(apart[1]);
    let closing_speed_mps = moment.robot_state.filter(|_| distance_m > 0.0).map(|state| {
        let own = state.velocity_in_odom_mps();
        let relative = [0, 1].map(|axis| obstacle.velocity_in_odom_mps[axis] - own[axis]);
        -(apart[0] * relative[0] + apart[1] * relative[1]) / distance_m
    });
    Place {
        position_in_base_m: [cos * apart[0] + sin * apart[1], cos * apart[1] - sin * apart[0]],
        distance_m,
        clearance_m: distance_m - record.robot_radius_m - obstacle.radius_m,
        speed_mps: obstacle.speed_mps,
        closing_speed_mps,
        class: words::class_label(obstacle.class),
        quality: words::quality_label(obstacle.quality),
    }
}

/// Where an obstacle is at `time_ns` if it keeps its velocity, `[x, y]` in `odom`, m; for at most half a second.
pub(crate) fn predicted_position_m(obstacle: &Obstacle, time_ns: u64) -> [f64; 2] {
    const LONGEST_S: f64 = 0.5;
    let ahead_s = (time_ns.saturating_sub(obstacle.valid_at_ns) as f64 * 1e-9).min(LONGEST_S);
    [0, 1].map(|axis| obstacle.position_in_odom_m[axis] + ahead_s * obstacle.velocity_in_odom_mps[axis])
}

fn input_ages(command: &SafeCommand) -> InputAges {
    let ledger = &command.ledger;
    let age_ms =
        |stamp_ns: u64| (stamp_ns != 0).then(|| ledger.filter_woke_ns.saturating_sub(stamp_ns) as f64 * 1e-6);
    InputAges {
        robot_state_ms: age_ms(ledger.robot_state_ingress_ns),
        detections_ms: age_ms(ledger.detections_ingress_ns),
        nominal_ms: age_ms(ledger.nominal_published_ns),
    }
}

fn neighbour(record: &RunRecord, time_s: f64) -> Option<Neighbour> {
    if time_s < 0.0 || time_s > record.duration_s() {
        return None;
    }
    let command = record.moment_at(record.stack_time_ns(time_s))?.command;
    Some(Neighbour {
        time_s: record.seconds(command.ledger.filter_woke_ns),
        status: Rung::of_code(command.status),
        reason: words::reason_label(command.reason),
        h_m: command.h_m,
        control: command.control,
        correction: correction(command),
    })
}
