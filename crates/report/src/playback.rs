//! What the page's playback needs, as compact JSON: whole centimetres and centiradians, flat lists.

use serde_json::{Value, json};

use crate::birds_eye::{pose, scene_m};
use crate::explain::predicted_position_m;
use crate::finite::rounded;
use crate::plot::worst_by_column;
use crate::spans::Span;
use crate::{Moment, RunRecord, Rung, ZeroLevel, words};

/// Columns of the strip that shows the rungs over time.
const STRIP_COLUMNS: usize = 1200;

/// The data of the playback. `zero_levels` are in the order of time; each is shown until the next frame begins.
pub(crate) fn playback_data(record: &RunRecord, spans: &[Span], zero_levels: &[ZeroLevel]) -> Value {
    let times_ns = record.frame_times_ns();
    let kind = record.safe_commands.first().map_or(0, |command| command.control_kind);
    let frames: Vec<Value> = times_ns
        .iter()
        .filter_map(|&time_ns| record.moment_at(time_ns))
        .map(|moment| frame(record, &moment, level_at(zero_levels, moment.time_ns)))
        .collect();
    let goals: Vec<Value> = distinct_goals(record);
    let strip: Vec<Value> = worst_by_column(spans, record.duration_s(), STRIP_COLUMNS)
        .iter()
        .map(|span| json!([rung_index(span.rung), rounded(span.start_s, 3), rounded(span.end_s, 3)]))
        .collect();
    json!({
        "duration_s": rounded(record.duration_s(), 3),
        "robot_radius_m": record.robot_radius_m,
        "scene_m": scene_m(record).map(|corner| corner.map(|value| rounded(value, 2))),
        "rungs": Rung::ALL.map(Rung::label),
        "components": words::control_components(kind),
        "has_zero_level": !zero_levels.is_empty(),
        "goals": goals,
        "strip": strip,
        "frames": frames,
    })
}

fn frame(record: &RunRecord, moment: &Moment<'_>, level: Option<&ZeroLevel>) -> Value {
    let command = moment.command;
    let rung = Rung::of_code(command.status);
    let barrier = |value: f64| if rung.has_barrier() { rounded(value, 3) } else { None };
    let (place_m, heading_rad) = pose(moment);
    let people: Vec<i64> = moment
        .obstacles
        .map_or(&[][..], |message| message.as_slice())
        .iter()
        .filter(|person| person.is_sound())
        .flat_map(|person| {
            let [x, y] = predicted_position_m(person, moment.time_ns).map(centi);
            let [vx, vy] = person.velocity_in_odom_mps.map(centi);
            [shown_identity(person.track_id), x, y, centi(person.radius_m), vx, vy]
        })
        .collect();
    json!({
        "t": rounded(record.seconds(moment.time_ns), 3),
        "robot": [centi(place_m[0]), centi(place_m[1]), centi(heading_rad)],
        "rung": rung_index(rung),
        "why": words::reason_label(command.reason),
        "h": barrier(command.h_m),
        "sdf": barrier(command.sdf_m),
        "slack": barrier(command.slack_mps),
        "margin": barrier(command.hard_margin_mps),
        "u": command.control.map(|value| rounded(value, 3)),
        "wanted": command.nominal.map(barrier),
        "critical": shown_identity(command.critical_track_id),
        "people": people,
        "zero": level.map_or_else(Vec::new, rings),
        "grid": level.map(|level| [level.min_m.map(centi), level.max_m.map(centi)]),
    })
}

/// The level traced for this very frame.
fn level_at(levels: &[ZeroLevel], time_ns: u64) -> Option<&ZeroLevel> {
    levels.binary_search_by_key(&time_ns, |level| level.time_ns).ok().map(|index| &levels[index])
}

/// Rings as a first point and steps, cm: short numbers, no drift because the steps are between rounded points.
fn rings(level: &ZeroLevel) -> Vec<Vec<i64>> {
    level
        .rings_m
        .iter()
        .map(|ring| {
            let mut last = [0, 0];
            let mut flat = Vec::with_capacity(2 * ring.len());
            for point in ring {
                let next = point.map(centi);
                if flat.is_empty() || next != last {
                    flat.extend([next[0] - last[0], next[1] - last[1]]);
                }
                last = next;
            }
            flat
        })
        .collect()
}

/// Goals are repeated for late joiners; only changes are worth showing.
fn distinct_goals(record: &RunRecord) -> Vec<Value> {
    let mut goals: Vec<Value> = Vec::new();
    let mut last = None;
    for goal in record.goals.iter().filter(|goal| goal.is_finite()) {
        if last != Some(goal.position_in_odom_m) {
            last = Some(goal.position_in_odom_m);
            let [x, y] = goal.position_in_odom_m.map(centi);
            goals.push(json!([rounded(record.seconds(goal.stamp.published_ns).max(0.0), 3), x, y]));
        }
    }
    goals
}

/// A track's identity as a script can hold it: a number beyond 2⁵³ would be rounded, so its upper bits are cut.
fn shown_identity(track_id: u64) -> i64 {
    (track_id & ((1 << 53) - 1)).cast_signed()
}

fn rung_index(rung: Rung) -> usize {
    match rung {
        Rung::Filtered => 0,
        Rung::Relaxed => 1,
        Rung::Braking => 2,
        Rung::Stopped => 3,
        Rung::Silent => 4,
    }
}

/// Hundredths, rounded; what is not finite becomes 0.
fn centi(value: f64) -> i64 {
    (value * 100.0).round() as i64
}
