//! When the filter changed what the nominal controller wanted.

use messages::SafeCommand;
use serde::{Deserialize, Serialize};

use crate::{RunRecord, Rung, Span};

/// |u − u_nom| from which on the filter counts as stepping in, Euclidean, in the units of the control.
///
/// A tenth of what a person would notice; far above the solver's accuracy.
pub const INTERVENTION_TOLERANCE: f64 = 0.02;

/// Interruptions of an intervention shorter than this do not end it, s: a filter on its boundary chatters.
const SHORTEST_PAUSE_S: f64 = 0.1;

/// The filter's corrections by the CBF condition. Braking for other reasons is not among them.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Interventions {
    /// How many, each possibly with pauses below 0.1 s.
    pub count: u64,
    /// Share of the run's time, 0 to 1.
    pub time_share: f64,
    /// Largest |u − u_nom|, Euclidean, in the units of the control.
    pub largest_correction: f64,
}

/// |u − u_nom|, Euclidean, in the units of the control.
pub(crate) fn correction(command: &SafeCommand) -> f64 {
    let [first, second] = [0, 1].map(|index| command.control[index] - command.nominal[index]);
    first.hypot(second)
}

/// Whether the filter changed this command because of an obstacle.
pub(crate) fn is_intervention(command: &SafeCommand) -> bool {
    Rung::of_code(command.status).has_barrier() && correction(command) > INTERVENTION_TOLERANCE
}

/// Counts the interventions of a run whose spans are `spans`.
pub(crate) fn interventions(record: &RunRecord, spans: &[Span]) -> Interventions {
    let mut found = Interventions::default();
    let (mut corrected_s, mut last_end_s) = (0.0, f64::NEG_INFINITY);
    for (index, command) in record.safe_commands.iter().enumerate() {
        if !is_intervention(command) {
            continue;
        }
        let start_s = record.seconds(command.ledger.filter_woke_ns);
        if start_s - last_end_s > SHORTEST_PAUSE_S {
            found.count += 1;
        }
        let period_s = record.filter_period_ns as f64 * 1e-9;
        let next_s = record
            .safe_commands
            .get(index + 1)
            .map_or(start_s + period_s, |next| record.seconds(next.ledger.filter_woke_ns));
        last_end_s = next_s.min(start_s + crate::spans::PERIODS_UNTIL_SILENT as f64 * period_s);
        corrected_s += last_end_s - start_s;
        found.largest_correction = found.largest_correction.max(correction(command));
    }
    let total_s: f64 = spans.iter().map(Span::length_s).sum();
    if total_s > 0.0 {
        found.time_share = corrected_s / total_s;
    }
    found
}
