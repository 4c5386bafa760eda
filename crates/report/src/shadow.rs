//! What the filter would have done where it only watched.

use std::collections::BTreeMap;

use messages::Reason;
use serde::{Deserialize, Serialize};

use crate::display::{number, percent};
use crate::{RunRecord, Rung, words};

/// Pauses shorter than this do not end a moment with h < 0, s.
const SHORTEST_PAUSE_S: f64 = 0.1;

/// What a filter that only watched would have done. The robot obeyed somebody else all the time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Shadow {
    /// Share of the time in which the filter would have changed the command because of an obstacle, 0 to 1.
    pub changed_share: f64,
    /// How often it would have begun to.
    pub changes: u64,
    /// Largest |u − u_nom| by the CBF condition, Euclidean, in the units of the control.
    pub largest_correction: f64,
    /// Moments in which h was below zero, each possibly with pauses below 0.1 s.
    pub moments_with_negative_h: u64,
    /// When the first of them began, s since the run began.
    pub first_negative_h_s: Option<f64>,
    /// Share of its cycles in which it would have braked, 0 to 1, by the label of the reason. That the robot's own controller
    /// asked for a halt is none.
    pub would_have_braked: BTreeMap<String, f64>,
}

impl Shadow {
    /// Sums up a run; `changes` are its interventions.
    pub(crate) fn of(record: &RunRecord, changes: &crate::Interventions) -> Self {
        let mut shadow = Self {
            changed_share: changes.time_share,
            changes: changes.count,
            largest_correction: changes.largest_correction,
            ..Self::default()
        };
        let commands = &record.safe_commands;
        let mut last_negative_s = f64::NEG_INFINITY;
        for command in commands {
            let time_s = record.seconds(command.ledger.filter_woke_ns);
            match Rung::of_code(command.status) {
                Rung::Filtered | Rung::Relaxed if command.h_m < 0.0 => {
                    if time_s - last_negative_s > SHORTEST_PAUSE_S {
                        shadow.moments_with_negative_h += 1;
                        shadow.first_negative_h_s.get_or_insert(time_s);
                    }
                    last_negative_s = time_s;
                }
                Rung::Braking | Rung::Stopped if command.reason != Reason::StopRequested.code() => {
                    let share = shadow.would_have_braked.entry(words::reason_label(command.reason));
                    *share.or_default() += 1.0 / commands.len() as f64;
                }
                Rung::Filtered | Rung::Relaxed | Rung::Braking | Rung::Stopped | Rung::Silent => {}
            }
        }
        shadow
    }

    /// One line: what would have been different.
    pub fn sentence(&self) -> String {
        let moments = match self.moments_with_negative_h {
            1 => "1 moment with h < 0".to_owned(),
            count => format!("{count} moments with h < 0"),
        };
        let mut braked: Vec<_> = self.would_have_braked.iter().collect();
        braked.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        let braked: Vec<_> =
            braked.iter().map(|(reason, share)| format!("{reason} {}", percent(**share))).collect();
        format!(
            "the filter would have changed {} of the time, largest |u - u_nom| {}, {moments}; would have braked for {}",
            percent(self.changed_share),
            number(self.largest_correction, 3),
            if braked.is_empty() { "no reason".to_owned() } else { braked.join(", ") }
        )
    }
}
