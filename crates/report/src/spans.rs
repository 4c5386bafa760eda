//! Stretches of time during which the filter stayed on one rung of the safety ladder.

use messages::SafetyStatus;
use serde::{Deserialize, Serialize};

use crate::RunRecord;

/// A rung of the safety ladder, or the filter's silence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rung {
    /// The CBF condition holds.
    Filtered,
    /// Slack was needed.
    Relaxed,
    /// Slowing down to a halt.
    Braking,
    /// Kept standing.
    Stopped,
    /// No command came for more than five periods, or its status code is unknown to this version.
    Silent,
}

impl Rung {
    /// Every rung, from best to worst.
    pub const ALL: [Self; 5] = [Self::Filtered, Self::Relaxed, Self::Braking, Self::Stopped, Self::Silent];

    /// The rung a wire code names.
    pub fn of_code(code: u32) -> Self {
        match SafetyStatus::try_from(code) {
            Ok(SafetyStatus::Filtered) => Self::Filtered,
            Ok(SafetyStatus::Relaxed) => Self::Relaxed,
            Ok(SafetyStatus::Braking) => Self::Braking,
            Ok(SafetyStatus::Stopped) => Self::Stopped,
            Err(_) => Self::Silent,
        }
    }

    /// Name in reports.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Filtered => "filtered",
            Self::Relaxed => "relaxed",
            Self::Braking => "braking",
            Self::Stopped => "stopped",
            Self::Silent => "silent",
        }
    }

    /// Whether the barrier was evaluated, so that h and its terms mean something.
    pub const fn has_barrier(self) -> bool {
        match self {
            Self::Filtered | Self::Relaxed => true,
            Self::Braking | Self::Stopped | Self::Silent => false,
        }
    }
}

/// One stretch on one rung.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Span {
    /// Which rung.
    pub rung: Rung,
    /// Beginning, s since the run began.
    pub start_s: f64,
    /// End, s since the run began.
    pub end_s: f64,
}

impl Span {
    /// Length, s.
    pub fn length_s(&self) -> f64 {
        self.end_s - self.start_s
    }
}

/// How long a command holds at most, in filter periods: the command sinks brake after as many without a new one.
pub(crate) const PERIODS_UNTIL_SILENT: u64 = 5;

/// The run as one unbroken sequence of spans, each on another rung than its neighbours.
pub(crate) fn rung_spans(record: &RunRecord) -> Vec<Span> {
    let holds_ns = PERIODS_UNTIL_SILENT * record.filter_period_ns;
    let mut spans: Vec<Span> = Vec::new();
    let mut extend = |rung: Rung, start_ns: u64, end_ns: u64| {
        let (start_s, end_s) = (record.seconds(start_ns), record.seconds(end_ns));
        match spans.last_mut() {
            Some(last) if last.rung == rung => last.end_s = end_s,
            _ => spans.push(Span { rung, start_s, end_s }),
        }
    };
    for (index, command) in record.safe_commands.iter().enumerate() {
        let start_ns = command.ledger.filter_woke_ns;
        let next_ns = match record.safe_commands.get(index + 1) {
            Some(next) => next.ledger.filter_woke_ns.max(start_ns),
            None => start_ns + record.filter_period_ns,
        };
        let held_until_ns = next_ns.min(start_ns + holds_ns);
        extend(Rung::of_code(command.status), start_ns, held_until_ns);
        if held_until_ns < next_ns {
            extend(Rung::Silent, held_until_ns, next_ns);
        }
    }
    spans
}
