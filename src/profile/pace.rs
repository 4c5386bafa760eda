//! Whether the machine held the pace that was asked for, in plain words.

use latency::{Conditions, ProfileFigures, RepeatFigures, Statistic};
use messages::ProcessId;

use super::repeat::RepeatNotes;

/// Share of deadlines missed or frames overtaken above which a pace counts as not held.
const TOLERATED: f64 = 0.01;

/// What a reader of the figures has to know about how they came about.
pub(super) fn remarks(figures: &ProfileFigures, notes: &[RepeatNotes]) -> Vec<String> {
    let mut remarks = Vec::new();
    let conditions = &figures.conditions;
    for (index, (repeat, note)) in figures.repeats.iter().zip(notes).enumerate() {
        let mut say = |what: String| remarks.push(format!("repeat {}: {what}", index + 1));
        let missed = repeat.counts.deadline_misses;
        let cycles = repeat.counts.cycles + missed;
        if missed as f64 > TOLERATED * cycles as f64 {
            say(format!(
                "the filter's period of {} ms was not held: {missed} of {cycles} deadlines missed",
                conditions.filter_period_ns as f64 * 1e-6
            ));
        }
        let (overtaken, frames) = (note.frames_overtaken, note.frames_published);
        if overtaken as f64 > TOLERATED * frames as f64 {
            say(format!(
                "the stack did not keep up with rate {} ({:.0} frames of detections a second, {:.0} filter cycles): \
                 {overtaken} of {frames} frames were overtaken by newer ones before a command used them",
                conditions.rate,
                1e9 / frame_interval_ns(conditions),
                repeat.counts.cycles as f64 / (repeat.duration_ns as f64 * 1e-9).max(1e-9),
            ));
        }
        if let Some((late_ns, interval_ns)) = bridge_lag_ns(figures, repeat) {
            say(format!(
                "rate {} was not held: the bridge played later than the {:.2} ms between two frames, by up to {:.2} ms",
                conditions.rate,
                interval_ns as f64 * 1e-6,
                late_ns as f64 * 1e-6
            ));
        }
        let lost: u64 = repeat.loops.iter().map(|of| of.lost_records).sum();
        if lost + repeat.counts.lost_commands > 0 {
            say(format!(
                "the record is not whole: {} commands and {lost} cycle records are missing from it",
                repeat.counts.lost_commands
            ));
        }
        if !note.ends_unknown.is_empty() {
            say(format!("the record lacks the end of {}", note.ends_unknown.join(", ")));
        }
        if note.crashes > 0 {
            say(format!(
                "{} ended unexpectedly; see the logs beside {}",
                super::counted(note.crashes as u64, "process"),
                note.recording.display()
            ));
        }
        if note.interrupted {
            say("interrupted; its figures are of what ran until then".to_owned());
        }
    }
    remarks
}

/// Largest lateness of the bridge and the mean interval between two frames, ns, where the bridge's 99th percentile lies beyond
/// that interval.
fn bridge_lag_ns(figures: &ProfileFigures, repeat: &RepeatFigures) -> Option<(u64, u64)> {
    let interval_ns = frame_interval_ns(&figures.conditions) as u64;
    let bridge = repeat.loops.iter().find(|of| of.process == ProcessId::Bridge)?;
    let late_ns = bridge.lateness.statistic_ns(Statistic::P99)?;
    let most_ns = bridge.lateness.statistic_ns(Statistic::Max)?;
    (late_ns > interval_ns).then_some((most_ns, interval_ns))
}

/// Mean time between two frames as they are played, ns.
fn frame_interval_ns(conditions: &Conditions) -> f64 {
    conditions.recording.duration_s * 1e9 / conditions.rate / conditions.recording.detections.max(1) as f64
}
